# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A scene with triangles alone, which says where yarns are needed, and where the yarns of a static scene may begin.

The error of each triangle is the largest one over the frames of a motion, or over the equilibria of a static run
(``placement.error_indicator``).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray
from stitchmesh.mixed.dynamics.equilibrium import AfterIteration, search_progress
from stitchmesh.mixed.output.report import RunTotals
from stitchmesh.mixed.placement.error_indicator import indicate_errors
from stitchmesh.mixed.placement.triangle_deformation import shares_of
from stitchmesh.mixed.scene.scene_fabric import PreparedScene
from stitchmesh.mixed.simulation import Simulation, begin_simulation
from stitchmesh.progress import Progress, no_progress
from stitchmesh.run_control import RunStopped
from stitchmesh.time_limit import check_time

STAGE = "triangles"
"""Name of the stage in reports of progress."""
Numbers = NDArray[np.float64]


AfterStep = Callable[[Simulation, int, float], None]
"""Called after each step in time, or each iteration of a search for an equilibrium, with the simulation, the number of
iterations so far, and the error of the state [cm/s or dyn]. ``RunStopped`` ends the run."""


def unwatched(simulation: Simulation, iterations: int, error: float) -> None:
    """Do nothing after a step (an ``AfterStep`` function)."""


@dataclass(frozen=True, eq=False)
class TriangleRun:
    """What a run with triangles alone leaves."""

    end: Simulation
    """Its end, or where it was stopped."""
    error: Numbers
    """The largest error of each triangle [erg], shape (T,)."""
    totals: RunTotals
    """Its work."""
    stopped: bool = False
    """Whether the user or the time stopped it."""

    @property
    def vertices(self) -> FloatArray:
        """Vertices at its end [cm], shape (V, 3)."""
        return self.end.positions[0]


def run_triangles(
    prepared: PreparedScene,
    scalar: Any,
    device: wp.Device,
    *,
    progress: Progress = no_progress,
    after_step: AfterStep = unwatched,
) -> TriangleRun:
    """Run a scene with triangles alone, whatever its region is.

    Args:
        prepared: the scene.
        scalar: Warp's floating-point type.
        device: where the scene runs.
        progress: called with the completed part and a line of text.
        after_step: called after each step or iteration.

    Raises:
        SolverError: no time step is small enough.
    """
    scene, began = prepared.scene, time.perf_counter()
    simulation = begin_simulation(replace(prepared, region=prepared.without_yarns), scalar, device)
    errors, totals, stopped = _Errors(prepared), RunTotals(), False

    def watch(iterations: int, error: float) -> None:
        check_time()
        after_step(simulation, totals.newton_iterations + iterations, error)

    def after_iteration(report: AfterIteration, iterations: int, force: float) -> None:
        report(iterations, force)
        watch(iterations, force)

    try:
        while not simulation.done:
            search = search_progress(
                STAGE, totals.steps, scene.load_steps, progress,
                tolerance=simulation.tolerance, most_iterations=scene.solver.most_iterations,
            )  # fmt: skip
            simulation.step(partial(after_iteration, search)).add_to(totals)
            errors.look(simulation)
            progress(STAGE, min(simulation.time / scene.duration, 1.0), f"time {simulation.time:.4g} s")
            watch(0, totals.error)
    except RunStopped:
        stopped = not simulation.done
    totals.seconds = time.perf_counter() - began
    return TriangleRun(simulation, errors.largest, totals, stopped)


class _Errors:
    """The largest error of each triangle so far, at the frames of a motion or at equilibria."""

    def __init__(self, prepared: PreparedScene) -> None:
        self.scene, self.fabric, self.frame = prepared.scene, prepared.fabric, 0
        self.shares = shares_of(self.fabric.cloth)
        self.largest = np.zeros(len(self.fabric.cloth.triangles))

    def look(self, simulation: Simulation) -> None:
        """Take the errors of the present state, if they count."""
        frame = int(simulation.time * self.scene.output.frames_per_second)
        if frame > self.frame or simulation.done or self.scene.mode == "static":
            self.frame = frame
            found = indicate_errors(
                self.fabric.cloth, simulation.positions[0], self.fabric.cloth_material, shares=self.shares
            )
            self.largest = np.maximum(self.largest, found.total)
