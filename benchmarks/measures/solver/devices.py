# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The same yarns and the same mixed scenes on two devices: differences, and repeatability on each device.

The results of one device are saved, and those of another one compared with them; the file holds the scenes as far as
they are relaxed, so that both runs start from the same bits.

- ``yarns``: a generated and relaxed hat: forces and relaxed states.
- ``cloths``: motions of some examples in float64, converged to ``TOLERANCE``, so that differences are those of
  rounding: a cloth that swings, with sliding friction of its yarns; the same cloth with a region that follows the
  errors of the triangles; a cloth that a ball is pressed into, with contact, friction on the ball and friction of the
  yarns. The static scene of B-spline yarns, ``loops``, makes a number of Newton iterations with tight linear solves.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

import numpy as np
import warp as wp

import stitchmesh as sm
from benchmarks.places import MIXED_SCENES
from benchmarks.scenes.garments import Garment
from benchmarks.table import Rows
from stitchmesh.compute.device import alone, device_named
from stitchmesh.io import read_stitches, write_stitches
from stitchmesh.mixed.adaptive_region import AdaptiveRegion
from stitchmesh.mixed.layout.spline_yarns import SplineYarns, lay_splines
from stitchmesh.mixed.placement.chosen_region import NodeBudget
from stitchmesh.mixed.scene.motion_section import Keyframe
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import Scene, read_scene
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, prepare
from stitchmesh.mixed.scene.scene_splines import drawn_splines
from stitchmesh.mixed.simulation import begin_simulation
from stitchmesh.quality import quality_named
from stitchmesh.simulation.dead_load import Gravity
from stitchmesh.yarnrelax.energies import by_term
from stitchmesh.yarnrelax.energies.body import Body
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.energies.twist import Twist
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.model.spline import place_contact_samples
from stitchmesh.yarnrelax.simulation import YarnSimulation

HAT = Garment("hat", 0.8)


def yarns(*, device: str, save: Path | None = None, compare: Path | None = None) -> Rows:
    """Relax a hat on a device, and save the results or compare them."""
    if compare is None:
        assert save is not None
        fabric = HAT.divided()
        drawn = sm.generate_yarns(fabric, quality="draft")
        sm.write_yarns(save.with_suffix(".h5"), drawn)
        write_stitches(save.with_suffix(".stitches.h5"), fabric)
        np.savez(save, **(yield from results(drawn, fabric, device)))
        return
    drawn = sm.read_yarns(compare.with_suffix(".h5"))
    mine = yield from results(drawn, read_stitches(compare.with_suffix(".stitches.h5")), device)
    theirs = dict(np.load(compare))
    for name in sorted(set(theirs) - {"relaxed"}):
        largest = np.abs(theirs[name]).max()
        yield f"forces, {name}: {np.abs(mine[name] - theirs[name]).max() / largest:.2g} of the largest"
    apart = np.linalg.norm(mine["relaxed"] - theirs["relaxed"], axis=1) / float(drawn.radius[0])
    yield f"relaxed control points: {np.sqrt((apart**2).mean()):.2g} radii apart (rms), {apart.max():.2g} at most"


def term_forces(yarns: sm.YarnSet, choice: YarnChoice, device: str) -> np.ndarray:
    """Return the force of one optional term on slightly perturbed yarns, in float64 and the units of the solver."""
    material = sm.YarnMaterial.named("stitchmesh").of_radius(yarns.radius[0])
    scene = YarnSimulation.start(yarns, material, quality_named("reference"), device_named(device), [choice])
    shake = np.random.default_rng(5).normal(scale=0.01, size=yarns.points.shape)
    scene.state.points.assign(scene.state.points.numpy() + shake)
    place_contact_samples(scene.model, scene.state, scene.model.launch)
    found = np.zeros_like(shake)
    for name in by_term.each_term(scene.model, scene.state, scene.candidates, scene.terms, scene.point_stiffness):
        if name == scene.terms[0].name:
            found = scene.state.force.numpy().copy()
    return found


def results(yarns: sm.YarnSet, fabric: sm.StitchMesh, device: str) -> Generator[str, None, dict[str, np.ndarray]]:
    """Return the forces in both precisions [dyn] and the relaxed control points [cm], which must repeat exactly."""
    material = sm.YarnMaterial.named("stitchmesh").of_radius(yarns.radius[0])
    found = {name: sm.yarn_forces(yarns, material, precision=name, device=device) for name in ("float64", "float32")}
    body = Body(HAT.mesh())
    choices = {"gravity": Gravity(), "friction": Friction(0.3), "twist": Twist(5.0, 3.0), "body": body}
    found |= {name: term_forces(yarns, choice, device) for name, choice in choices.items()}
    runs = [sm.relax_yarns(yarns, quality="draft", device=device, keep_shape=fabric) for _ in range(2)]
    same = np.array_equal(runs[0].yarns.points, runs[1].yarns.points)
    report = runs[1].report
    agree = "agree" if same else "differ"
    yield f"{device}: {len(yarns.points)} control points, {report['iterations']} iterations, {report['seconds']:.2f} s"
    yield f"residual {report['residual']:.2g}; two runs {agree} in their bits"
    return {**found, "relaxed": runs[0].yarns.points}


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


def cloths(
    *, device: str, save: Path | None = None, compare: Path | None = None, only: tuple[str, ...] = tuple(scenes())
) -> Rows:
    """Run mixed scenes on a device, and save the positions or compare them."""
    expected = dict(np.load(compare)) if compare else {}
    found = {}
    for name in only:
        scene = scenes()[name]
        solver = replace(scene.solver, velocity_tolerance=TOLERANCE, solve_tolerance=SOLVE_TOLERANCE, device=device)
        prepared = prepared_with(replace(scene, solver=solver), expected.get(f"{name} {YARNS}"))
        laid = prepared.fabric.yarns
        if isinstance(laid, SplineYarns):
            found[f"{name} {YARNS}"] = laid.curves.points
        (found[name], did), (again, _did) = (positions_after(prepared, device) for _ in range(2))
        same = "the same bits twice" if np.array_equal(found[name], again) else "other bits the second time"
        yield f"{device}: {name}: {did}; {same}"
        if name in expected and len(found[name]) != len(expected[name]):
            yield "other nodes are simulated"
        elif name in expected:
            yield f"apart by {np.abs(found[name] - expected[name]).max():.2g} cm at most"
    if save:
        np.savez(save, **found)


ACTIONS = (yarns, cloths)
