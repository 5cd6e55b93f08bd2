# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Weights of stretch with which uniform tension balances in the hybrid region, and deformation passes through it."""

from __future__ import annotations

from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest

from stitchmesh.mixed import assembly
from stitchmesh.mixed.assembly import MixedFabric
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.cloth.seams import cloth_from_panels
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial, FabricMaterials
from stitchmesh.mixed.dynamics.equilibrium import EquilibriumSettings, find_equilibrium
from stitchmesh.mixed.enrichment.balanced_weights import MOST_CHANGE, ROUNDING, StretchedCloth, balanced_weights
from stitchmesh.mixed.enrichment.region import HYBRID, YARNS, Region, region_around
from stitchmesh.mixed.layout.weave import lay_weave
from stitchmesh.mixed.scene.scene_fabric import cloth_of_weave
from tests.mixed.cloth_scene import cloth_scene
from tests.mixed.patch import enriched_everywhere

SIDE, DENSITY = 4.8, 6.0
CLOTH = cloth_from_panels([Panel(name="square", outline=SIDE * np.array([[0, 0], [1, 0], [1, 1], [0, 1]]))], [],
                          edge_length=0.6)  # fmt: skip
LAYOUT = lay_weave(CLOTH, np.eye(2, dtype=int), ends=DENSITY, picks=DENSITY)
FROM_MIDDLE = np.abs(CLOTH.vertices[:, :2] - SIDE / 2).max(axis=1)
MIDDLE = np.flatnonzero(np.abs(CLOTH.vertices[CLOTH.triangles].mean(axis=1)[:, :2] - SIDE / 2).max(axis=1) < 0.5)
YARN = FabricMaterials.of(CrossingMaterial.named())
MATERIAL = cloth_of_weave(YARN, DENSITY, DENSITY)
FABRIC = MixedFabric(cloth=CLOTH, yarns=LAYOUT, cloth_material=MATERIAL, yarn_materials=YARN)
STRAIN = 1e-3
"""Small, so that the laws of triangles and yarns, which differ by the square of the strain, do not."""
INNER = np.flatnonzero(FROM_MIDDLE < SIDE / 2 - 1e-9)
PARTS = CLOTH.triangles, len(CLOTH.vertices), LAYOUT.triangle, LAYOUT.barycentric
REGIONS = {rings: region_around(*PARTS, MIDDLE, rings=rings) for rings in (1, 2)}


def stretched_cloth() -> StretchedCloth:
    """What the assembly of a system gives to ``balanced_weights``."""
    with patch.object(assembly, "balanced_weights", side_effect=lambda region, cloth: cloth):
        return assembly._stretch_weights(CLOTH, LAYOUT, REGIONS[1])


def unbalanced(region: Region, axis: int) -> tuple[float, float]:
    """Forces under uniform stretch, over the tension per cm: those of nodes that triangles do not represent, and those
    of the inner vertices of the hybrid region."""
    stretch = np.eye(3)
    stretch[axis, axis] += STRAIN
    vertices = CLOTH.vertices @ stretch.T
    made = cloth_scene(FABRIC, region, gravity=(0.0, 0.0, 0.0), places=vertices)
    force = made.system.zeros()
    made.system.set_forces(made.positions, force)
    of_vertices, of_nodes, _ = force.numpy()
    embedding = made.system.embedding
    own = of_nodes[embedding.nodes]
    represented = embedding.basis @ np.linalg.lstsq(embedding.basis.toarray(), own, rcond=None)[0]
    held = np.intersect1d(region.triangles[region.triangle_kind == HYBRID], INNER)
    at_vertices = (of_vertices + embedding.basis.T @ own)[held, axis]
    tension = MATERIAL.stretch_course * STRAIN
    return np.linalg.norm((own - represented)[:, axis]) / tension, np.linalg.norm(at_vertices) / tension


@pytest.mark.parametrize(("rings", "axis"), [(1, 0), (2, 1)])
def test_uniform_tension_balances_at_the_nodes_and_at_the_vertices(rings, axis):
    with patch.object(assembly, "_stretch_weights", return_value=None):
        before = unbalanced(REGIONS[rings], axis)
    after = unbalanced(REGIONS[rings], axis)
    # Differences from alpha cost a tenth of what the balance at a node does; the rest is theirs.
    assert after[0] < 0.5 * before[0]
    assert after[1] < 0.5 * before[1]


