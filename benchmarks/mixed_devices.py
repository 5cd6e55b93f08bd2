# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The same mixed motions on two devices: differences of positions, and repeatability on each device.

    python benchmarks/mixed_devices.py --device cpu --save mixed-cpu.npz
    python benchmarks/mixed_devices.py --device cuda:0 --compare mixed-cpu.npz

Motions of some examples in float64, converged to ``TOLERANCE``, so that differences are those of rounding: a cloth that
swings, with sliding friction of its yarns; the same cloth with a region that follows the errors of the triangles; a
cloth that a ball is pressed into, with contact, friction on the ball and friction of the yarns.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
import warp as wp

from stitchmesh.compute.device import alone, device_named
from stitchmesh.mixed.adaptive_region import AdaptiveRegion
from stitchmesh.mixed.measured_budget import NodeBudget
from stitchmesh.mixed.scene.motion_section import Keyframe
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.scene_fabric import prepare
from stitchmesh.mixed.scene.scene_file import read_scene
from stitchmesh.mixed.simulation import begin_simulation

SCENES = Path(__file__).resolve().parent.parent / "examples" / "mixed"
TOLERANCE = 1e-6
"""Error of the velocities of a step [cm/s]."""
SOLVE_TOLERANCE = 1e-7
"""Relative tolerance of the linear solves."""
STEP, STEPS = 2.5e-4, 12
"""Length [s] and number of the steps of each motion; where longer ones are halved, rounding decides when."""
NODES = 250
"""Budget of the region that changes."""


def motions() -> dict[str, Scene]:
    """The scenes by name."""
    swinging = replace(read_scene(SCENES / "swinging.toml"), largest_step=STEP)
    follows = RegionSection(yarns="automatic", nodes=NODES, adapt_every=2)
    ball = read_scene(SCENES / "ball.toml")
    frames = Keyframe(time=0.0), Keyframe(time=0.01, displacement=(0.1, 0.0, -0.4))
    pressed = replace(ball, mode="dynamic", duration=0.1, largest_step=STEP, load_steps=1)
    pressed = replace(pressed, bodies=(replace(ball.bodies[0], keyframes=frames),))
    return {"swinging": swinging, "changing region": replace(swinging, region=follows), "ball": pressed}


def positions_after(scene: Scene, device: str) -> tuple[np.ndarray, str]:
    """Positions after the steps, in one row, and what the run did."""
    solver = replace(scene.solver, velocity_tolerance=TOLERANCE, solve_tolerance=SOLVE_TOLERANCE, device=device)
    prepared = prepare(replace(scene, solver=solver))
    products, halvings = 0, 0
    with alone():
        simulation = begin_simulation(prepared, wp.float64, device_named(device))
        region = AdaptiveRegion(prepared, NodeBudget(nodes=NODES))
        for _ in range(STEPS):
            step = simulation.step()
            products, halvings = products + step.solve_iterations, halvings + step.halvings
            region.look(simulation)
        found = np.concatenate([part.ravel() for part in simulation.positions])
    return found, f"{products} products, {halvings} halvings, {region.changes} changes of the region"


def main() -> None:
    """Save the positions of one device, or compare those of another device with them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--device", required=True)
    choice = parser.add_mutually_exclusive_group(required=True)
    choice.add_argument("--save", type=Path)
    choice.add_argument("--compare", type=Path)
    given = parser.parse_args()
    expected = dict(np.load(given.compare)) if given.compare else {}
    results = {}
    for name, scene in motions().items():
        (found, did), (again, _did) = (positions_after(scene, given.device) for _ in range(2))
        results[name] = found
        same = "the same bits twice" if np.array_equal(found, again) else "other bits the second time"
        print(f"{given.device}: {name}: {did}; {same}", flush=True)
        if name in expected and len(found) != len(expected[name]):
            print("  other nodes are simulated", flush=True)
        elif name in expected:
            print(f"  apart by {np.abs(found - expected[name]).max():.2g} cm at most", flush=True)
    if given.save:
        np.savez(given.save, **results)


if __name__ == "__main__":
    main()
