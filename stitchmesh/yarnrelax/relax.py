# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation of yarns to a state of rest: the order of operations."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.device import alone, device_named
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.io.contents import FilePath
from stitchmesh.io.history import HistoryEntry
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.checkpoint import Checkpoints, CheckpointState, origin, read_state, write_state
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.convergence import FALL, Assessment
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.energies.term import ConstraintChoice, TermChoice
from stitchmesh.yarnrelax.linking.certificate import changed_pairs, doubled_linking
from stitchmesh.yarnrelax.model.material import REFERENCE_RADIUS, YarnMaterial
from stitchmesh.yarnrelax.relaxation_loop import ASSESSMENT_INTERVAL, RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell

ON_STATE_SECONDS = 5.0
"""Time between two good states handed out for saving."""
PROGRESS_SECONDS = 0.5
"""Time between two reports of progress."""

Progress = Callable[[HistoryEntry], None]
"""Called with iteration, seconds, residual and energies by term [erg]."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Relaxation:
    """Relaxed yarns and how they came about."""

    yarns: YarnSet
    """The yarns at rest."""
    report: dict[str, Any]
    """seconds, iterations, converged, residual, energy [erg], energies [erg], max_strain, min_distance_over_radius
    (2 where no yarns touch), pull_throughs, certificate, solver, device."""
    history: list[HistoryEntry]
    """What each assessment found."""


@alone()
def relax_yarns(
    yarns: YarnSet,
    *,
    start: YarnSet | None = None,
    material: YarnMaterial | None = None,
    quality: str | Quality = "standard",
    device: str | None = None,
    keep_shape: StitchMesh | None = None,
    terms: Sequence[TermChoice] = (),
    constraints: Sequence[ConstraintChoice] = (),
    cell: RelaxCell | None = None,
    progress: Progress | None = None,
    on_state: Callable[[YarnSet], None] | None = None,
    checkpoint: Checkpoints | None = None,
    resume: FilePath | None = None,
) -> Relaxation:
    """Relax yarns to a state of rest without letting any pass through another.

    A relaxation that stops at ``Quality.max_iterations`` says so in one line of its log, and in its report. One that is
    resumed ends in the same bits as if it had never been stopped, and counts its iterations and seconds from the start.

    Args:
        yarns: the yarns, on a lattice or not, no two of them touching by more than half their thickness; shape and
            borders are kept as they lie here.
        start: the same yarns, linked in the same way, in another place to start from: relaxed before an edit, say.
        material: stiffnesses; the material ``stitchmesh`` scaled to the yarns' radius where not given.
        quality: a preset or a ``Quality``.
        device: "cpu", "cuda:0" ...; the first GPU, else the CPU, where not given.
        keep_shape: the fabric that the yarns were made from, whose borders and shape are to be kept.
        terms: more energies, such as gravity; a term that is not given costs nothing.
        constraints: what holds control points.
        cell: what the periods of the lattice are free to do; they are kept where not given. No terms or constraints
            go with it, for they know nothing of a cell that deforms.
        progress: called every half second or so.
        on_state: called every few seconds, and when the relaxation ends early, with the last good state.
        checkpoint: where and how often to write down what it takes to resume; also at the start and at any end.
        resume: a checkpoint to go on from; all else must be given as it was when that was written.

    Raises:
        FileError: a checkpoint cannot be written, or the one to resume is missing or damaged.
        ParameterError: an unknown device or quality, or a fabric, a start, a term or a constraint that does not fit the
            yarns, or a checkpoint of another relaxation.
        SolverError: the relaxation cannot go on, or a yarn passed through another; it names yarn and stitch face.
    """
    began = time.perf_counter()
    quality = quality_named(quality)
    if material is None:
        material = YarnMaterial.named("stitchmesh").scaled(float(yarns.radius.mean()) / REFERENCE_RADIUS)
    if keep_shape is not None:
        terms, constraints = [*terms, KeepShape(keep_shape)], [*constraints, KeepBorders(keep_shape)]
    points = None if start is None else _points_of(start, yarns)
    if cell is not None and (terms or constraints):
        raise ParameterError("relax cell: got terms or constraints beside it; leave them out, or keep the periods")
    simulation = YarnSimulation.start(yarns, material, quality, device_named(device), terms, constraints, points, cell)
    linking = doubled_linking(yarns, device=device)
    given: dict[str, str] = {}
    if checkpoint is not None or resume is not None:
        given = origin(yarns, material, quality, simulation.model.device, terms, constraints, cell, simulation.arrays())
    run = _Run(simulation, quality, progress, on_state, began, checkpoint, given)
    if resume is not None:
        run.resume(read_state(resume, given))
    try:
        run.to_rest()
    except (KeyboardInterrupt, SolverError):
        run.hand_over()
        raise
    relaxed = simulation.good_yarns()
    _refuse_pull_through(yarns, changed_pairs(linking, doubled_linking(relaxed, device=device)))
    return Relaxation(relaxed, _report(run, relaxed), run.history)


@alone()
def relax_partly(
    yarns: YarnSet, *, material: YarnMaterial, quality: Quality, iterations: int, device: str | None = None,
    cell: RelaxCell | None = None,
) -> YarnSet:  # fmt: skip
    """Yarns after some iterations towards rest, for changes that are made step by step; arguments as ``relax_yarns``.

    Raises:
        SolverError: the relaxation cannot go on.
    """
    simulation = YarnSimulation.start(yarns, material, quality, device_named(device), cell=cell)
    run = _Run(simulation, replace(quality, max_iterations=iterations), None, None, time.perf_counter(), None, {})
    run.descend()
    return simulation.good_yarns()


@alone()
def refuse_pull_through(drawn: YarnSet, relaxed: YarnSet, device: str | None = None) -> None:
    """Check that yarns are linked as they were drawn.

    Raises:
        SolverError: two of them are not; it names them.
    """
    changed = changed_pairs(doubled_linking(drawn, device=device), doubled_linking(relaxed, device=device))
    _refuse_pull_through(drawn, changed)


def _points_of(start: YarnSet, yarns: YarnSet) -> FloatArray:
    """Control points to start from [cm]."""
    if not (np.array_equal(start.start, yarns.start) and np.array_equal(start.closed, yarns.closed)):
        found = f"{start.yarn_count} yarns of {len(start.points)} control points"
        expected = f"{yarns.yarn_count} of {len(yarns.points)}, closed where they are"
        raise ParameterError(f"start: got {found}; expected the same yarns, {expected}")
    return start.points


def _report(run: _Run, relaxed: YarnSet) -> dict[str, Any]:
    return {
        "seconds": time.perf_counter() - run.began,
        "iterations": run.iteration,
        "converged": run.at_rest,
        "residual": run.last.residual,
        "energy": run.last.energy,
        "energies": run.last.energies,
        "max_strain": float(np.abs(relaxed.strain).max()),
        "min_distance_over_radius": run.simulation.smallest_distance(),
        "pull_throughs": 0,
        "certificate": "unchanged",
        "solver": run.quality.solver,
        "device": str(run.simulation.model.device),
    }


def _refuse_pull_through(yarns: YarnSet, changed: IntArray) -> None:
    """Raise where the linking of two closed yarns changed; open yarns' may, as others pass their ends."""
    for first, second in changed:
        if yarns.closed[first] and yarns.closed[second]:
            faces = [sorted(set(yarns.face[yarns.start[y] : yarns.start[y + 1]].tolist()))[:3] for y in (first, second)]
            where = f"yarns {first} and {second} (stitch faces {faces[0]} ... and {faces[1]} ...)"
            raise SolverError(f"{where}: their linking number changed; report this with the yarns, it must not happen")


