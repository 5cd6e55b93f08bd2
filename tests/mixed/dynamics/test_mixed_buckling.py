# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A pinned strip of a weave buckles under Euler's load, with yarns in its middle."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh, null_space

from stitchmesh.mixed.assembly import MixedFabric
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.cloth.seams import cloth_from_panels
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial, FabricMaterials
from stitchmesh.mixed.enrichment.region import region_around
from stitchmesh.mixed.layout.weave import lay_weave
from stitchmesh.mixed.scene.scene_fabric import cloth_of_weave
from tests.mixed.cloth_scene import ClothScene, cloth_scene
from tests.mixed.dynamics.scene import CPU, set_hessian_product

LENGTH, WIDTH, DENSITY = 6.0, 1.0, 4.0
OUTLINE = np.array([[0.0, 0.0], [LENGTH, 0.0], [LENGTH, WIDTH], [0.0, WIDTH]])
CLOTH = cloth_from_panels([Panel(name="strip", outline=OUTLINE)], [], edge_length=0.5)
WEAVE = lay_weave(CLOTH, np.eye(2, dtype=int), ends=DENSITY, picks=DENSITY)
YARN = FabricMaterials.of(CrossingMaterial.named())
MATERIAL = cloth_of_weave(YARN, DENSITY, DENSITY)
STRAIN = np.pi**2 * MATERIAL.bending_course / (MATERIAL.stretch_course * LENGTH**2)
"""Euler: pi^2 B / L^2 = Y e."""


def heights(scene: ClothScene, strain: float, motions: np.ndarray) -> np.ndarray:
    """The Hessian for motions of the heights of vertices and nodes, where the strip is pressed by a strain."""
    state, vertices = scene.positions.like(), len(CLOTH.vertices)
    v, p, s = (part.copy() for part in scene.positions.numpy())
    v[:, 0] *= 1.0 - strain
    p[:, 0] *= 1.0 - strain
    state.assign(scene.positions.from_numpy(v, p, s, scene.system.scalar, CPU))
    scene.system.linearize(state, 1.0)
    direction, product = state.like(), state.like()
    columns = []
    for motion in motions.T:
        v, p, s = (np.zeros_like(part) for part in (v, p, s))
        v[:, 2], p[:, 2] = motion[:vertices], motion[vertices:]
        direction.assign(state.from_numpy(v, p, s, scene.system.scalar, CPU))
        set_hessian_product(scene.system, direction, product)
        of_vertices, of_nodes, _ = product.numpy()
        columns.append(np.concatenate([of_vertices[:, 2], of_nodes[:, 2]]))
    return motions.T @ np.stack(columns, axis=1)


def motions_of(scene: ClothScene, pinned: np.ndarray) -> np.ndarray:
    """All motions p = B v + F x of heights with pinned vertices."""
    embedding, region = scene.system.embedding, scene.region
    own = embedding.independent.T.toarray()
    rows = np.zeros((own.shape[0], len(CLOTH.vertices) + len(region.nodes)))
    rows[:, : len(CLOTH.vertices)] = -embedding.gram.toarray()
    rows[:, len(CLOTH.vertices) + embedding.nodes] = own
    held = np.concatenate([pinned | ~region.unknown_vertices, np.zeros(len(region.nodes), dtype=bool)])
    return null_space(np.concatenate([rows, np.eye(rows.shape[1])[held]]))


@pytest.mark.nightly
def test_the_load_under_which_a_mixed_strip_buckles():
    middle = CLOTH.vertices[CLOTH.triangles].mean(axis=1)[:, 0]
    chosen = np.flatnonzero(np.abs(middle - LENGTH / 2) < 1.0)
    region = region_around(CLOTH.triangles, len(CLOTH.vertices), WEAVE.triangle, WEAVE.barycentric, chosen)
    fabric = MixedFabric(cloth=CLOTH, yarns=WEAVE, cloth_material=MATERIAL, yarn_materials=YARN)
    scene = cloth_scene(fabric, region, gravity=(0.0, 0.0, 0.0))
    x = CLOTH.vertices[:, 0]
    motions = motions_of(scene, (x < 1e-9) | (x > LENGTH - 1e-9))
    bending = heights(scene, 0.0, motions)
    pressing = bending - heights(scene, STRAIN, motions)
    load = 1.0 / eigh(pressing, bending, eigvals_only=True)[-1]
    assert load == pytest.approx(1.0, rel=0.015)  # edges and spacings of a twelfth and less of the half wave
