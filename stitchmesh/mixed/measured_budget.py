# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How many yarn nodes a time for each step pays for, measured on the machine that runs the scene.

Three short runs of the scene are timed: with triangles alone, with yarns on an eighth of the nodes, and with yarns on
as many nodes as the straight line through both times promises. The nodes of the budget follow from the straight line
through the two runs with yarns. A dynamic scene is timed over its first steps without the first one, and a static scene
over its first equilibrium, the second time that it is found: the first time includes loading of kernels.

The time of a step grows with its nodes, and with the products that its linear solves take, which later steps may need
more of. A run that changes its region keeps the number of nodes that was measured at its start, so that stopping and
resuming changes nothing.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.placement.chosen_region import NodeBudget, choose_triangles
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, with_region
from stitchmesh.mixed.simulation import begin_simulation

STEPS = 4
"""Steps of a motion that are timed, after the first one."""
FIRST_PART = 8
"""The first trial has yarns on this part of all nodes."""
LEAST = 1e-9
"""Smallest time that a node adds to a step [s]."""
Numbers = NDArray[np.float64]


def node_budget(prepared: PreparedScene, error: Numbers, scalar: Any, device: wp.Device) -> NodeBudget:
    """Return the nodes that an automatic region may have: those of the scene, or those that its seconds pay for.

    Args:
        prepared: the scene, with yarns nowhere.
        error: indicated error of each triangle, shape (T,), which chooses the regions that are timed.
        scalar: Warp's floating-point type.
        device: where the scene runs.

    Raises:
        ParameterError: triangles alone take longer.
    """
    section = prepared.scene.region
    if section.seconds is None:
        return NodeBudget(nodes=int(section.nodes or 0))
    seconds, base = section.seconds, step_seconds(prepared, scalar, device)
    if base >= seconds:
        raise ParameterError(
            f"region.seconds: got {seconds:g} s, and a step with triangles alone takes {base:.3g} s; expected more "
            "seconds, or longer edges of triangles"
        )
    layout = prepared.fabric.yarns.node_count
    few, first = _trial(prepared, error, max(layout // FIRST_PART, 1), scalar, device)
    guess = NodeBudget.of_seconds(seconds, base=base, per_node=max((first - base) / max(few, 1), LEAST))
    many, second = _trial(prepared, error, min(guess.nodes, layout), scalar, device)
    slope = (second - first) / (many - few) if many != few else 0.0
    if slope <= 0.0:  # times of equal regions, or so near one another that the machine's other work decides
        slope = max((second - base) / max(many, 1), LEAST)
    line = NodeBudget.of_seconds(seconds, base=max(second - slope * many, 0.0), per_node=slope)
    return NodeBudget(nodes=max(line.nodes, few)) if first <= seconds else line


def step_seconds(prepared: PreparedScene, scalar: Any, device: wp.Device) -> float:
    """Return the time of a step, or of the first equilibrium, of a scene with its region [s]."""
    simulation = begin_simulation(prepared, scalar, device)
    simulation.step()
    static = prepared.scene.mode == "static"
    simulation = begin_simulation(prepared, scalar, device) if static else simulation
    began, steps = time.perf_counter(), 0
    while steps < (1 if static else STEPS) and not simulation.done:
        simulation.step()
        steps += 1
    return (time.perf_counter() - began) / max(steps, 1)


def _trial(prepared: PreparedScene, error: Numbers, nodes: int, scalar: Any, device: wp.Device) -> tuple[int, float]:
    """Nodes of a region within a budget, and the time of a step with it [s]."""
    fabric, rings = prepared.fabric, prepared.scene.region.rings
    allowed = prepared.scene.region.placing_errors(fabric.cloth, error)
    chosen = choose_triangles(
        fabric.cloth.triangles, fabric.yarns.triangle, allowed, NodeBudget(nodes=nodes), rings=rings
    )
    trial = with_region(prepared, chosen)
    return len(trial.region.nodes), step_seconds(trial, scalar, device)
