# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A free cell that is drawn to one strain after another, with or without friction between its yarns.

Each state starts from the state before it. The cell is the smallest one of its repeat (``smallest_cell``): stitches
that are alike lie alike at any strain, as they do in the free swatch. In a larger cell a rib falls over while it is
drawn: every second course turns to the other side.

Without friction a state of rest depends on the strain and on the branch. Two states are on one branch if the fabric
goes from one to the other and back again. A fabric that snaps to another shape does not go back: it is then on another
branch, with another energy at the strain before. Each new state is therefore let back by one strain and relaxed there.
If its energy differs from the earlier one by more than ``SAME_ENERGY``, the two states belong to two branches.

With friction (``load_steps``) a state depends on the whole path, because yarns that have slipped do not slip back. Each
way out, and each way back, is then a branch of its own. The cell is drawn by at most ``FRICTION_STRAIN`` at a time, so
that the normal forces of one state are still good for the next.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from stitchmesh.periodic.relaxation.continuation import change_period, size_of
from stitchmesh.periodic.relaxation.way_to_rest import relax_with_digits
from stitchmesh.quality import Quality
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.cell_stress import cell_stress
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.load_steps import LoadStep, relax_through_steps
from stitchmesh.yarnrelax.relaxation_result import Relaxation

Direction = Literal["course", "wale"]
Other = Literal["free", "held"]

SAME_ENERGY = 2e-4
"""Relative difference of energies below which two states count as one. Going back on one branch leaves 1e-5, and with
the coarse contacts of ``draft`` up to 1.2e-4; the snaps of ribs and of moss stitch leave 3e-4 or more."""
FRICTION_STRAIN = 0.02
"""Largest strain by which a cell with friction is drawn at a time."""


@dataclass(frozen=True, eq=False)
class DrawnState:
    """A cell at rest at a strain."""

    strain: float
    """Size of the cell in the direction in which it is drawn, over the size of the free cell, minus one."""
    yarns: YarnSet
    """The yarns of the cell."""
    tension: tuple[float, float]
    """Force on the borders along the courses and along the wales, each over the length of the border in the free cell
    [dyn/cm]."""
    energy: float
    """Energy of the cell [erg]."""
    residual: float
    """Relative force residual."""
    converged: bool
    """Whether the yarns are at rest."""
    branch: int
    """Number of the branch, from 1."""


@dataclass(frozen=True, eq=False)
class DrawnCell:
    """A free cell, the direction in which it is drawn, and how it comes to rest."""

    free: YarnSet
    """The yarns of the free cell, on its lattice."""
    direction: Direction
    """The direction in which the cell is drawn."""
    other: Other
    """Whether the size across is free or held."""
    material: YarnMaterial
    """Material of the yarns."""
    quality: Quality
    """Resolution of each state."""
    terms: Sequence[YarnChoice]
    """The planes between which the cell lies; empty if it lies on nothing."""
    device: str | None
    """Device of the kernels."""
    run: Run[YarnSet]
    """Progress of the relaxations."""

    @property
    def cell(self) -> RelaxCell:
        """The degrees of freedom of the cell while it is drawn."""
        pull = 0.0 if self.other == "free" else None
        return RelaxCell(None, pull, shear=False) if self.direction == "course" else RelaxCell(pull, None, shear=False)

    @property
    def free_size(self) -> tuple[float, float]:
        """Width and height of the free cell [cm]."""
        assert self.free.lattice is not None
        return size_of(self.free.lattice)

    def size_at(self, strain: float) -> tuple[float | None, float | None]:
        """Return the width and the height to set at a strain [cm]; None where the size is free."""
        width, height = self.free_size
        if self.direction == "course":
            return (1.0 + strain) * width, height if self.other == "held" else None
        return width if self.other == "held" else None, (1.0 + strain) * height


