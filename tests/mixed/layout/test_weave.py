# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Weaves on panels: places of nodes, sides, order along yarns, seams with rods, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.cloth.seams import cloth_from_panels
from stitchmesh.mixed.layout.crossing_yarns import ROD, WARP, WEFT, CrossingYarns
from stitchmesh.mixed.layout.embedding import rest_positions
from stitchmesh.mixed.layout.weave import lay_weave
from tests.mixed.cloth.panel_shapes import OUTLINES, rectangle, side_by_side

PLAIN = np.array([[1, 0], [0, 1]])
TWILL = (np.subtract.outer(np.arange(4), np.arange(4)) % 4) < 2


def laid(name: str, matrix=PLAIN, ends: float = 2.0, picks: float = 3.0):
    cloth = cloth_from_panels([Panel(name=name, outline=OUTLINES[name])], [], edge_length=1.5)
    return cloth, lay_weave(cloth, matrix, ends=ends, picks=picks)


def check_yarns(cloth, yarns: CrossingYarns) -> None:
    """Each node lies in its triangle, and each yarn passes its nodes in order and at rest lengths that increase."""
    assert yarns.barycentric.min() >= 0.0
    np.testing.assert_allclose(yarns.barycentric.sum(axis=1), 1.0, atol=1e-15)
    made = rest_positions(cloth, yarns.triangle, yarns.barycentric)
    np.testing.assert_allclose(made, yarns.position, atol=1e-7)  # rounding of 1e-9 of the largest triangle edges
    np.testing.assert_array_equal(cloth.panel[yarns.triangle], yarns.panel)
    for leg, other in ((0, 1), (1, 0), (2, 3), (3, 2)):
        linked = np.flatnonzero(yarns.links[:, leg] >= 0)
        node, coordinate = np.divmod(yarns.links[linked, leg], 2)
        np.testing.assert_array_equal(yarns.links[node, 2 * coordinate + other % 2], 2 * linked + leg // 2)


def test_a_rectangle_has_each_crossing_once():
    yarns = lay_weave(cloth_from_panels([rectangle(5.0, 3.0)], [], edge_length=1.0), PLAIN, ends=4.0, picks=2.0)
    assert yarns.node_count == 20 * 6 and yarns.yarn_count == 26
    pairs = {tuple(pair) for pair in yarns.node_yarn.tolist()}
    assert len(pairs) == yarns.node_count
    x, y = np.unique(yarns.position[:, 0]), np.unique(yarns.position[:, 1])
    np.testing.assert_allclose(x, (np.arange(20) + 0.5) / 4, rtol=1e-14)
    np.testing.assert_allclose(y, (np.arange(6) + 0.5) / 2, rtol=1e-14)


@pytest.mark.parametrize("name", ["shirt", "disc"])
def test_yarns_run_straight_and_monotone_through_their_triangles(name):
    cloth, yarns = laid(name)
    check_yarns(cloth, yarns)
    for yarn in range(yarns.yarn_count):
        own = slice(yarns.yarn_start[yarn], yarns.yarn_start[yarn + 1])
        axis = {WEFT: 0, WARP: 1}[int(yarns.yarn_family[yarn])]
        place = yarns.position[yarns.yarn_node[own]]
        assert (np.diff(place[:, axis]) > 0).all() and np.ptp(place[:, 1 - axis]) == 0.0
        length = yarns.rest_sliding[yarns.yarn_node[own], yarns.yarn_coordinate[own]]
        np.testing.assert_allclose(length, place[:, axis] - place[0, axis], atol=1e-12)  # a sum of 100 steps
    assert yarns.rest_turn.max() < 1e-12
    np.testing.assert_allclose(yarns.rest_shear, np.pi / 2)


def test_a_bay_divides_the_yarns_that_cross_it():
    _, yarns = laid("corner", ends=1.0, picks=1.0)
    weft = yarns.node_yarn[np.isclose(yarns.position[:, 1], 10.5), 0]
    assert len(np.unique(weft)) == 1 and len(weft) == 5
    cloth = cloth_from_panels(
        [Panel(name="u", outline=[[0, 0], [9, 0], [9, 6], [6, 6], [6, 2], [3, 2], [3, 6], [0, 6]])], [], edge_length=1.0
    )
    yarns = lay_weave(cloth, PLAIN, ends=1.0, picks=1.0)
    high = np.isclose(yarns.position[:, 1], 4.5)
    assert len(np.unique(yarns.node_yarn[high, 0])) == 2 and np.count_nonzero(high) == 6


def test_sides_follow_the_matrix_from_the_top_left():
    matrix = np.array([[1, 0, 0], [0, 1, 1]])
    yarns = lay_weave(cloth_from_panels([rectangle(12.0, 12.0)], [], edge_length=2.0), matrix, ends=1.0, picks=1.0)
    side = np.zeros((12, 12))
    column, row = np.floor(yarns.position).astype(int).T
    side[11 - row, column] = yarns.side
    np.testing.assert_array_equal(side > 0, np.tile(matrix, (6, 4)).astype(bool))
    is_weft = yarns.yarn_family[yarns.node_yarn] == WEFT
    assert is_weft[:, 0].all() and not is_weft[:, 1].any()


def test_on_a_seam_every_weft_joins_the_rod():
    cloth = side_by_side(8.0, 10.0)
    yarns = lay_weave(cloth, PLAIN, ends=5.0, picks=5.0)
    check_yarns(cloth, yarns)
    rod = np.flatnonzero(yarns.yarn_family == ROD)
    assert len(rod) == 1 and np.count_nonzero(yarns.side == 0) == 40 + 50
    on_rod = np.flatnonzero(yarns.side == 0)
    assert (yarns.node_yarn[on_rod, 1] == rod[0]).all()
    assert (yarns.yarn_family[yarns.node_yarn[on_rod, 0]] == WEFT).all()
    assert ((yarns.links[on_rod, :2] >= 0).sum(axis=1) == 1).all()  # a weft ends at the rod
    edge = np.isin(yarns.triangle[on_rod], cloth.seam_sides // 3)
    assert edge.all() and ((yarns.barycentric[on_rod] == 0.0).sum(axis=1) >= 1).all()
    along = yarns.rest_sliding[on_rod, 1]
    assert np.diff(np.sort(along)).min() > 0.25 * 0.2 * (1 - 1e-9)  # a quarter of the distance of two yarns
    assert along.max() < 9.0  # the mean of both borders
    np.testing.assert_allclose(np.degrees(yarns.rest_shear[on_rod]), 90.0, atol=12.0)  # moved by a quarter at most


@pytest.mark.parametrize(
    ("matrix", "ends", "message"),
    [
        (np.zeros((0, 2)), 1.0, r"shape \(0, 2\)"),
        ([1, 0], 1.0, r"expected \(wefts, warps\)"),
        ([[1, 2]], 1.0, "other than 0 and 1"),
        (PLAIN, 0.0, "ends: got 0.0; expected a positive number"),
        (PLAIN, 0.01, "weave: no yarn has two nodes on the cloth; take a denser fabric"),
    ],
)
def test_what_is_refused(matrix, ends, message):
    cloth = cloth_from_panels([rectangle(5.0, 5.0)], [], edge_length=2.0)
    with pytest.raises(ParameterError, match=message) as caught:
        lay_weave(cloth, matrix, ends=ends, picks=1.0)
    assert "\n" not in str(caught.value)
