# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The nearest segments are those that a search through all pairs of samples finds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.lattice import Lattice
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.clearance import SAMPLES_PER_SEGMENT, crowded_points, smallest_distance

LATTICE = Lattice(np.array([[4.0, 0.3, 0.0], [-0.2, 3.0, 0.0]]))
WITHIN = 0.15
EVERYWHERE = [(9.0, 5.0, 7.0), (300.0, 0.5, 0.5), (0.5, 0.5, 300.0)]


def wandering_yarns(extent: tuple[float, float, float], lattice: Lattice | None = None) -> YarnSet:
    """Four yarns with control points in a box, two of them closed; on a lattice one of the two closes a period on."""
    choose = np.random.default_rng(5)
    curves = [np.cumsum(choose.normal(0.0, 0.25, (30, 3)), axis=0) for _ in range(4)]
    curves = [(curve - curve[0]) % 1.0 * extent if lattice is None else curve for curve in curves]
    yarns = YarnSet.from_curves(curves, closed=[True, False, True, False], radius=0.2)
    if lattice is None:
        return yarns
    step = np.array([[0, 0], [0, 0], [1, -1], [0, 0]])
    return replace(yarns, lattice=lattice, lattice_step=step)


def nearest_of_all_pairs(yarns: YarnSet, images: list[tuple[int, int]]) -> np.ndarray:
    """Distance of each segment from the nearest one in these images, other than two segments on along its yarn."""
    count, yarn = len(yarns.segment_points), yarns.segment_yarn
    samples = yarns.samples(SAMPLES_PER_SEGMENT).reshape(count, -1, 3)
    size = np.diff(yarns.segment_start)[yarn]
    step = np.zeros((yarns.yarn_count, 2)) if yarns.lattice_step is None else yarns.lattice_step
    ahead = np.arange(count) - np.arange(count)[:, None]
    nearest = np.full(count, np.inf)
    for image in images:
        shift = np.zeros(3) if yarns.lattice is None else yarns.lattice.shift(image)
        apart = np.linalg.norm(samples[:, None, :, None] - samples[None, :, None] - shift, axis=4).min(axis=(2, 3))
        for turn in (-1, 0, 1):
            back = (turn * step == image).all(axis=1) & (yarns.closed | (turn == 0))
            excluded = (yarn == yarn[:, None]) & back[yarn] & (np.abs(ahead + turn * size) <= 2)
            apart[excluded] = np.inf
        nearest = np.minimum(nearest, apart.min(axis=1))
    return nearest


def check_found(yarns: YarnSet, nearest: np.ndarray) -> None:
    assert 10 < (nearest <= WITHIN).sum() < len(nearest) - 10
    distance, points = smallest_distance(yarns, WITHIN)
    assert distance == pytest.approx(nearest.min(), rel=1e-12)  # rounding of a difference and of a root
    assert nearest[yarns.segment_points[:, 1].tolist().index(points[0])] == nearest.min()
    expected = np.unique(yarns.segment_points[nearest <= WITHIN, 1])
    np.testing.assert_array_equal(crowded_points(yarns, WITHIN), expected)


@pytest.mark.decides
@pytest.mark.parametrize("extent", EVERYWHERE)
def test_all_near_segments_are_found_whatever_the_place_and_the_size_of_the_box(extent):
    yarns = wandering_yarns(extent)
    check_found(yarns, nearest_of_all_pairs(yarns, [(0, 0)]))


@pytest.mark.decides
def test_segments_of_all_images_are_found_from_any_cell():
    yarns = wandering_yarns((1.0, 1.0, 1.0), LATTICE)
    images = [(a, b) for a in range(-3, 4) for b in range(-3, 4)]
    check_found(yarns, nearest_of_all_pairs(yarns, images))


def test_yarns_that_are_very_far_apart_share_a_grid_of_limited_size():
    near = [np.arange(12.0)[:, None] * [0.3, 0.0, 0.0] + [0.0, y, 0.0] for y in (0.0, 1e-3)]
    yarns = YarnSet.from_curves([*near, near[0] + 1e9], closed=[False] * 3, radius=0.1)
    distance, _ = smallest_distance(yarns, 2e-3)
    assert distance == pytest.approx(1e-3, rel=1e-9)  # rounding of coordinates of some cm


def test_no_distance_is_found_between_neighbours_along_a_yarn():
    yarns = YarnSet.from_curves([np.arange(12.0)[:, None] * [1e-4, 0.0, 0.0]], closed=[False], radius=0.1)
    assert smallest_distance(yarns, 2.2e-4) == (np.inf, (0, 0))
    assert not len(crowded_points(yarns, 2.2e-4))
    # the last sample of a segment, and the first one of the third segment after it
    assert smallest_distance(yarns, 2.3e-4)[0] == pytest.approx(2.25e-4, rel=1e-9)  # rounding of coordinates
