# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The same yarns on two devices: differences of forces and of relaxed states, and repeatability on each device.

The file holds the scene, a generated and relaxed hat, so that both runs start from the same bits.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import stitchmesh as sm
from benchmarks.places import MESHES
from benchmarks.table import Rows
from stitchmesh.compute.device import device_named
from stitchmesh.io import read_stitches, write_stitches
from stitchmesh.quality import quality_named
from stitchmesh.yarnrelax.energies import by_term
from stitchmesh.yarnrelax.energies.body import Body
from stitchmesh.yarnrelax.energies.gravity import Gravity
from stitchmesh.yarnrelax.energies.term import TermChoice
from stitchmesh.yarnrelax.energies.twist import Twist
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.model.spline import place_contact_samples
from stitchmesh.yarnrelax.simulation import YarnSimulation

HAT = MESHES / "hat.obj"


def term_forces(yarns: sm.YarnSet, choice: TermChoice, device: str) -> np.ndarray:
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
    body = Body(sm.read_mesh(HAT))
    choices = {"gravity": Gravity(), "friction": Friction(0.3), "twist": Twist(5.0, 3.0), "body": body}
    found |= {name: term_forces(yarns, choice, device) for name, choice in choices.items()}
    runs = [sm.relax_yarns(yarns, quality="draft", device=device, keep_shape=fabric) for _ in range(2)]
    same = np.array_equal(runs[0].yarns.points, runs[1].yarns.points)
    report = runs[1].report
    agree = "agree" if same else "differ"
    yield f"{device}: {len(yarns.points)} control points, {report['iterations']} iterations, {report['seconds']:.2f} s"
    yield f"residual {report['residual']:.2g}; two runs {agree} in their bits"
    return {**found, "relaxed": runs[0].yarns.points}


def compare(mine: dict[str, np.ndarray], theirs: dict[str, np.ndarray], radius: float) -> Rows:
    """Yield largest differences."""
    for name in sorted(set(theirs) - {"relaxed"}):
        largest = np.abs(theirs[name]).max()
        yield f"forces, {name}: {np.abs(mine[name] - theirs[name]).max() / largest:.2g} of the largest"
    apart = np.linalg.norm(mine["relaxed"] - theirs["relaxed"], axis=1) / radius
    yield f"relaxed control points: {np.sqrt((apart**2).mean()):.2g} radii apart (rms), {apart.max():.2g} at most"


@dataclass(frozen=True)
class Options:
    """What is measured."""

    device: str
    save: Path | None = None
    compare: Path | None = None


def devices(given: Options) -> Rows:
    """Save the results of one device, or compare the results of another device with them."""
    if given.save:
        fabric = sm.tessellate(sm.label(sm.read_mesh(HAT)), stitch_width=0.8)
        yarns = sm.generate_yarns(fabric, quality="draft")
        sm.write_yarns(given.save.with_suffix(".h5"), yarns)
        write_stitches(given.save.with_suffix(".stitches.h5"), fabric)
        np.savez(given.save, **(yield from results(yarns, fabric, given.device)))
        return
    yarns = sm.read_yarns(given.compare.with_suffix(".h5"))
    fabric = read_stitches(given.compare.with_suffix(".stitches.h5"))
    found = yield from results(yarns, fabric, given.device)
    yield from compare(found, dict(np.load(given.compare)), float(yarns.radius[0]))
