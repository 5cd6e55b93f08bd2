# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A scene with triangles alone, which says where yarns are needed, and where the yarns of a static scene may begin.

The error of each triangle is the largest one over the frames of a motion, or over the equilibria of a static run
(``placement.error_indicator``).
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray
from stitchmesh.mixed.output.report import RunTotals
from stitchmesh.mixed.placement.error_indicator import indicate_errors
from stitchmesh.mixed.placement.triangle_deformation import shares_of
from stitchmesh.mixed.scene.scene_fabric import PreparedScene
from stitchmesh.mixed.simulation import Simulation, begin_simulation
from stitchmesh.mixed.triangles.slope_shares import SlopeShares
from stitchmesh.progress import Progress, no_progress
from stitchmesh.time_limit import check_time

STAGE = "triangles"
"""Name of the stage in reports of progress."""
Numbers = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TriangleRun:
    """What a run with triangles alone leaves."""

    vertices: FloatArray
    """Vertices at its end [cm], shape (V, 3)."""
    error: Numbers
    """The largest error of each triangle [erg], shape (T,)."""
    totals: RunTotals
    """Its work."""


def run_triangles(
    prepared: PreparedScene, scalar: Any, device: wp.Device, *, progress: Progress = no_progress
) -> TriangleRun:
    """Run a scene with triangles alone, whatever its region is.

    Args:
        prepared: the scene.
        scalar: Warp's floating-point type.
        device: where it runs.
        progress: called with the completed part and a line of text.

    Raises:
        SolverError: no time step is small enough.
        OutOfTime: the time of the block is over.
    """
    scene, began = prepared.scene, time.perf_counter()
    simulation = begin_simulation(replace(prepared, region=prepared.without_yarns), scalar, device)
    shares = shares_of(prepared.fabric.cloth)
    error, totals, frame = np.zeros(len(prepared.fabric.cloth.triangles)), RunTotals(), 0
    while not simulation.done:
        simulation.step(lambda _iterations, _force: check_time()).add_to(totals)
        check_time()
        now = int(simulation.time * scene.output.frames_per_second)
        if now > frame or simulation.done or scene.mode == "static":
            frame = now
            error = np.maximum(error, _errors(prepared, simulation, shares))
        progress(STAGE, min(simulation.time / scene.duration, 1.0), f"time {simulation.time:.4g} s")
    totals.seconds = time.perf_counter() - began
    return TriangleRun(simulation.positions[0], error, totals)


def _errors(prepared: PreparedScene, simulation: Simulation, shares: SlopeShares) -> Numbers:
    fabric = prepared.fabric
    return indicate_errors(fabric.cloth, simulation.positions[0], fabric.cloth_material, shares=shares).total
