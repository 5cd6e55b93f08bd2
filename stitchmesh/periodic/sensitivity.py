# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How the size of a swatch at rest depends on its yarn, and how stiff the fabric is: derivatives at a state of rest.

One factorization of the Hessian gives all derivatives (``yarnrelax.rest_derivatives``). Differences would need two
relaxations for each input, and a stretch test one for each strain. The yarns are brought to rest in float64 first.

An input changes while all others stay. Let L be the loop length (all rest lengths together), r the radii, h the
distance of the planes, and dX the relative derivative of the width, or of the height, by X. Two sums follow from units.
If all stiffnesses are multiplied by one factor, all forces are too. If all lengths are, the size is too (the similarity
of Leaf et al. 2018, section 6.2):

    d k_len + d k_length + d k_bend + d k_contact = 0        without loads
    d L + d r + d h + d k_bend - 2 d k_contact
                    - d k_len - d k_length        = 1        for straight yarns; loads [dyn] fall by the same factor
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from stitchmesh.compute.device import alone
from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.lattice import Lattice, lattice_frame
from stitchmesh.mesh import FloatArray
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.drawn_cell import Direction, Other
from stitchmesh.periodic.relaxation.prepared_swatch import CellAtRest
from stitchmesh.periodic.swatch import Swatch
from stitchmesh.yarnrelax.rest_derivatives import polished, rest_derivatives


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Derivatives of a swatch at rest.

    The inputs are ``loop_length`` (the yarn of all stitches together), ``radius`` (of all yarns, at constant
    stiffnesses), ``planes`` (the distance of the planes between which the fabric lies), and the stiffnesses ``k_len``,
    ``k_length``, ``k_bend`` and ``k_contact`` of ``YarnMaterial``. Each one changes alone: loads on the borders, sizes
    that are held and natural curvatures stay. The planes are elastic with a stiffness proportional to k_bend / r^4, and
    stay so.
    """

    width: Mapping[str, float]
    """Relative change of the width over the relative change of each input."""
    height: Mapping[str, float]
    """Relative change of the height over the relative change of each input."""
    lean: Mapping[str, float]
    """Change of ``shear``, the lean of the wales, over the relative change of each input; 0 where it is held."""
    stiffness: FloatArray
    """Second derivatives of the energy over the area by the strains along courses and wales and by the shear, while the
    yarns follow [dyn/cm], shape (3, 3). Strains that are held have values too. A shear of 1 moves courses by their
    distance."""
    negative_eigenvalues: int
    """Number of significant negative eigenvalues of the Hessian."""
    residual: float
    """Relative force residual of the state that was differentiated."""
    change: float
    """Largest relative change of width and height on the way from the swatch to that state."""

    def __repr__(self) -> str:
        """Return one line: the derivatives by the loop length, the stiffness, and whether the state is a minimum."""
        by_length = f"{self.width['loop_length']:.3g} x {self.height['loop_length']:.3g} by loop length"
        course, wale, shear = self.stiffness.diagonal().tolist()
        state = "minimum" if self.minimum else "saddle"
        return f"Sensitivity({by_length}, {course:.3g}, {wale:.3g}, {shear:.3g} dyn/cm, {state})"

    @property
    def minimum(self) -> bool:
        """Whether the state is a minimum of the energy."""
        return self.negative_eigenvalues == 0

    def table(self) -> list[dict[str, Any]]:
        """Return a row for each input: its name, and the derivatives of width, height and lean."""
        return [
            {"input": name, "width": self.width[name], "height": self.height[name], "lean": self.lean[name]}
            for name in self.width
        ]

    def tension_slope(self, direction: Direction, other: Other = "free") -> float:
        """Return the slope of the tension over the strain at the begin of a stretch test [dyn/cm].

        Args:
            direction: ``course`` or ``wale``.
            other: whether the other size is ``free`` or ``held``; the lean is held.

        Raises:
            ParameterError: there is no such direction, or no such state of the other size.
        """
        if direction not in ("course", "wale") or other not in ("free", "held"):
            found = f"tension slope: got {direction!r} with the other size {other!r}"
            raise ParameterError(f"{found}; expected course or wale, and free or held")
        own = ("course", "wale").index(direction)
        across = 1 - own
        slope = self.stiffness[own, own]
        if other == "free":
            slope = slope - self.stiffness[own, across] ** 2 / self.stiffness[across, across]
        return float(slope)


@alone()
def sensitivity(swatch: Swatch) -> Sensitivity:
    """Return how the size of a swatch at rest depends on its yarn, and how stiff the fabric is.

    The result holds for the swatch as it is sampled, near its state of rest: a fabric that goes to another state
    changes by more. The yarns are brought to a residual of 1e-10 in float64 first, and ``change`` says how much this
    changes the size. Derivatives of the forces are central differences with relative steps of 1e-6, at the cost of two
    evaluations of the forces for each input; nothing is relaxed again.

    Args:
        swatch: a swatch whose size relaxes without friction (``relaxation="frictionless"``), as ``swatch`` returns it.

    Raises:
        ParameterError: the swatch was read from a file, has a constant size, or came to rest with friction.
        SolverError: the yarns do not come to rest.
    """
    rest = _differentiable(check_kind("sensitivity", swatch, Swatch).at_rest)
    loop = polished(rest.inputs)
    found, yarns = rest_derivatives(loop.simulation), loop.simulation.good_yarns()
    assert yarns.lattice is not None and rest.yarns.lattice is not None
    sizes = np.array([size_of(each) for each in (rest.yarns.lattice, yarns.lattice)])
    lean = _lean(swatch.lattice)
    strains = {name: own.tolist() for name, own in found.strains.items()}
    return Sensitivity(
        width={name: course for name, (course, _, _) in strains.items()},
        height={name: wale for name, (_, wale, _) in strains.items()},
        lean={name: shear + (course - wale) * lean for name, (course, wale, shear) in strains.items()},
        stiffness=found.stiffness * rest.gamma**2 / yarns.lattice.area,
        negative_eigenvalues=found.negative_eigenvalues,
        residual=float(loop.last.residual[0]),
        change=float(np.abs(np.log(sizes[1] / sizes[0])).max()),
    )


def _lean(lattice: Lattice) -> float:
    """Return the displacement of the wales of a repeat along the courses over its height."""
    along, across, _normal = lattice_frame(lattice.periods)
    return float(lattice.periods[1] @ along) / float(lattice.periods[1] @ across)


def _differentiable(rest: CellAtRest | None) -> CellAtRest:
    """Return a cell that has derivatives.

    Raises:
        ParameterError: there is no such state, it has a constant size, or friction has held it.
    """
    if rest is None:
        raise ParameterError("sensitivity: got a swatch that was read from a file; make it again by sm.swatch")
    if rest.rubs:
        found = "got a swatch that came off the needles with friction, whose size follows from its path"
        raise ParameterError(f"sensitivity: {found}; make it with relaxation='frictionless'")
    if rest.cell is None or not rest.cell.free.any():
        raise ParameterError("sensitivity: got a swatch of constant size; let it relax (relax_cell=True, no period)")
    return rest
