# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation of a free cell through load steps, with friction whose anchors last from one step to the next.

With friction a state of rest depends on the path that leads to it: how the fabric was held, and in which order it was
released (Crassous, Poincloux and Steinberger 2024: a relaxed knit has a line of states of rest, and friction decides
where this line ends). A path is a sequence of loads on the borders of the cell, of changes of its size, and of
coefficients of friction. Each step starts from the state of rest of the step before it, with the contacts of that
state. Normal forces are renewed until the state at rest no longer changes. The steps must be so small that the normal
forces of one step hold in the next.

A size that is drawn and held needs a force on the borders. It is -W over that size, with the forces W on the strains of
the cell (``cell_strain``), to which friction contributes.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.shared_work import shared
from stitchmesh.errors import ParameterError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.lattice import Lattice
from stitchmesh.linking.certificate import refuse_pull_through
from stitchmesh.quality import Quality
from stitchmesh.run import SHOWN, Run
from stitchmesh.time_limit import OutOfTime
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.assessment import RemainingChange
from stitchmesh.yarnrelax.checkpoint import CheckpointState, EndedStep, read_state
from stitchmesh.yarnrelax.energies.term import YarnChoice, refuse_in_free_cells
from stitchmesh.yarnrelax.fingerprint import checksum
from stitchmesh.yarnrelax.friction.friction import Friction, FrictionTerm
from stitchmesh.yarnrelax.load_position import AT_ONCE
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.model.spline import place_contact_samples
from stitchmesh.yarnrelax.observer import Observer
from stitchmesh.yarnrelax.relaxation_inputs import RelaxationInputs
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.renewal import renew_at_rest
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.cell_strain import CellStrain, RelaxCell


@dataclass(frozen=True)
class LoadStep:
    """Loads on the borders of the whole cell, how far the cell is drawn, and the share of friction."""

    course: float = 0.0
    """Load along the courses [dyn]."""
    wale: float = 0.0
    """Load along the wales [dyn]."""
    friction: float = 1.0
    """Share of the coefficient of friction."""
    stretch: tuple[float, float] = (1.0, 1.0)
    """Factors by which the step draws the cell at its beginning, along the courses and along the wales."""


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
    """Number of iterations of this step."""
    nearest: float
    """Smallest distance of yarns over their radius, at most 2."""
    border_forces: tuple[float, float]
    """Forces on the borders that hold the cell, along the courses and along the wales [dyn]."""
    device: str
    """Device on which the kernels ran."""
    seconds: float
    """Time from the start of the path to the end of this step [s], also the time before a stop."""
    history: Sequence[HistoryEntry]
    """Entries of this step, one for each assessment."""
    remaining: RemainingChange | None = None
    """Estimate of the remaining change; None if it is unknown."""
    out_of_time: bool = False
    """Whether a limit on the time ended this step before rest, and with it the path."""

    @property
    def elastic(self) -> float:
        """Energy of the yarns without the energies of friction and of the loads [erg]."""
        return sum(energy for name, energy in self.energies.items() if name not in ("friction", "tension"))


@shared
@alone()
def relax_through_steps(
    yarns: YarnSet,
    steps: Sequence[LoadStep],
    *,
    terms: Sequence[YarnChoice],
    material: YarnMaterial,
    quality: Quality,
    cell: RelaxCell,
    device: str | None = None,
    run: Run[YarnSet] = SHOWN,
) -> list[StepAtRest]:
    """Relax yarns on a lattice through load steps, and return the state of rest of each.

    If a limit on the time ends the path (``time_limit``), the result has fewer steps than were asked for. A resumed
    path has the bits of one that never stopped.

    Args:
        yarns: the yarns, without slip.
        steps: loads, drawing and friction of each step, in order.
        terms: friction with its whole coefficient, and further energies, such as a support on which the fabric lies.
        material: stiffnesses.
        quality: sampling and tolerance of each step; ``max_iterations`` holds for each step.
        cell: the changes that the periods are free to make; the steps replace its loads.
        device: "cpu", "cuda:0" ...; None for the first GPU, or the CPU if there is no GPU.
        run: progress, states and checkpoints; a control is refused.

    Raises:
        FileError: a checkpoint cannot be written, or the checkpoint to resume is missing or damaged.
        ParameterError: the yarns have no lattice, the terms have no friction or two of them, a term does not act in
            free cells, or the checkpoint belongs to another path.
        SolverError: the yarns are too close to each other, or a yarn passed through another one.
    """
    refuse_in_free_cells(terms, ())
    friction, others = friction_and_others(terms)
    run.refuse_all_but("relax_through_steps", "on_state", "checkpoints", "resume")
    began = time.perf_counter()
    inputs = RelaxationInputs(yarns, material, quality, device_named(device), [friction, *others], cell=cell)
    keeps = run.checkpoints is not None or run.resume is not None
    written = _path_fingerprint(inputs, steps) if keeps else {}
    saved = None if run.resume is None else read_state(run.resume, written)
    path = _LoadedInSteps(inputs.start(), steps, quality, () if saved is None else saved.ended)
    with run.assessments_shown("yarnrelax", quality.resting_residual, quality.max_iterations) as report_assessment:
        observer = Observer(path, run, report_assessment, written, began, ended=path.ended)
        with observer.last_state_kept():
            path.run(observer, saved)
    results = path.results(yarns, observer.history)
    refuse_pull_through(yarns, results[-1].yarns, device)
    return results


