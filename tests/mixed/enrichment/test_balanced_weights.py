# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Weights of triangles with which uniform tension of triangles and yarns balances at the vertices."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mixed.dynamics.cloth_system import ClothModel, cloth_system
from stitchmesh.mixed.enrichment.balanced_weights import MOST_CHANGE, balanced_weights
from stitchmesh.mixed.enrichment.region import HYBRID, Region, enriched_everywhere, region_around
from tests.mixed.dynamics.scene import CPU
from tests.mixed.dynamics.test_uniform_stretch import CLOTH, FROM_MIDDLE, LAYOUT, MATERIAL, MIDDLE, SIDE, STRAIN, YARN

INNER = np.flatnonzero(FROM_MIDDLE < SIDE / 2 - 1e-9)


def unbalanced(region: Region, axis: int, *, balanced: bool) -> np.ndarray:
    """Forces f_v + B' f_p on the inner vertices of the hybrid region under uniform stretch, over the tension per cm."""
    model = ClothModel(MATERIAL, YARN, acceleration=(0.0, 0.0, 0.0))
    stretch = np.eye(3)
    stretch[axis, axis] += STRAIN
    if not balanced:
        weave_only = pytest.MonkeyPatch()
        weave_only.setattr(
            "stitchmesh.mixed.dynamics.cloth_system.balanced_weights", lambda region, *rest: 1.0 - region.triangle_alpha
        )
    made = cloth_system(CLOTH, LAYOUT, region, model, vertices=CLOTH.vertices @ stretch.T, device=CPU)
    if not balanced:
        weave_only.undo()
    force = made.system.zeros()
    made.system.set_forces(made.positions, force)
    of_vertices, of_nodes, _ = force.numpy()
    embedding = made.system.embedding
    total = of_vertices + embedding.basis.T @ of_nodes[embedding.nodes]
    held = np.intersect1d(region.triangles[region.triangle_kind == HYBRID], INNER)
    return total[held, axis] / (MATERIAL.stretch_course * STRAIN)


@pytest.mark.parametrize(("rings", "share"), [(1, 0.6), (2, 0.1)])
def test_uniform_tension_balances_better_at_the_vertices(rings, share):
    region = region_around(CLOTH.triangles, len(CLOTH.vertices), LAYOUT.triangle, LAYOUT.barycentric, MIDDLE,
                           rings=rings)  # fmt: skip
    before, after = (
        np.linalg.norm([unbalanced(region, axis, balanced=balanced) for axis in (0, 1)]) for balanced in (False, True)
    )
    # one ring has more conditions than triangles; the damping leaves a part of the rest
    assert after < share * before


def test_weights_stay_between_those_of_triangles_and_yarns():
    """Yarns that are no sample of the triangles, here none at all, change weights by half of them at most."""
    region = region_around(CLOTH.triangles, len(CLOTH.vertices), LAYOUT.triangle, LAYOUT.barycentric, MIDDLE, rings=2)
    gradients = np.random.default_rng(4).normal(size=(len(CLOTH.triangles), 3, 2))
    none = np.zeros((int((region.node_kind == HYBRID).sum()), 2))
    border = np.zeros(len(CLOTH.vertices), dtype=bool)
    found, plain = (
        balanced_weights(region, gradients, CLOTH.rest_area, border, none, [0.1, 0.1]),
        1 - region.triangle_alpha,
    )
    assert (np.abs(found - plain) <= MOST_CHANGE * np.minimum(plain, 1.0 - plain) + 1e-15).all()
    np.testing.assert_array_equal(found[region.triangle_kind != HYBRID], plain[region.triangle_kind != HYBRID])


def test_yarns_alone_leave_no_weight_to_triangles():
    region = enriched_everywhere(CLOTH.triangles, len(CLOTH.vertices), LAYOUT.triangle, LAYOUT.barycentric)
    pattern = np.ones((len(LAYOUT.triangle), 2))
    border = np.zeros(len(CLOTH.vertices), dtype=bool)
    gradients = np.ones((len(CLOTH.triangles), 3, 2))
    assert not balanced_weights(region, gradients, CLOTH.rest_area, border, pattern, [0.1, 0.1]).any()
