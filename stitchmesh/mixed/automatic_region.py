# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The region of a scene that the error of triangles alone chooses.

The scene runs with triangles first. The error of each triangle is the largest one over the frames of a motion, or over
the equilibria of a static run (``placement.error_indicator``); a region within the number of nodes of the scene follows
from it (``placement.chosen_region``). The scene then begins again with yarns in this region, so that a result does not
depend on how the region was found.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.measured_budget import measured_budget
from stitchmesh.mixed.placement.chosen_region import NodeBudget, choose_triangles
from stitchmesh.mixed.placement.error_indicator import indicate_errors
from stitchmesh.mixed.placement.triangle_deformation import shares_of
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, check_simulated, with_region
from stitchmesh.mixed.simulation import begin_simulation
from stitchmesh.progress import Progress, no_progress
from stitchmesh.time_limit import check_time

STAGE = "placing yarns"
"""Name of the stage in reports of progress."""
Numbers = NDArray[np.float64]


def place_yarns(
    prepared: PreparedScene, scalar: Any, device: wp.Device, *, progress: Progress = no_progress
) -> PreparedScene:
    """Run a scene with triangles alone and choose its region.

    Args:
        prepared: a scene whose region is ``automatic``, with yarns nowhere.
        scalar: Warp's floating-point type.
        device: where the scene runs.
        progress: called with the completed part and a line of text.

    Raises:
        ParameterError: the number of nodes does not suffice for one triangle and the rings around it.
        SolverError: no time step is small enough.
    """
    section, fabric = prepared.scene.region, prepared.fabric
    cloth, yarns = fabric.cloth, fabric.yarns
    error = section.allowed_errors(cloth, run_errors(prepared, scalar, device, progress))
    budget = node_budget(prepared, error, scalar, device)
    chosen = choose_triangles(cloth.triangles, yarns.triangle, error, budget, rings=section.rings)
    if len(chosen) == 0 and error.any():
        raise ParameterError(
            f"region.nodes: {budget.nodes} nodes hold no triangle with {section.rings} hybrid rings around it; "
            "expected more nodes, or smaller triangles"
        )
    placed = with_region(prepared, chosen)
    check_simulated(placed.held, placed.region)
    return placed


def node_budget(prepared: PreparedScene, error: Numbers, scalar: Any, device: wp.Device) -> NodeBudget:
    """Return the nodes that an automatic region may have: those of the scene, or those that its seconds pay for.

    Args:
        prepared: the scene, with yarns nowhere.
        error: indicated error of each triangle, shape (T,).
        scalar: Warp's floating-point type.
        device: where the scene runs.

    Raises:
        ParameterError: triangles alone take longer than the seconds.
    """
    section = prepared.scene.region
    if section.seconds is None:
        return NodeBudget(nodes=int(section.nodes or 0))
    return measured_budget(prepared, error, section.seconds, scalar, device)


def run_errors(prepared: PreparedScene, scalar: Any, device: wp.Device, progress: Progress = no_progress) -> Numbers:
    """The largest error of each triangle in a run with triangles alone [erg], shape (T,); arguments as above."""
    scene, cloth = prepared.scene, prepared.fabric.cloth
    simulation = begin_simulation(prepared, scalar, device)
    shares = shares_of(cloth)
    error = np.zeros(len(cloth.triangles))
    frame = 0
    while not simulation.done:
        simulation.step()
        check_time()
        now = int(simulation.time * scene.output.frames_per_second)
        if now > frame or simulation.done or scene.mode == "static":
            frame = now
            vertices = simulation.positions[0]
            found = indicate_errors(cloth, vertices, prepared.fabric.cloth_material, shares=shares)
            error = np.maximum(error, found.total)
        progress(STAGE, min(simulation.time / scene.duration, 1.0), f"time {simulation.time:.4g} s")
    return error
