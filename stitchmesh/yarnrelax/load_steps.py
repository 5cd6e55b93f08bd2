# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation of a free cell through load steps, with friction whose anchors last from one step to the next.

With friction a state of rest depends on the path that leads to it: what held the fabric, and in which order it was let
go (Crassous, Poincloux and Steinberger 2024: a relaxed knit has a line of states of rest, of which friction sets the
end). A path is a sequence of loads on the borders of the cell and of coefficients of friction. Each step starts from
the state of rest of the step before it, with its contacts; normal forces are renewed until the state at rest no longer
changes. The steps must be small enough for the normal forces of one step to hold in the next.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stitchmesh.compute.device import alone, device_named
from stitchmesh.io.history import HistoryEntry
from stitchmesh.quality import Quality
from stitchmesh.time_limit import OutOfTime
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.energies.term import TermChoice, refuse_in_free_cells
from stitchmesh.yarnrelax.friction.friction import Friction, FrictionTerm
from stitchmesh.yarnrelax.linking.certificate import refuse_pull_through
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell


@dataclass(frozen=True)
class LoadStep:
    """Loads on the borders of the whole cell, and the friction that is left."""

    course: float = 0.0
    """Load along the courses [dyn]."""
    wale: float = 0.0
    """Load along the wales [dyn]."""
    friction: float = 1.0
    """Share of the coefficient of friction."""


@dataclass(frozen=True, eq=False)
class StepAtRest:
    """The result of a load step."""

    yarns: YarnSet
    """The yarns at rest, or in their last accepted state."""
    energies: dict[str, float]
    """Energy of each term [erg]."""
    residual: float
    """Relative force residual."""
    converged: bool
    """Whether the yarns are at rest."""
    iterations: int
    """Iterations of this step."""
    nearest: float
    """Smallest distance of yarns over their radius, at most 2."""
    device: str
    """Where the kernels ran."""
    out_of_time: bool = False
    """Whether a limit on the time ended this step before rest."""

    @property
    def elastic(self) -> float:
        """Energy of the yarns without that of friction and of the loads [erg]."""
        return sum(energy for name, energy in self.energies.items() if name not in ("friction", "tension"))


@alone()
def relax_through_steps(
    yarns: YarnSet,
    steps: Sequence[LoadStep],
    *,
    friction: Friction,
    material: YarnMaterial,
    quality: Quality,
    cell: RelaxCell,
    device: str | None = None,
    terms: Sequence[TermChoice] = (),
    note: Callable[[HistoryEntry], None] = lambda _entry: None,
) -> list[StepAtRest]:
    """Relax yarns on a lattice through load steps, and return the state of rest of each.

    Args:
        yarns: the yarns, without slip.
        steps: loads and friction, one after the other.
        friction: friction of the whole coefficient.
        material: stiffnesses.
        quality: sampling and tolerance of each step; ``max_iterations`` holds for each step.
        cell: which changes the periods are free to make; its loads are those of the steps.
        device: as for ``relax_yarns``.
        terms: further energies, such as what the fabric lies on.
        note: called with the entry of each assessment.

    Raises:
        ParameterError: the yarns have no lattice, or a term does not act in free cells.
        SolverError: the yarns are too close to each other, or a yarn passed through another one.
    """
    refuse_in_free_cells(terms, ())
    simulation = YarnSimulation.start(yarns, material, quality, device_named(device), [friction, *terms], cell=cell)
    loop, began = RelaxationLoop(simulation, quality.tolerance, quality.largest_change), time.perf_counter()

    def note_assessment() -> None:
        last, seconds = loop.last[0], time.perf_counter() - began
        note(HistoryEntry(iteration=loop.iteration, seconds=seconds, residual=last.residual, energies=last.energies))

    results = [_rest_at(loop, step, quality, note_assessment) for step in steps]
    refuse_pull_through(yarns, results[-1].yarns, device)
    return results


def _rest_at(loop: RelaxationLoop, step: LoadStep, quality: Quality, note: Callable[[], None]) -> StepAtRest:
    """Change loads and friction, and relax."""
    simulation, before = loop.simulation, loop.iteration
    term = simulation.terms[0]
    assert simulation.strain is not None and isinstance(term, FrictionTerm)
    simulation.strain.set_loads(np.array([[step.course, step.wale]]))
    term.weaken(step.friction)
    simulation.discard_launches()
    simulation.solver.restart(loop.step_scale)
    loop.energy_fall[:] = np.inf
    loop.last = simulation.assess_cells()
    most = before + quality.max_iterations
    out_of_time = False
    try:
        loop.run(most, note)
        while loop.at_rest[0] and loop.renew_terms() and loop.last[0].residual >= quality.tolerance:
            loop.run(most, note)
    except OutOfTime:
        out_of_time = not loop.at_rest[0]
    last, count = loop.last[0], loop.iteration - before
    nearest = float(simulation.smallest_distances()[0])
    yarns, device, at_rest = simulation.good_yarns(), str(simulation.model.device), bool(loop.at_rest[0])
    return StepAtRest(yarns, last.energies, last.residual, at_rest, count, nearest, device, out_of_time)
