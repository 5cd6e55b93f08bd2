# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation of yarns to a state of rest: the order of operations."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from stitchmesh.device import device_named
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.convergence import Assessment
from stitchmesh.yarnrelax.iteration import Iteration
from stitchmesh.yarnrelax.linking import changed_pairs, linking_certificate
from stitchmesh.yarnrelax.material import REFERENCE_RADIUS, YarnMaterial

CHECK = 20
"""Iterations between two assessments."""
ON_STATE_SECONDS = 5.0
"""Time between two good states handed out for saving."""
PROGRESS_SECONDS = 0.5
"""Time between two reports of progress."""
RISE = 0.05
"""Rise of the energy between two assessments, over its size, that makes a relaxation back off."""

Progress = Callable[[int, float, float], None]
"""Called with iteration, residual and energy [erg]."""


@dataclass(frozen=True)
class Relaxation:
    """Relaxed yarns and how they came about."""

    yarns: YarnSet
    """The yarns at rest."""
    report: dict[str, Any]
    """seconds, iterations, converged, residual, energy [erg], energies [erg], max_strain, min_distance_over_radius
    (2 where no yarns touch), pull_throughs, certificate ("changed" where an open yarn's end slipped out), device."""


def relax_yarns(
    yarns: YarnSet,
    *,
    material: YarnMaterial | None = None,
    quality: str | Quality = "standard",
    device: str | None = None,
    keep_shape: StitchMesh | None = None,
    progress: Progress | None = None,
    on_state: Callable[[YarnSet], None] | None = None,
) -> Relaxation:
    """Relax yarns to a state of rest without letting any pass through another.

    Args:
        yarns: the yarns, without a lattice, no two of them touching by more than half their thickness.
        material: stiffnesses; the material ``stitchmesh`` scaled to the yarns' radius where not given.
        quality: a preset or a ``Quality``.
        device: "cpu", "cuda:0" ...; the first GPU, else the CPU, where not given.
        keep_shape: the fabric that the yarns were made from, whose borders and shape are to be kept.
        progress: called every half second or so with iteration, residual and energy.
        on_state: called every few seconds, and when the relaxation ends early, with the last good state.

    Raises:
        ParameterError: yarns on a lattice, an unknown device or quality, or a fabric that is not the yarns' own.
        SolverError: the relaxation cannot go on, or a yarn passed through another; it names yarn and stitch face.
    """
    began = time.perf_counter()
    quality = quality_named(quality)
    if yarns.lattice is not None:
        raise ParameterError("yarns: got a set with a lattice; relaxation takes yarns without one")
    if material is None:
        gamma = float(yarns.radius.mean()) / REFERENCE_RADIUS
        material = YarnMaterial.named("stitchmesh").scaled(gamma)
    solver = Iteration.start(yarns, material, quality, device_named(device), keep_shape)
    before = linking_certificate(yarns)
    watch = _Watch(progress, on_state)
    try:
        iterations, assessment = _iterate(solver, quality, watch)
    except (KeyboardInterrupt, SolverError):
        if on_state is not None:
            on_state(solver.good_yarns())
        raise
    relaxed = solver.good_yarns()
    _refuse_pull_through(yarns, changed_pairs(before, linking_certificate(relaxed)))
    return Relaxation(
        relaxed,
        {
            "seconds": time.perf_counter() - began,
            "iterations": iterations,
            "converged": assessment.residual < quality.tolerance,
            "residual": assessment.residual,
            "energy": assessment.energy,
            "energies": assessment.energies,
            "max_strain": float(np.abs(relaxed.strain).max()),
            "min_distance_over_radius": solver.smallest_distance(),
            "pull_throughs": 0,
            "certificate": "unchanged",
            "device": str(solver.model.device),
        },
    )


def _iterate(solver: Iteration, quality: Quality, watch: _Watch) -> tuple[int, Assessment]:
    """Run bursts of iterations until the yarns are at rest; the last state is a good one."""
    last = solver.assess()
    if not last.finite:
        raise SolverError(f"{solver.blame()}: not finite at the start; move the yarns apart")
    iteration = 0
    while last.residual >= quality.tolerance and iteration < quality.max_iterations:
        solver.run(CHECK)
        iteration += CHECK
        now = solver.assess()
        if now.finite and now.energy <= last.energy + RISE * abs(last.energy) + solver.noise:
            solver.keep()
            last = now
        else:
            solver.back_off()
        watch.look(iteration, last, solver)
    return iteration, last


def _refuse_pull_through(yarns: YarnSet, changed: IntArray) -> None:
    """Raise where the linking of two closed yarns changed; open yarns' may, as others pass their ends."""
    for first, second in changed:
        if yarns.closed[first] and yarns.closed[second]:
            faces = [sorted(set(yarns.face[yarns.start[y] : yarns.start[y + 1]].tolist()))[:3] for y in (first, second)]
            where = f"yarns {first} and {second} (stitch faces {faces[0]} ... and {faces[1]} ...)"
            raise SolverError(f"{where}: their linking number changed; report this with the yarns, it must not happen")


@dataclass(eq=False)
class _Watch:
    """Tells the caller how far the relaxation is, not too often."""

    progress: Progress | None
    on_state: Callable[[YarnSet], None] | None
    reported: float = 0.0
    saved: float = 0.0

    def look(self, iteration: int, last: Assessment, solver: Iteration) -> None:
        """Report after half a second, hand out the state after a few."""
        now = time.perf_counter()
        if self.progress is not None and now - self.reported > PROGRESS_SECONDS:
            self.reported = now
            self.progress(iteration, last.residual, last.energy)
        if self.on_state is not None and now - self.saved > ON_STATE_SECONDS:
            self.saved = now
            self.on_state(solver.good_yarns())