def draw_without_friction(drawn: DrawnCell, strains: Sequence[float]) -> Iterator[DrawnState]:
    """Yield the state at each strain, up to the last one that comes to rest in time.

    Raises:
        SolverError: the yarns cannot be drawn or relaxed.
    """
    found: list[DrawnState] = []
    yarns = drawn.free
    for strain in strains:
        rest = relax_at(drawn, yarns, strain)
        if rest.report["out_of_time"]:
            return
        yarns, energy = rest.yarns, rest.report["energy"]
        branch = _branch(drawn, found, strain, rest) if found else 1
        found.append(DrawnState(strain, yarns, _tension(drawn, yarns), energy, rest.report["residual"],
                                rest.report["converged"], branch))  # fmt: skip
        yield found[-1]


def relax_at(drawn: DrawnCell, yarns: YarnSet, strain: float) -> Relaxation:
    """Draw yarns to a strain and relax them.

    Raises:
        SolverError: the yarns cannot be drawn or relaxed.
    """
    given: dict[str, Any] = {"material": drawn.material, "quality": drawn.quality, "device": drawn.device}
    yarns = change_period(yarns, drawn.size_at(strain), **given)
    return relax_with_digits(yarns, cell=drawn.cell, terms=drawn.terms, run=drawn.run, **given)


def _branch(drawn: DrawnCell, found: Sequence[DrawnState], strain: float, rest: Relaxation) -> int:
    """Return the branch of a new state: of the state before it, of an equal state, or a new one."""
    before, same = found[-1], SAME_ENERGY * max(abs(state.energy) for state in found)
    equal = [each.branch for each in found
             if each.strain == strain and abs(each.energy - rest.report["energy"]) <= same]  # fmt: skip
    if before.branch in equal:
        return before.branch
    back = relax_at(drawn, rest.yarns, before.strain)
    if not back.report["converged"] or abs(back.report["energy"] - before.energy) <= same:
        return before.branch
    return equal[-1] if equal else max(state.branch for state in found) + 1


def _tension(drawn: DrawnCell, yarns: YarnSet) -> tuple[float, float]:
    """Return the nominal tensions of yarns without friction [dyn/cm]."""
    assert yarns.lattice is not None
    stress = cell_stress(
        yarns, drawn.material, quadrature_points=drawn.quality.quadrature_points,
        contact_samples=drawn.quality.contact_samples, device=drawn.device,
    )  # fmt: skip
    (width0, height0), (width, height) = drawn.free_size, size_of(yarns.lattice)
    return stress.course * height / height0, stress.wale * width / width0


def draw_with_friction(drawn: DrawnCell, strains: Sequence[float], friction: Friction) -> Iterator[DrawnState]:
    """Yield the state at each strain, up to the last one that comes to rest in time.

    No yarn has slipped before the first.

    Raises:
        SolverError: the yarns cannot be drawn or relaxed.
    """
    steps, ends, last = list[LoadStep](), list[int](), 0.0
    for strain in strains:
        whole = (1.0 + strain) / (1.0 + last)
        # Rounding error of a number of steps
        count = max(math.ceil(abs(math.log(whole)) / FRICTION_STRAIN - 1e-9), 1)
        factor = whole ** (1.0 / count)
        steps += [LoadStep(stretch=(factor, 1.0) if drawn.direction == "course" else (1.0, factor))] * count
        ends.append(len(steps) - 1)
        last = strain
    found = relax_through_steps(
        drawn.free, steps, terms=[friction, *drawn.terms], material=drawn.material, quality=drawn.quality,
        cell=drawn.cell, device=drawn.device, run=drawn.run,
    )  # fmt: skip
    width0, height0 = drawn.free_size
    for strain, end, way in zip(strains, ends, _ways(strains), strict=True):
        if end >= len(found) or found[end].out_of_time:
            return
        step, (course, wale) = found[end], found[end].border_forces
        tension = course / height0, wale / width0
        yield DrawnState(strain, step.yarns, tension, step.elastic, step.residual, step.converged, way)


def _ways(strains: Sequence[float]) -> list[int]:
    """Return the number of the way that leads to each strain, from 1; each way out and each way back counts."""
    turns = np.diff(np.sign(np.diff(strains))) != 0.0
    ways: list[int] = (1 + np.r_[0, 0, np.cumsum(turns)]).tolist()
    return ways
