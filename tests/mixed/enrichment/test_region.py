# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Kinds of triangles, the blending field and the unknowns of a region."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.enrichment.region import HYBRID, TRIANGLES, YARNS, FreeUnknowns, region_around
from tests.mixed.patch import enriched_everywhere, square_patch

PATCH = square_patch(8, 3)
CHOSEN = PATCH.near((0.5, 0.5), 0.26)


def test_alpha_falls_linearly_over_the_rings_from_the_yarns():
    rings = 3
    region = region_around(*PATCH.layout, CHOSEN, rings=rings)
    x, y = np.round(PATCH.vertices[:, :2] * 8 - 4).T
    # The diagonals of the squares run along (1, 1): a ring reaches one square further in x, in y, and in both where
    # their signs agree.
    beyond = np.stack([x - 2, y - 2, -2 - x, -2 - y])
    alpha = region.vertex_alpha
    assert np.all(alpha[beyond.max(axis=0) <= 0] == 1.0)
    along = (y == 0) & (x >= 2)
    np.testing.assert_allclose(alpha[along], np.clip(1 - (x[along] - 2) / rings, 0, 1), atol=1e-15)
    assert set(region.triangle_kind[region.triangle_alpha == 0.0]) == {TRIANGLES}
    assert np.all(region.triangle_alpha[CHOSEN] == 1.0)


def test_hybrid_triangles_separate_yarns_from_triangles():
    region = region_around(*PATCH.layout, CHOSEN)
    touched = [set(PATCH.triangles[region.triangle_kind == kind].ravel()) for kind in (TRIANGLES, YARNS)]
    assert not touched[0] & touched[1]
    blended = (region.triangle_alpha > 0.0) & (region.triangle_alpha < 1.0)
    np.testing.assert_array_equal(region.triangle_kind == HYBRID, blended)
    assert set(CHOSEN) <= set(np.flatnonzero(region.triangle_kind == YARNS))


def test_alpha_of_a_node_is_interpolated_and_that_of_an_element_is_clamped():
    region = region_around(*PATCH.layout, CHOSEN)
    np.testing.assert_array_equal(region.node_alpha[region.node_kind == YARNS], 1.0)
    np.testing.assert_array_equal(region.node_alpha[region.node_kind == TRIANGLES], 0.0)
    segments = PATCH.segments()
    alpha = region.element_alpha(segments)
    simulated = (region.node_number[segments] >= 0).all(axis=1)
    assert np.all(alpha[~simulated] == 0.0)
    assert region.node_alpha[region.node_kind == HYBRID].min() == region.smallest_alpha
    assert alpha[simulated].min() >= region.smallest_alpha
    of_nodes = region.node_alpha[segments][simulated]
    touching = (of_nodes == 1.0).any(axis=1)  # no gradient of alpha acts on a node of the full-yarn region
    np.testing.assert_allclose(alpha[simulated], np.where(touching, 1.0, of_nodes.mean(axis=1)), atol=1e-15)


def test_vertices_among_full_yarn_triangles_alone_are_not_unknown():
    region = region_around(*PATCH.layout, PATCH.near((0.5, 0.5), 0.26))
    inner = np.setdiff1d(np.arange(81), PATCH.triangles[region.triangle_kind != YARNS])
    assert len(inner) == 9
    np.testing.assert_array_equal(np.flatnonzero(~region.unknown_vertices), inner)


def test_eulerian_coordinates_exist_at_alpha_of_one_only():
    region = region_around(*PATCH.layout, CHOSEN)
    np.testing.assert_array_equal(region.sliding_nodes, region.node_alpha[region.nodes] == 1.0)
    assert region.sliding_nodes.sum() >= (region.node_kind == YARNS).sum()
    free = FreeUnknowns.of(region, fixed_vertices=[0], fixed_nodes=region.nodes[:2])
    assert not free.vertices[0]
    assert not free.nodes[:2].any()
    assert free.nodes[2:].all()


def test_no_region_and_regions_of_all_triangles():
    none = region_around(*PATCH.layout, [])
    assert len(none.nodes) == 0
    assert none.unknown_vertices.all()
    every = region_around(*PATCH.layout, np.arange(len(PATCH.triangles)))
    assert np.all(every.triangle_kind == YARNS)
    assert not every.unknown_vertices.any()
    hybrid = enriched_everywhere(*PATCH.layout)
    assert np.all(hybrid.triangle_kind == HYBRID)
    np.testing.assert_allclose(hybrid.node_alpha, 1.0, atol=1e-15)


def test_regions_that_meet_merge_and_a_region_may_touch_the_border():
    left, right = PATCH.near((0.3, 0.5), 0.15), PATCH.near((0.6, 0.5), 0.15)
    merged = region_around(*PATCH.layout, np.concatenate([left, right]))
    for part in (left, right):
        alone = region_around(*PATCH.layout, part)
        assert np.all(merged.vertex_alpha >= alone.vertex_alpha)
    border = region_around(*PATCH.layout, [0])
    assert (border.triangle_alpha == 1.0).sum() == 1


def test_numbers_out_of_range_are_refused():
    with pytest.raises(ParameterError, match="yarn triangles: got the number 128; expected 0 to 127"):
        region_around(*PATCH.layout, [128])
    with pytest.raises(ParameterError, match="got 0 hybrid rings; expected at least 1"):
        region_around(*PATCH.layout, CHOSEN, rings=0)
    with pytest.raises(ParameterError, match=r"got the smallest weight 0\.0"):
        region_around(*PATCH.layout, CHOSEN, smallest_alpha=0.0)
    with pytest.raises(ParameterError, match="fixed nodes: got the number -1"):
        FreeUnknowns.of(region_around(*PATCH.layout, CHOSEN), fixed_nodes=[-1])
