# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation of yarns to a state of rest: the order of operations."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stitchmesh.device import device_named
from stitchmesh.errors import SolverError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.borders import KeepBorders
from stitchmesh.yarnrelax.convergence import Assessment
from stitchmesh.yarnrelax.iteration import Iteration
from stitchmesh.yarnrelax.linking import changed_pairs, doubled_linking
from stitchmesh.yarnrelax.material import REFERENCE_RADIUS, YarnMaterial
from stitchmesh.yarnrelax.shape import KeepShape
from stitchmesh.yarnrelax.term import ConstraintChoice, TermChoice

CHECK = 20
"""Iterations between two assessments."""
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


def relax_yarns(
    yarns: YarnSet,
    *,
    material: YarnMaterial | None = None,
    quality: str | Quality = "standard",
    device: str | None = None,
    keep_shape: StitchMesh | None = None,
    terms: Sequence[TermChoice] = (),
    constraints: Sequence[ConstraintChoice] = (),
    progress: Progress | None = None,
    on_state: Callable[[YarnSet], None] | None = None,
) -> Relaxation:
    """Relax yarns to a state of rest without letting any pass through another.

    A relaxation that stops at ``Quality.max_iterations`` says so in one line of its log, and in its report.

    Args:
        yarns: the yarns, on a lattice or not, no two of them touching by more than half their thickness.
        material: stiffnesses; the material ``stitchmesh`` scaled to the yarns' radius where not given.
        quality: a preset or a ``Quality``.
        device: "cpu", "cuda:0" ...; the first GPU, else the CPU, where not given.
        keep_shape: the fabric that the yarns were made from, whose borders and shape are to be kept.
        terms: more energies, such as gravity; a term that is not given costs nothing.
        constraints: what holds control points.
        progress: called every half second or so.
        on_state: called every few seconds, and when the relaxation ends early, with the last good state.

    Raises:
        ParameterError: an unknown device or quality, or a fabric, a term or a constraint that does not fit the yarns.
        SolverError: the relaxation cannot go on, or a yarn passed through another; it names yarn and stitch face.
    """
    began = time.perf_counter()
    quality = quality_named(quality)
    if material is None:
        material = YarnMaterial.named("stitchmesh").scaled(float(yarns.radius.mean()) / REFERENCE_RADIUS)
    if keep_shape is not None:
        terms, constraints = [*terms, KeepShape(keep_shape)], [*constraints, KeepBorders(keep_shape)]
    solver = Iteration.start(yarns, material, quality, device_named(device), terms, constraints)
    linking = doubled_linking(yarns, device=device)
    run = _Run(solver, quality, progress, on_state, began)
    try:
        run.to_rest()
    except (KeyboardInterrupt, SolverError):
        if on_state is not None:
            on_state(solver.good_yarns())
        raise
    relaxed = solver.good_yarns()
    _refuse_pull_through(yarns, changed_pairs(linking, doubled_linking(relaxed, device=device)))
    return Relaxation(relaxed, _report(run, relaxed), run.history)


def _report(run: _Run, relaxed: YarnSet) -> dict[str, Any]:
    return {
        "seconds": time.perf_counter() - run.began,
        "iterations": run.iteration,
        "converged": run.last.residual < run.quality.tolerance,
        "residual": run.last.residual,
        "energy": run.last.energy,
        "energies": run.last.energies,
        "max_strain": float(np.abs(relaxed.strain).max()),
        "min_distance_over_radius": run.solver.smallest_distance(),
        "pull_throughs": 0,
        "certificate": "unchanged",
        "solver": run.quality.solver,
        "device": str(run.solver.model.device),
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

    solver: Iteration
    quality: Quality
    progress: Progress | None
    on_state: Callable[[YarnSet], None] | None
    began: float
    iteration: int = 0
    last: Assessment = field(init=False)
    history: list[HistoryEntry] = field(default_factory=list)
    reported: float = 0.0
    saved: float = 0.0

    def to_rest(self) -> None:
        """Iterate until the yarns are at rest; the last state is a good one."""
        self.last = self.solver.assess()
        if not self.last.finite:
            raise SolverError(f"{self.solver.blame()}: not finite at the start; move the yarns apart")
        self._note()
        while self.last.residual >= self.quality.tolerance and self.iteration < self.quality.max_iterations:
            self.solver.run(CHECK)
            self.iteration += CHECK
            self.last = self._judged(self.solver.assess())
            self._note()
        if self.last.residual >= self.quality.tolerance:
            found = f"residual {self.last.residual:.2g} after {self.iteration} iterations"
            logger.warning("yarns are not at rest: %s; expected %g; raise max_iterations", found, self.quality.tolerance)

    def _judged(self, now: Assessment) -> Assessment:
        """Keep a good state; go back to the one before where the energy is not finite or rose too far."""
        solver, last = self.solver, self.last
        allowed = solver.method.allowed_rise * abs(last.energy) + solver.noise
        if now.finite and now.energy <= last.energy + allowed:
            solver.keep()
            return now
        solver.back_off()
        return last

    def _note(self) -> None:
        """Add to the history; report after half a second, hand out the state after a few."""
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
            self.on_state(self.solver.good_yarns())
