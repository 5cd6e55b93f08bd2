# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Point load: a constant force on some control points, for example from a hand or a suspended weight.

The control points share the force F evenly. It is a dead load with the energy

    f_i = F / n,    E = - sum over the n control points of  f_i . q_i        [erg]

Places are relative to the middle of the given yarns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import vector
from stitchmesh.compute.reduction import ordered_sum
from stitchmesh.errors import ParameterError
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.energies.term import Term, TermChoice
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.point_selection import select_points
from stitchmesh.yarnrelax.model.state import State


@kernel
def add_point_load(
    # model
    loaded: wp.array[wp.int32],
    share: Any,
    # state out
    external_force: wp.array[Any],
) -> None:
    """Add the share of each loaded control point to the force [erg / unit]."""
    k = wp.tid()
    external_force[loaded[k]] += share


@kernel
def point_load_energies(
    # model
    loaded: wp.array[wp.int32],
    share: Any,
    # state in
    points: wp.array[Any],
    # state out
    point_energy: wp.array[Any],
) -> None:
    """Potential energy [erg] of each loaded control point."""
    k = wp.tid()
    point_energy[k] = -wp.dot(share, points[loaded[k]])


@dataclass(frozen=True, eq=False)
class PointLoad(TermChoice):
    """A force on control points that are selected by number, by stitch face, or both.

    Raises:
        ParameterError: the force is not three finite numbers.
    """

    force: tuple[float, float, float]
    """The whole force [dyn]."""
    points: Sequence[int] | NDArray[np.integer[Any]] = ()
    """Numbers of control points."""
    faces: Sequence[int] | NDArray[np.integer[Any]] = ()
    """Stitch faces, all of whose control points are loaded (``YarnSet.face``)."""

    def __post_init__(self) -> None:
        if np.shape(self.force) != (3,) or not np.isfinite(self.force).all():
            raise ParameterError(f"point load: got force {self.force}; expected three finite numbers [dyn]")

    def on(self, model: Model) -> Term:
        """Return the load on a model's yarns.

        Raises:
            ParameterError: a control point or a stitch face does not exist, or nothing is selected.
        """
        return _PointLoad(model, select_points("point load", model.yarns, self.points, self.faces), self.force)


class _PointLoad(Term):
    """A point load on a device."""

    name = "point load"
    gives_hessian = True

    def __init__(self, model: Model, points: NDArray[np.int64], force: tuple[float, float, float]) -> None:
        self.model = model
        self.loaded = model.integers(points)
        # cm in units: dyn times this is a force [erg / unit]
        self.share = vector(3, model.scalar)(*(float(f) * model.unit / len(points) for f in force))

    def forces(self, state: State, candidates: Candidates, launcher: Launcher) -> list[Any]:
        """Return the launch that adds the shares to ``state.external_force``."""
        return [launcher(add_point_load, len(self.loaded), [self.loaded, self.share], [state.external_force])]

    def energy(self, state: State, candidates: Candidates) -> float:
        """Potential energy [erg]."""
        energy = self.model.empty(len(self.loaded))
        self.model.launch(point_load_energies, len(self.loaded), [self.loaded, self.share, state.points], [energy])
        return ordered_sum(energy)

    def stiffness(self) -> NDArray[np.float64]:
        """Zero, because the force does not depend on the position."""
        return np.zeros(self.model.point_count)
