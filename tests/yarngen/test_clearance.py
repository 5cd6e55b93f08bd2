# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The pairs of near points are those of all pairs, whatever the blocks, the place and the size."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.yarngen import clearance
from stitchmesh.yarngen.clearance import near_pairs


def points_in_a_box(extent: tuple[float, float, float]) -> np.ndarray:
    """600 points, and some of them once more in the same place."""
    points = np.random.default_rng(5).uniform(0.0, 1.0, (600, 3)) * extent
    return np.concatenate([points, points[:3]])


BOXES = [(9.0, 5.0, 7.0), (300.0, 0.5, 0.5), (0.5, 300.0, 0.5), (0.5, 0.5, 300.0), (0.1, 0.1, 0.1)]


@pytest.mark.parametrize("extent", BOXES)
def test_each_pair_up_to_the_distance_is_found_once(extent, monkeypatch):
    monkeypatch.setattr(clearance, "POINTS_OF_BLOCK", 70)
    points, within = points_in_a_box(extent) - 2.0, 0.6
    pairs, distance = near_pairs(points, within)

    apart = np.linalg.norm(points[:, None] - points, axis=2)
    one, other = np.nonzero(np.triu(apart <= within, k=1))
    assert len(one) > 100
    np.testing.assert_array_equal(pairs[np.lexsort(pairs.T[::-1])], np.stack([one, other], axis=1))
    np.testing.assert_array_equal(distance, apart[tuple(pairs.T)])


def test_points_that_are_very_far_apart_share_a_grid_of_limited_size():
    points = np.concatenate([points_in_a_box((1.0, 1.0, 1.0)), [[1e9, -1e9, 1e9]]])
    pairs, _ = near_pairs(points, 1e-3)
    assert set(map(tuple, pairs.tolist())) >= {(0, 600), (1, 601), (2, 602)}