@dataclass(eq=False)
class _Run:
    """A relaxation under way: it tells the caller how far it is, not too often."""

    simulation: YarnSimulation
    quality: Quality
    progress: Progress | None
    on_state: Callable[[YarnSet], None] | None
    began: float
    checkpoint: Checkpoints | None
    given: Mapping[str, str]
    iteration: int = 0
    descent: RelaxationLoop | None = None
    """From the first assessment on."""
    history: list[HistoryEntry] = field(default_factory=list)
    moment: CheckpointState | None = None
    """The last assessment's, until it is written down."""
    reported: float = 0.0
    saved: float = 0.0

    def resume(self, moment: CheckpointState) -> None:
        """Go on from a moment of the same relaxation."""
        simulation, step_scale = self.simulation, np.array([moment.step_scale])
        simulation.resume(moment.arrays, margin=moment.margin, age=moment.age, step_scale=step_scale)
        self.iteration, self.history = moment.iteration, list(moment.history)
        self.began -= moment.seconds
        self.descent = RelaxationLoop(simulation, self.quality.tolerance, [moment.last], np.array([moment.energy_fall]))
        self.descent.moving = simulation.solver.kinetic_energy()

    def to_rest(self) -> None:
        """Iterate until the yarns are at rest; the last state is a good one."""
        self.descend()
        # what lags behind, such as the normal forces of friction, follows until that changes nothing any more
        while self.at_rest and self.simulation.renew():
            assert self.descent is not None
            self.descent.last[0] = self.simulation.assess()
            if self.last.residual < self.quality.tolerance:
                break
            self.descend()
        self.write_down()
        if not self.at_rest:
            expected = self.quality.tolerance
            found = f"residual {self.last.residual:.2g} (expected {expected:g})"
            falling = f"falling by {self.energy_fall:.2g} of itself" if np.isfinite(self.energy_fall) else "not level"
            slope = f"energy {falling} (expected {FALL * expected:g})"
            where = f"{found}, {slope} after {self.iteration} iterations"
            logger.warning("yarns are not at rest: %s; %s", where, self.last.remedy)

    def hand_over(self) -> None:
        """Hand out the last good state, and write a checkpoint of the last assessment."""
        if self.on_state is not None:
            self.on_state(self.simulation.good_yarns())
        self.write_down()

    @property
    def last(self) -> Assessment:
        """What is known of the last good state."""
        assert self.descent is not None
        return self.descent.last[0]

    @property
    def energy_fall(self) -> float:
        """Part of itself by which the energy fell in the last burst."""
        assert self.descent is not None
        return float(self.descent.energy_fall[0])

    @property
    def at_rest(self) -> bool:
        """Whether both conditions of ``convergence`` hold."""
        return self.descent is not None and bool(self.descent.at_rest[0])

    def descend(self) -> None:
        """Iterate until the yarns are at rest, or the iterations are used up.

        Raises:
            SolverError: the energy is not finite, or the relaxation cannot go on.
        """
        if self.descent is None:
            self.descent = RelaxationLoop.start(self.simulation, self.quality.tolerance)
            self._note()
        while not self.at_rest and self.iteration < self.quality.max_iterations:
            self.descent.advance()
            self.iteration += ASSESSMENT_INTERVAL
            self._note()

    def write_down(self) -> None:
        """Write a checkpoint of the last assessment, unless that has been done."""
        if self.checkpoint is not None and self.moment is not None:
            write_state(self.checkpoint.path, self.given, self.moment)
            self.moment = None

    def _note(self) -> None:
        """Add to the history; report after half a second, hand out the state after a few, write checkpoints."""
        now = time.perf_counter()
        entry = HistoryEntry(
            iteration=self.iteration,
            seconds=now - self.began,
            residual=self.last.residual,
            energies=self.last.energies,
        )
        self.history.append(entry)
        if self.progress is not None and now - self.reported > PROGRESS_SECONDS:
            self.reported = now
            self.progress(entry)
        if self.on_state is not None and now - self.saved > ON_STATE_SECONDS:
            self.saved = now
            self.on_state(self.simulation.good_yarns())
        if self.checkpoint is not None:
            self.moment = self._moment(now)
            if self.iteration % (-(-self.checkpoint.every // ASSESSMENT_INTERVAL) * ASSESSMENT_INTERVAL) == 0:
                self.write_down()

    def _moment(self, now: float) -> CheckpointState:
        """Copies of all that decides how the relaxation goes on; they stay what they are while it does."""
        simulation = self.simulation
        return CheckpointState(
            iteration=self.iteration,
            seconds=now - self.began,
            last=self.last,
            history=tuple(self.history),
            margin=simulation.candidates.margin,
            age=simulation.age,
            step_scale=float(simulation.step_scale[0]),
            energy_fall=self.energy_fall,
            arrays={name: wp.clone(array) for name, array in simulation.arrays().items()},
        )
