# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The same mixed scenes on two devices: differences of positions, and repeatability on each device.

Motions of some examples in float64, converged to ``TOLERANCE``, so that differences are those of rounding: a cloth that
swings, with sliding friction of its yarns; the same cloth with a region that follows the errors of the triangles; a
cloth that a ball is pressed into, with contact, friction on the ball and friction of the yarns. The static scene of
B-spline yarns, ``loops``, makes a number of Newton iterations with tight linear solves. Its yarns were relaxed where
the file was saved, which holds their control points.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import warp as wp

from benchmarks.places import MIXED_SCENES
from benchmarks.table import Rows
from stitchmesh.compute.device import alone, device_named
from stitchmesh.mixed.adaptive_region import AdaptiveRegion
from stitchmesh.mixed.automatic_region import NodeBudget
from stitchmesh.mixed.layout.spline_yarns import SplineYarns
from stitchmesh.mixed.layout.splines_on_stitches import lay_splines
from stitchmesh.mixed.scene.motion_section import Keyframe
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, drawn_splines, prepare
from stitchmesh.mixed.scene.scene_file import read_scene
from stitchmesh.mixed.simulation import begin_simulation

TOLERANCE = 1e-6
"""Error of the velocities of a step [cm/s]."""
SOLVE_TOLERANCE = 1e-7
"""Relative tolerance of the linear solves."""
STEP, STEPS = 2.5e-4, 12
"""Length [s] and number of the steps of each motion; where longer ones are halved, rounding decides when."""
NODES = 250
"""Budget of the region that changes."""
YARNS = "yarns"
"""End of the name of control points in the file."""
ITERATIONS = 12
"""Newton iterations of a static scene."""
LOAD_STEPS = 10
"""Parts of the way of its ball, of which it makes the first one."""


def scenes() -> dict[str, Scene]:
    """The scenes by name."""
    swinging = replace(read_scene(MIXED_SCENES / "swinging.toml"), largest_step=STEP)
    follows = RegionSection(yarns="automatic", nodes=NODES, adapt_every=2)
    ball = read_scene(MIXED_SCENES / "ball.toml")
    frames = Keyframe(time=0.0), Keyframe(time=0.01, displacement=(0.1, 0.0, -0.4))
    pressed = replace(ball, mode="dynamic", duration=0.1, largest_step=STEP, load_steps=1)
    pressed = replace(pressed, bodies=(replace(ball.bodies[0], keyframes=frames),))
    loops = read_scene(MIXED_SCENES / "loops.toml")
    few = replace(loops.solver, force_tolerance=TOLERANCE, most_iterations=ITERATIONS)
    return {
        "swinging": swinging,
        "changing region": replace(swinging, region=follows),
        "ball": pressed,
        "loops": replace(loops, load_steps=LOAD_STEPS, solver=few),
    }


def prepared_with(scene: Scene, points: np.ndarray | None) -> PreparedScene:
    """The scene, with given control points where its yarns are B-splines."""
    if points is None:
        return prepare(scene)
    fabric, cloth = scene.cloth.stitches(), scene.cloth.cloth()
    curves = replace(drawn_splines(scene.yarns, fabric), points=points)
    return prepare(scene, cloth=cloth, yarns=lay_splines(cloth, fabric, curves))


def positions_after(prepared: PreparedScene, device: str) -> tuple[np.ndarray, str]:
    """Positions after the steps, in one row, and what the run did."""
    products, halvings = 0, 0
    with alone():
        simulation = begin_simulation(prepared, wp.float64, device_named(device))
        region = AdaptiveRegion(prepared, NodeBudget(nodes=NODES))
        for _ in range(STEPS if prepared.scene.mode == "dynamic" else 1):
            step = simulation.step()
            products, halvings = products + step.solve_iterations, halvings + step.halvings
            region.look(simulation)
        found = np.concatenate([part.ravel() for part in simulation.positions])
    return found, f"{products} products, {halvings} halvings, {region.changes} changes of the region"


@dataclass(frozen=True)
class Options:
    """What is measured."""

    device: str
    save: Path | None = None
    compare: Path | None = None
    scenes: tuple[str, ...] = tuple(scenes())


def mixed_devices(given: Options) -> Rows:
    """Save the positions of one device, or compare those of another device with them."""
    expected = dict(np.load(given.compare)) if given.compare else {}
    results = {}
    for name in given.scenes:
        scene = scenes()[name]
        solver = replace(
            scene.solver, velocity_tolerance=TOLERANCE, solve_tolerance=SOLVE_TOLERANCE, device=given.device
        )
        prepared = prepared_with(replace(scene, solver=solver), expected.get(f"{name} {YARNS}"))
        yarns = prepared.fabric.yarns
        if isinstance(yarns, SplineYarns):
            results[f"{name} {YARNS}"] = yarns.curves.points
        (found, did), (again, _did) = (positions_after(prepared, given.device) for _ in range(2))
        results[name] = found
        same = "the same bits twice" if np.array_equal(found, again) else "other bits the second time"
        yield f"{given.device}: {name}: {did}; {same}"
        if name in expected and len(found) != len(expected[name]):
            yield "other nodes are simulated"
        elif name in expected:
            yield f"apart by {np.abs(found - expected[name]).max():.2g} cm at most"
    if given.save:
        np.savez(given.save, **results)
