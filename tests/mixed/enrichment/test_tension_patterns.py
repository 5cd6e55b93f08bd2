# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The filter takes up what the gradient of alpha leaves unbalanced under uniform tension."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mixed.enrichment.embedding import Embedding, embed
from stitchmesh.mixed.enrichment.region import HYBRID, YARNS, Region, enriched_everywhere, region_around
from stitchmesh.mixed.enrichment.tension_patterns import tension_left
from tests.mixed.patch import square_patch

PATCH = square_patch(6, 4)
SEGMENTS = PATCH.segments()
FAMILY = np.repeat([0, 1], len(SEGMENTS) // 2)
MIDDLE = PATCH.near((0.5, 0.5), 0.2)


def unbalanced(region: Region) -> np.ndarray:
    """Forces of segments of unit tension and the weight of their element on all nodes, for both families; (N, 2)."""
    weight, force = region.element_alpha(SEGMENTS), np.zeros((len(PATCH.nodes), 2))
    for side, sign in ((0, 1.0), (1, -1.0)):
        np.add.at(force, (SEGMENTS[:, side], FAMILY), sign * weight)
    return force


def left_over(embedding: Embedding, force: np.ndarray) -> float:
    """Part of a force that the filter leaves, over all of it."""
    own = embedding.independent.toarray()
    part = own @ np.linalg.lstsq(own, force, rcond=None)[0]
    return float(np.linalg.norm(force - part) / np.linalg.norm(force))


@pytest.mark.parametrize("rings", [1, 2, 3])
def test_uniform_tension_has_forces_on_hybrid_nodes_alone_and_the_filter_takes_them_up(rings):
    region = region_around(*PATCH.layout, MIDDLE, rings=rings)
    force = unbalanced(region)
    inside = (PATCH.nodes[:, :2] > 0.1).all(axis=1) & (PATCH.nodes[:, :2] < 0.9).all(axis=1)  # not the ends of yarns
    assert not force[(region.node_kind == YARNS) & inside].any()
    pattern = tension_left(region, SEGMENTS, FAMILY)
    hybrid = region.node_kind == HYBRID
    np.testing.assert_array_equal(pattern[inside[hybrid]], force[hybrid & inside])
    # a pattern of which less than a tenth lies outside of what the filter removes without it is left out
    assert left_over(embed(region, pattern), pattern) < 0.1
    assert left_over(embed(region), pattern) > 0.2


def test_ends_of_yarns_and_yarns_everywhere_have_no_pattern():
    region = enriched_everywhere(*PATCH.layout)
    assert not tension_left(region, SEGMENTS, FAMILY).any()
    assert embed(region, tension_left(region, SEGMENTS, FAMILY)).patterns.shape[1] == 0


def test_columns_are_independent_and_those_of_the_triangles_stay():
    region = region_around(*PATCH.layout, MIDDLE, rings=2)
    plain, full = embed(region), embed(region, tension_left(region, SEGMENTS, FAMILY))
    np.testing.assert_array_equal(full.columns, plain.columns)
    own = full.independent.toarray()
    assert own.shape[1] > len(plain.columns)
    assert np.linalg.matrix_rank(own) == own.shape[1]
