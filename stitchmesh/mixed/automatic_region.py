# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The region of a scene that follows from the error of triangles alone.

A run with triangles alone gives the error of energy in each triangle. A region within the number of nodes of the scene
follows from it (``placement.chosen_region``). The scene then begins anew with yarns in this region, so a result does
not depend on how the region was found.

The error of each triangle is the largest one over the frames of a motion, or over the equilibria of a static run
(``placement.error_indicator``).

A scene may give a time for each step instead of a number of nodes. The number of nodes that this time pays for is then
measured on the machine that runs the scene. Three short runs are timed: with triangles alone, with yarns on an eighth
of the nodes, and with as many yarn nodes as the straight line through these two times allows. The budget follows from
the straight line through the two runs with yarns. A dynamic scene is timed over its first steps without the very first
one. A static scene is timed over its first equilibrium, when it is found for the second time, because the first time
includes the loading of kernels.

The time of a step grows with its nodes and with the products that its linear solves take, and later steps may need more
products. A run that changes its region keeps the number of nodes that was measured at its start, so that stopping and
resuming changes nothing.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.precision import ScalarType
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray
from stitchmesh.mixed.dynamics.equilibrium import AfterIteration, search_progress
from stitchmesh.mixed.output.report import RunTotals
from stitchmesh.mixed.placement.chosen_region import NodeBudget, choose_triangles
from stitchmesh.mixed.placement.error_indicator import indicate_errors, shares_of
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, check_simulated, with_region
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
LEAST = 1e-9
"""Smallest time that a node adds to a step [s]."""


def place_yarns(prepared: PreparedScene, error: NDArray[np.float64], budget: NodeBudget) -> PreparedScene:
    """Choose the region of a scene.

    Args:
        prepared: a scene whose region is ``automatic``, with yarns nowhere.
        error: the largest error of each triangle in a run with triangles alone [erg], shape (T,).
        budget: nodes that may be simulated.

    Raises:
        ParameterError: the number of nodes does not suffice for one triangle and the rings around it.
    """
    section, fabric = prepared.scene.region, prepared.fabric
    cloth, yarns = fabric.cloth, fabric.yarns
    allowed = section.placing_errors(cloth, error)
    chosen = choose_triangles(cloth.triangles, yarns.triangle, allowed, budget, rings=section.rings)
    if len(chosen) == 0 and allowed.any():
        raise ParameterError(
            f"region: {budget.nodes} nodes hold no triangle with {section.rings} hybrid rings around it; expected more "
            "nodes or seconds, or smaller triangles"
        )
    placed = with_region(prepared, chosen)
    check_simulated(placed.held, placed.region)
    return placed


def unwatched(simulation: Simulation, iterations: int, error: float) -> None:
    """Do nothing after a step (an ``AfterStep`` function)."""


@dataclass(frozen=True, eq=False)
class TriangleRun:
    """The result of a run with triangles alone."""

    end: Simulation
    """The state at its end, or where it was stopped."""
    error: Numbers
    """The largest error of each triangle [erg], shape (T,)."""
    totals: RunTotals
    """Its work."""
    stopped: bool = False
    """Whether the user or the time limit stopped it."""

    @property
    def vertices(self) -> FloatArray:
        """Vertices at its end [cm], shape (V, 3)."""
        return self.end.positions[0]


def run_triangles(
    prepared: PreparedScene,
    scalar: ScalarType,
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


def node_budget(prepared: PreparedScene, error: Numbers, scalar: ScalarType, device: wp.Device) -> NodeBudget:
    """Return the nodes that an automatic region may have: the number of the scene, or what its seconds pay for.

    Args:
        prepared: the scene, with yarns nowhere.
        error: indicated error of each triangle, shape (T,), which chooses the regions that are timed.
        scalar: Warp's floating-point type.
        device: where the scene runs.

    Raises:
        ParameterError: a run with triangles alone already takes longer than the seconds of the scene.
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
    few, first = _trial(prepared, error, max(layout // 8, 1), scalar, device)
    guess = NodeBudget.of_seconds(seconds, base=base, per_node=max((first - base) / max(few, 1), LEAST))
    many, second = _trial(prepared, error, min(guess.nodes, layout), scalar, device)
    slope = (second - first) / (many - few) if many != few else 0.0
    if slope <= 0.0:  # the regions are equal, or the times are so close that other work of the machine decides
        slope = max((second - base) / max(many, 1), LEAST)
    line = NodeBudget.of_seconds(seconds, base=max(second - slope * many, 0.0), per_node=slope)
    return NodeBudget(nodes=max(line.nodes, few)) if first <= seconds else line


def step_seconds(prepared: PreparedScene, scalar: ScalarType, device: wp.Device) -> float:
    """Return the time of a step, or of the first equilibrium, of a scene with its region [s]."""
    simulation = begin_simulation(prepared, scalar, device)
    simulation.step()
    static = prepared.scene.mode == "static"
    simulation = begin_simulation(prepared, scalar, device) if static else simulation
    began, steps = time.perf_counter(), 0
    while steps < (1 if static else 4) and not simulation.done:  # one equilibrium, or four steps after the first one
        simulation.step()
        steps += 1
    return (time.perf_counter() - began) / max(steps, 1)


def _trial(
    prepared: PreparedScene, error: Numbers, nodes: int, scalar: ScalarType, device: wp.Device
) -> tuple[int, float]:
    """Nodes of a region within a budget, and the time of a step with it [s]."""
    fabric, rings = prepared.fabric, prepared.scene.region.rings
    allowed = prepared.scene.region.placing_errors(fabric.cloth, error)
    chosen = choose_triangles(
        fabric.cloth.triangles, fabric.yarns.triangle, allowed, NodeBudget(nodes=nodes), rings=rings
    )
    trial = with_region(prepared, chosen)
    return len(trial.region.nodes), step_seconds(trial, scalar, device)
