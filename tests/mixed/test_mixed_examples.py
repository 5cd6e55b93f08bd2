# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Every scene of ``examples/mixed`` can be prepared in its three forms, and the ball dents its patch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.scene.motion_section import Keyframe
from stitchmesh.mixed.scene.scene import read_scene
from stitchmesh.mixed.scene.scene_fabric import prepare
from tests.gallery import ROOT
from tests.nightly import mostly_at_night

SCENES = sorted((ROOT / "examples" / "mixed").glob("*.toml"))
PUCKERING = ROOT / "examples" / "mixed" / "puckering.toml"


@pytest.mark.parametrize("path", mostly_at_night(SCENES, by_day=[PUCKERING]), ids=lambda path: path.stem)
def test_a_scene_has_yarns_in_a_part_of_the_cloth(path):
    read = read_scene(path)
    scene = replace(read, contact=replace(read.contact, start_outside=False))  # where it begins does not count here
    nodes = []
    for kind in ("none", "chosen", "all"):
        prepared = prepare(replace(scene, region=replace(scene.region, yarns=kind)))
        nodes.append(len(prepared.region.nodes))
    assert nodes[0] == 0 < nodes[1] < nodes[2] == prepared.fabric.yarns.node_count


def test_the_ball_dents_its_patch():
    """The cloth stays out of the ball, which moves 0.9 cm while it begins 0.1 cm above the cloth."""
    scene = read_scene(ROOT / "examples" / "mixed" / "ball.toml")
    run = drape(replace(scene, region=replace(scene.region, yarns="none"), solver=replace(scene.solver, device="cpu")))
    assert run.report["mixed"]["converged"]
    centre = np.array([2.5, 2.5, 0.4])
    distance = np.linalg.norm(run.shown.vertices - centre, axis=1)
    assert distance.min() > 1.2 * 0.97  # the facets of the ball lie inside its sphere
    assert run.shown.vertices[:, 2].min() < -0.5


def pulled(part: float, kind: str = "chosen", **solver: float) -> tuple[np.ndarray, np.ndarray]:
    """How far nodes are from their first places while the yarns are pulled, and after their release [cm], (N,)."""
    scene = read_scene(ROOT / "examples" / "mixed" / "pulled.toml")
    attachments = tuple(
        replace(one, keyframes=tuple(replace(key, displacement=scaled(key, part)) for key in one.keyframes))
        for one in scene.attachments
    )
    region, solving = replace(scene.region, yarns=kind), replace(scene.solver, device="cpu", **solver)
    run = drape(replace(scene, region=region, attachments=attachments, solver=solving))
    assert run.report["mixed"]["converged"]
    first, *_between, held, last = [run.shown_at(frame).nodes for frame in run.frames]
    return np.linalg.norm(held - first, axis=1), np.linalg.norm(last - first, axis=1)


def scaled(key: Keyframe, part: float) -> tuple[float, ...]:
    return tuple(part * length for length in key.displacement)


@pytest.mark.nightly
def test_snags_stay_after_release_and_elastic_marks_do_not():
    """A pull by 0.01 cm neither lets yarns slip through friction nor bends them beyond their yield curvature."""
    held, left = pulled(1.0)
    assert held.max() == pytest.approx(0.9, abs=1e-9)
    assert left.max() > 0.1  # half the spacing of the yarns
    held, left = pulled(0.01 / 0.9, force_tolerance=1e-3)
    # forces of 0.001 dyn over the stiffness of friction of weakly pressed crossings
    assert left.max() < 0.01 * held.max()
    held, left = pulled(1.0, "none")
    assert left.max() < 0.001 * held.max()  # triangles are elastic
