# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Crossings against B-splines: the patch of ``examples/mixed/loops.toml`` with both yarn models.

Yarns are in the region of the scene, and everywhere. The crossings are stitches of the material ``gong-1`` on the same
triangles. The time is that of the processor, of all its cores together, without the preparation of the scene.
"""

from __future__ import annotations

import time
from dataclasses import replace

from benchmarks.places import MIXED_SCENES
from benchmarks.table import Rows
from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.scene_fabric import prepare
from stitchmesh.mixed.scene.scene_file import read_scene
from stitchmesh.run import QUIET

SCENE = MIXED_SCENES / "loops.toml"
CROSSINGS = "gong-1"
"""Material of the crossings."""


def with_model(scene: Scene, model: str) -> Scene:
    """The scene with the yarns of a model."""
    if model == "B-splines":
        return scene
    return replace(scene, yarns=replace(scene.yarns, model="crossings", loop_length=None, material=CROSSINGS))


def row(place: str, model: str, scene: Scene) -> tuple[object, ...]:
    """Run a scene, and return its row."""
    prepared = prepare(scene).fabric
    began = time.process_time()
    found = drape(scene, cloth=prepared.cloth, yarns=prepared.yarns, run=QUIET).report["mixed"]
    seconds = time.process_time() - began
    nodes = found["yarn_nodes_full"] + found["yarn_nodes_hybrid"]
    ended = "" if found["converged"] else " (not converged)"
    work = f"{found['newton_iterations']}{ended}", f"{found['solve_iterations']:,}"
    return place, model, f"{nodes:,}", *work, f"{seconds:.0f}"


def mixed_models() -> Rows:
    """Yield the table."""
    scene = read_scene(SCENE)
    yield "yarns", "model", "nodes simulated", "Newton iterations", "products", "processor time [s]"
    for place, region in (("region", scene.region), ("everywhere", RegionSection(yarns="all"))):
        for model in ("crossings", "B-splines"):
            yield row(place, model, with_model(replace(scene, region=region), model))
