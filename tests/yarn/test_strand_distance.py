# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The gap between a strand and the nearest other one; means at control points."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.lattice import Lattice
from stitchmesh.render.colouring import control_point_means
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.strand_distance import strand_distance
from stitchmesh.yarn.tiling import tile_yarns
from tests.io.yarn_sets import ring
from tests.yarnrelax.stockinette import woven_cell


def lines(*heights: float, radius: float = 0.1) -> YarnSet:
    """Straight open yarns along x, 4 cm long, at some heights."""
    along = np.linspace(0.0, 4.0, 30)
    curves = [np.stack([along, np.full(30, height), np.zeros(30)], axis=1) for height in heights]
    return YarnSet.from_curves(curves, closed=[False] * len(curves), radius=radius)


def test_parallel_yarns_are_apart_by_their_distance_less_two_radii():
    yarns = lines(0.0, 0.25, 0.65)
    gap = strand_distance(yarns).reshape(3, -1)
    # straight chords are exact; the sums of coordinates round
    np.testing.assert_allclose(gap[0], 0.05, atol=1e-12)
    np.testing.assert_allclose(gap[1], 0.05, atol=1e-12)
    np.testing.assert_allclose(gap[2], 0.20, atol=1e-12)


@pytest.mark.parametrize("closed", [True, False])
def test_a_ring_or_a_line_alone_has_no_other_strand(closed: bool):
    yarns = YarnSet.from_curves([ring([0, 0, 0])], closed=[True], radius=0.1) if closed else lines(0.0)
    assert (strand_distance(yarns) == 0.4).all()


def test_two_parts_of_one_yarn_are_strands_of_each_other():
    """A hairpin: two legs 0.5 cm apart and 4 cm long, with a bend between them."""
    leg = np.stack([np.linspace(0.0, 4.0, 40), np.zeros(40), np.zeros(40)], axis=1)
    bend = np.array([[4.1, 0.1, 0.0], [4.15, 0.25, 0.0], [4.1, 0.4, 0.0]])
    curve = np.concatenate([leg, bend, leg[::-1] + np.array([0, 0.5, 0])])
    yarns = YarnSet.from_curves([curve], closed=[False], radius=0.1)
    gap = strand_distance(yarns)
    np.testing.assert_allclose(gap[:20], 0.3, atol=1e-9)
    assert (gap >= 0.3 - 1e-9).all()


def test_a_yarn_that_repeats_lies_beside_its_own_images():
    """A straight yarn along the first period; its images are one second period away."""
    points = np.stack([np.arange(6) / 6, np.zeros(6), np.zeros(6)], axis=1)
    yarns = YarnSet(
        points=points, start=[0, 6], closed=[True], radius=[0.1], rest_length=np.full(6, 1 / 6), row=np.zeros(6),
        face=np.zeros(6), part=np.zeros(6), lattice=Lattice(np.array([[1.0, 0, 0], [0, 0.35, 0]])),
        lattice_step=[[1, 0]],
    )  # fmt: skip
    np.testing.assert_allclose(strand_distance(yarns), 0.15, atol=1e-12)


def test_a_cell_has_the_gaps_of_the_middle_of_its_tiling():
    cell = woven_cell()
    tiles = tile_yarns(cell, 5, 5, periodic=True)
    whole = strand_distance(tiles)
    own = strand_distance(cell)
    # the tiling holds each segment of the cell 25 times, and all places of a periodic fabric are alike
    np.testing.assert_allclose(np.sort(whole), np.sort(np.tile(own, 25)), atol=1e-9)


def test_means_at_control_points_keep_a_constant_and_the_order_of_the_segments():
    open_yarns = lines(0.0, 1.0)
    np.testing.assert_array_equal(control_point_means(open_yarns, np.full(54, 2.5)), 2.5)
    means = control_point_means(open_yarns, np.tile(np.arange(27.0), 2)).reshape(2, 30)
    np.testing.assert_array_equal(means[0], [0, 0, *(np.arange(26) + 0.5), 26, 26])
    np.testing.assert_array_equal(means[0], means[1])
    closed = YarnSet.from_curves([ring([0, 0, 0])], closed=[True], radius=0.1)
    values = np.random.default_rng(1).random(40)
    assert control_point_means(closed, values).sum() == pytest.approx(values.sum(), rel=1e-14)  # rounding


def test_pressed_yarns_have_a_negative_gap():
    np.testing.assert_allclose(strand_distance(lines(0.0, 0.15)), -0.05, atol=1e-12)