def test_weights_stay_within_their_bounds_also_without_a_balance():
    """Gradients that no yarns can balance, here random ones, change weights by no more than their bounds."""
    region = REGIONS[2]
    random = np.random.default_rng(4).normal(size=(len(CLOTH.triangles), 3, 2))
    found = balanced_weights(region, replace(stretched_cloth(), gradients=100.0 * random))
    plain = 1.0 - region.triangle_alpha[:, None]
    most = MOST_CHANGE * np.minimum(plain, 1.0 - plain)
    assert (np.abs(found.triangles - plain) <= most + ROUNDING).all()
    simulated = region.element_alpha(stretched_cloth().segments) > 0.0
    assert found.segments[simulated].min() >= region.smallest_alpha - ROUNDING
    assert found.segments.max() <= 1.0 + ROUNDING


def test_the_least_squares_within_bounds_are_lowest_there():
    """No change of one weight within its bounds, which are the conditions of Kuhn and Tucker, lowers the sum."""
    from scipy.sparse import csr_array

    from stitchmesh.mixed.enrichment.balanced_weights import _within

    random = np.random.default_rng(8)
    matrix, right = random.normal(size=(40, 15)), random.normal(size=40)
    low, high = -0.1 * np.ones(15), 0.1 * np.ones(15)
    found = _within(csr_array(matrix), right, low, high)
    slope = matrix.T @ (matrix @ found - right)
    inner = (found > low + 1e-12) & (found < high - 1e-12)
    assert 0 < inner.sum() < 15
    assert np.abs(slope[inner]).max() < 1e-9  # rounding of sums of 40 numbers of size 1
    assert (slope[found >= high - 1e-12] <= 0.0).all()
    assert (slope[found <= low + 1e-12] >= 0.0).all()


def test_outside_the_hybrid_region_weights_are_those_of_the_region():
    region, cloth = REGIONS[2], stretched_cloth()
    found = balanced_weights(region, cloth)
    other = region.triangle_kind != HYBRID
    np.testing.assert_array_equal(
        found.triangles[other], np.repeat(1.0 - region.triangle_alpha[other, None], 2, axis=1)
    )
    alpha = region.element_alpha(cloth.segments)
    outside = (region.node_kind[cloth.segments] != HYBRID).all(axis=1)
    np.testing.assert_array_equal(found.segments[outside], alpha[outside])


def test_regions_of_many_segments_have_the_weights_of_alpha(monkeypatch):
    monkeypatch.setattr("stitchmesh.mixed.enrichment.balanced_weights.MOST_SEGMENTS", 10)
    found = balanced_weights(REGIONS[1], stretched_cloth())
    np.testing.assert_array_equal(found.segments, REGIONS[1].element_alpha(stretched_cloth().segments))
    np.testing.assert_array_equal(found.triangles[:, 0], 1.0 - REGIONS[1].triangle_alpha)


def test_yarns_alone_leave_no_weight_to_triangles():
    found = balanced_weights(enriched_everywhere(*PARTS), stretched_cloth())
    assert not found.triangles.any()
    assert (found.segments == 1.0).all()


def moved_nodes(deformation: np.ndarray) -> np.ndarray:
    """Distances by which nodes of the full-yarn region leave a uniform deformation [spacings of yarns]."""
    region = REGIONS[2]
    border = np.flatnonzero(FROM_MIDDLE > SIDE / 2 - 1e-9)
    vertices = CLOTH.vertices @ deformation.T
    scene = cloth_scene(FABRIC, region, vertices=border, gravity=(0.0, 0.0, 0.0), places=vertices)
    start = scene.positions.numpy()[1].copy()
    # forces of yarns at this strain are 40 dyn
    assert find_equilibrium(scene.system, scene.positions, EquilibriumSettings(force_tolerance=1e-3)).converged
    full = region.node_kind[region.nodes] == YARNS
    return np.linalg.norm(scene.positions.numpy()[1] - start, axis=1)[full] * DENSITY


@pytest.mark.parametrize(
    "deformation",
    [
        np.diag([1.0 + STRAIN, 1.0 + 0.5 * STRAIN, 1.0]),
        np.array([[1.0, STRAIN, 0.0], [STRAIN, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    ],
)
def test_uniform_deformation_passes_two_rings(deformation):
    moved = moved_nodes(deformation)
    # The rest is what changes of the weights by more than tenths would take away; with weights alpha it is 0.2.
    assert np.sqrt(np.mean(moved**2)) < 0.04 * STRAIN