def friction_and_others(terms: Sequence[YarnChoice]) -> tuple[Friction, list[YarnChoice]]:
    """Return the term of friction, and the other terms.

    Raises:
        ParameterError: there is no term of friction, or more than one.
    """
    friction = [term for term in terms if isinstance(term, Friction)]
    if len(friction) != 1:
        found = f"relax_through_steps, terms: got {len(friction)} terms of friction"
        raise ParameterError(f"{found}; expected one Friction")
    return friction[0], [term for term in terms if term is not friction[0]]


def _path_fingerprint(inputs: RelaxationInputs, steps: Sequence[LoadStep]) -> dict[str, str]:
    """Return the inputs as short strings, with all of the quality, because each step's end decides the next start."""
    found = inputs.fingerprint()
    ends = {name: str(value) for name, value in asdict(inputs.quality).items()}
    return found | {"ends of steps": checksum("quality", ends), "steps": checksum("steps", list(steps))}


class LoadedCells:
    """Cells that are loaded together through steps, with friction as their first term."""

    def __init__(self, simulation: YarnSimulation, quality: Quality) -> None:
        """Begin with cells before their first step."""
        self.loop = RelaxationLoop(simulation, quality.tolerance, quality.largest_change)
        self.most_iterations = quality.max_iterations
        """Largest number of iterations of each step."""

    def load(self, loads: NDArray[np.float64], friction: float, stretch: tuple[float, float]) -> None:
        """Set the loads on the borders of each cell [dyn], shape (C, 2), and the share of friction; draw the cells."""
        simulation = self.loop.simulation
        term = simulation.terms[0]
        assert simulation.strain is not None and isinstance(term, FrictionTerm)
        simulation.strain.set_loads(loads)
        term.weaken(friction)
        if stretch != (1.0, 1.0):
            self._draw(simulation.strain, stretch)

    def _draw(self, strain: CellStrain, stretch: tuple[float, float]) -> None:
        """Draw the cells and their yarns along the courses and along the wales."""
        simulation = self.loop.simulation
        points, periods = (array.numpy() for array in (simulation.state.points, strain.periods))
        for cell, frame in enumerate(strain.host_frame):
            matrix = np.eye(3) + frame.T @ np.diag(np.array(stretch) - 1.0) @ frame
            own = slice(*simulation.model.point_start[cell : cell + 2])
            points[own] = points[own] @ matrix
            periods[2 * cell : 2 * cell + 2] = periods[2 * cell : 2 * cell + 2] @ matrix
        simulation.state.points.assign(points)
        strain.periods.assign(periods)
        simulation.accept(np.ones(simulation.model.cell_count, dtype=bool))
        simulation.candidates.near.invalidate()
        self.loop.search_contacts()

    def begin(self, cells: NDArray[np.bool_]) -> None:
        """Begin a step of some cells, shape (C,), from their states of rest in the step before it."""
        loop = self.loop
        loop.simulation.solver.restart(loop.step_scale, cells)
        loop.energy_fall[cells], loop.stalled[cells] = np.inf, False
        found = loop.simulation.assess_cells(cells)
        loop.last = loop.last.replaced(cells, found) if len(loop.last) else found
        loop.remaining = loop.remaining.forgotten(cells)
        if loop.newton is not None:
            loop.newton.forget(cells)

    def set_limits(self, cells: NDArray[np.bool_], before: NDArray[np.int64]) -> None:
        """Let the present step of some cells end ``max_iterations`` after the iterations ``before``, shape (C,)."""
        self.loop.most[cells] = (before + self.most_iterations)[cells]

    def unfinished(self, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which of some cells have not ended their steps, shape (C,).

        Cells at rest get new normal forces, until these no longer move them.
        """
        loop = self.loop
        renew_at_rest(loop, cells)
        ended = loop.at_rest | loop.stalled | loop.failed | (loop.iterations >= loop.most)
        return cells & ~ended

    def relax(self, before: NDArray[np.int64], note: Callable[[], None]) -> None:
        """Relax until all cells have ended their steps; ``before`` is their iterations before these steps, shape (C,).

        Raises:
            SolverError: the only cell cannot continue.
        """
        every = np.ones(self.loop.simulation.model.cell_count, dtype=bool)
        self.set_limits(every, before)
        while (left := self.unfinished(every)).any():
            self.loop.advance(left)
            note()

    def border_forces(self) -> NDArray[np.float64]:
        """Return the forces on the borders in the last accepted states, along courses and wales [dyn], shape (C, 2)."""
        simulation = self.loop.simulation
        model, state, strain = simulation.model, simulation.state, simulation.strain
        assert strain is not None
        place_contact_samples(model, state, model.launch)
        simulation.captured(
            "border forces", lambda: [*simulation.balance_launches(), *strain.sum_launches(state, model.prepare)]
        ).launch()
        periods = strain.periods.numpy().astype(np.float64).reshape(-1, 2, 3) * model.units[:, None, None]
        sizes = np.einsum("ckd,ckd->ck", periods, strain.host_frame)
        return -strain.totals.numpy()[:, :2] / sizes


class _LoadedInSteps:
    """A relaxation of one cell through load steps (``observer.Loaded``)."""

    position = AT_ONCE

    def __init__(
        self, simulation: YarnSimulation, steps: Sequence[LoadStep], quality: Quality, ended: Sequence[EndedStep]
    ) -> None:
        """Begin a path before its first step, or after some steps that have ended."""
        self.steps, self.cells = steps, LoadedCells(simulation, quality)
        self.loop = self.cells.loop
        self.ended = list(ended)
        self.out_of_time = False

    def good_yarns(self) -> YarnSet:
        """Return the last accepted state."""
        return self.loop.simulation.good_yarns()

    def run(self, observer: Observer, saved: CheckpointState | None) -> None:
        """Relax through the steps that have not ended; the first one continues from a checkpoint, if one is given."""
        for step in self.steps[len(self.ended) :]:
            self.cells.load(np.array([[step.course, step.wale]]), step.friction, step.stretch)
            if saved is None:
                self.cells.begin(np.ones(1, dtype=bool))
            else:
                observer.resume(saved)
                saved = None
            before = np.array([sum(step.iterations for step in self.ended)])
            try:
                self.cells.relax(before, observer.note)
            except OutOfTime:
                self.out_of_time = not self.loop.at_rest[0]
            self.ended.append(self._ended(observer.seconds()))
            if self.out_of_time:
                return

    def _ended(self, seconds: float) -> EndedStep:
        loop, before = self.loop, sum(step.iterations for step in self.ended)
        nearest, last = float(loop.simulation.smallest_distances()[0]), loop.last[0]
        course, wale = self.cells.border_forces()[0].tolist()
        yarns = self.good_yarns()
        assert yarns.lattice is not None
        return EndedStep(
            yarns.points, yarns.lattice.periods, last.energies, last.residual, bool(loop.at_rest[0]),
            loop.iteration - before, nearest, course, wale, seconds, loop.remaining[0],
        )  # fmt: skip

    def results(self, yarns: YarnSet, history: Sequence[HistoryEntry]) -> list[StepAtRest]:
        """Return the steps that have ended, given the yarns at their start and the history of all steps."""
        device, found, before = str(self.loop.simulation.model.device), list[StepAtRest](), 0
        for number, step in enumerate(self.ended, start=1):
            after = before + step.iterations
            own = [entry for entry in history if before < entry["iteration"] <= after]
            found.append(StepAtRest(
                replace(yarns, points=step.points, lattice=Lattice(step.periods)), step.energies, step.residual,
                step.converged, step.iterations, step.nearest, (step.course, step.wale), device, step.seconds, own,
                step.remaining, out_of_time=self.out_of_time and number == len(self.ended),
            ))  # fmt: skip
            before = after
        return found
