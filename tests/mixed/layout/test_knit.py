# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knits on panels: four nodes for each loop, their order along the yarn, sides, contacts, seams and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.cloth.panels import Panel, PanelPosition
from stitchmesh.mixed.cloth.seams import PanelBorder, PanelSeam, cloth_from_panels
from stitchmesh.mixed.layout.knit import P, Q, lay_knit
from tests.mixed.cloth.panel_shapes import rectangle
from tests.mixed.layout.test_weave import check_yarns

WALE, COURSE = 0.5, 0.4


def stocking(columns: int = 10, rows: int = 8, chart=((1,),)):
    cloth = cloth_from_panels([rectangle(columns * WALE, rows * COURSE)], [], edge_length=1.0)
    return cloth, lay_knit(cloth, chart, wale_spacing=WALE, course_spacing=COURSE)


def test_the_nodes_are_the_crossings_of_neighbouring_loops_of_the_closed_curve():
    from scipy.optimize import fsolve

    def curve(t):
        return np.array([(t + 1.5 * np.sin(2 * t)) / (2 * np.pi), 4 * np.cos(t) / 4.5])

    for guess, (x, y) in (((-1.4, -2.8), P), ((-0.3, -1.7), Q)):
        old, new = fsolve(lambda t: curve(t[0]) - curve(t[1]) - [0.0, 1.0], guess, xtol=1e-14)
        np.testing.assert_allclose(curve(old) - [0.0, 0.5], [-x, y], atol=1e-13)  # tolerance of the root
        upper_is_new = np.cos(2 * new) < np.cos(2 * old)  # the curve's right side looks along -z
        assert upper_is_new == (y > 0)


def test_a_rectangle_of_loops():
    cloth, yarns = stocking(10, 8)
    check_yarns(cloth, yarns)
    assert yarns.node_count == 4 * 10 * 7 and yarns.yarn_count == 8
    assert len(yarns.stitch_contacts) == 2 * 10 * 7
    assert (np.diff(yarns.yarn_start) == [40, *[80] * 6, 40]).all()


def test_the_order_of_the_nodes_along_a_loop():
    _, yarns = stocking(10, 8)
    middle = 3  # a course with loops below and above
    own = slice(yarns.yarn_start[middle], yarns.yarn_start[middle + 1])
    coordinate = yarns.yarn_coordinate[own].reshape(10, 8)
    np.testing.assert_array_equal(coordinate, np.tile([0, 0, 1, 1, 1, 1, 0, 0], (10, 1)))
    place = yarns.position[yarns.yarn_node[own]].reshape(10, 8, 2) - np.array([0.5 * WALE, (middle + 0.5) * COURSE])
    place[:, :, 0] -= np.arange(10)[:, None] * WALE
    low = np.array([P[1] - 0.5, Q[1] - 0.5, P[1] + 0.5, Q[1] + 0.5])
    expected_y = COURSE * np.array([low[0], low[1], low[2], low[3], low[3], low[2], low[1], low[0]])
    expected_x = WALE * np.array([-P[0], -Q[0], -P[0], -Q[0], Q[0], P[0], Q[0], P[0]])
    np.testing.assert_allclose(place[:, :, 1], np.tile(expected_y, (10, 1)), atol=1e-13)
    np.testing.assert_allclose(place[:, :, 0], np.tile(expected_x, (10, 1)), atol=1e-13)


def test_the_outer_neighbours_lie_to_the_left_of_a_contact_at_a_left_foot():
    _, yarns = stocking()
    partner = np.full(yarns.node_count, -1)
    partner[yarns.stitch_contacts] = yarns.stitch_contacts[:, ::-1]
    number = np.empty(yarns.node_count, dtype=int)
    number[yarns.stitch_contacts] = np.arange(len(yarns.stitch_contacts))[:, None]
    before, after = yarns.neighbours[:, 0], yarns.neighbours[:, 1]
    link = np.where(before == partner, after, before)
    at_p = np.flatnonzero((link >= 0) & (yarns.position[:, 1] < yarns.position[partner, 1]))
    p = yarns.position[at_p]
    axis, leg = yarns.position[partner[at_p]] - p, yarns.position[link[at_p]] - p
    turn = axis[:, 0] * leg[:, 1] - axis[:, 1] * leg[:, 0]
    np.testing.assert_array_equal(turn > 0, yarns.stitch_left[number[at_p]])
    assert np.count_nonzero(yarns.stitch_left) * 2 == len(yarns.stitch_left)


@pytest.mark.parametrize("chart", [[[1, 0]], [[1], [0]], [[1, 1, 0], [0, 1, 1]]])
def test_sides_follow_the_chart_with_its_last_row_first(chart):
    _, yarns = stocking(12, 8, chart)
    chart = np.array(chart)
    above = yarns.position[:, 1] / COURSE
    row, column = np.round(above).astype(int), np.floor(yarns.position[:, 0] / WALE).astype(int)
    at_head = above > row  # Q lies above the border of the two loops
    is_knit = chart[(-1 - row) % len(chart), column % chart.shape[1]] == 1
    np.testing.assert_array_equal(yarns.side > 0, is_knit == at_head)


def test_lengths_of_yarn_are_those_of_the_polygon_of_a_loop():
    _, yarns = stocking(10, 8)
    middle = slice(yarns.yarn_start[3], yarns.yarn_start[4])
    node, coordinate = yarns.yarn_node[middle], yarns.yarn_coordinate[middle]
    step = np.linalg.norm(np.diff(yarns.position[node], axis=0), axis=1)
    np.testing.assert_allclose(np.diff(yarns.rest_sliding[node, coordinate]), step, rtol=1e-12)
    contact = np.hypot((P[0] - Q[0]) * WALE, (Q[1] - P[1]) * COURSE)
    leg = np.hypot((P[0] - Q[0]) * WALE, (1 + P[1] - Q[1]) * COURSE)
    loop = 4 * contact + 2 * leg + 2 * Q[0] * WALE + (1 - 2 * P[0]) * WALE
    np.testing.assert_allclose(step.sum() + (1 - 2 * P[0]) * WALE, 10 * loop, rtol=1e-12)


def test_loops_fill_a_panel_up_to_slanted_borders():
    """The outermost cells end at the border, less than two wales wide, and Q stands at 0.5 - Q of a cell."""
    low, high = np.array([[0.1, 5.2], [0.7, 4.3]])  # where the border is at the foot and at the top
    outline = [(low[0], 0.0), (low[1], 0.0), (high[1], 3.2), (high[0], 3.2)]
    cloth = cloth_from_panels([Panel(name="slanted", outline=outline)], [], edge_length=1.0)
    yarns = lay_knit(cloth, [[1]], wale_spacing=WALE, course_spacing=COURSE)
    check_yarns(cloth, yarns)
    height = np.rint(yarns.position[:, 1] / COURSE * 1e6)
    assert len(np.unique(height)) == 2 * 7  # P and Q between eight courses
    for level in np.unique(height):
        own = yarns.position[height == level]
        border = low + (high - low) * own[0, 1] / 3.2
        gaps = np.array([own[:, 0].min() - border[0], border[1] - own[:, 0].max()])
        assert (gaps > 0.0).all() and (gaps < 2.0 * (0.5 - Q[0]) * WALE).all()


def test_heads_and_feet_are_joined_to_a_seam_along_a_course():
    panels = [
        rectangle(5.0, 4.0, "low"),
        rectangle(5.0, 4.0, "high", position=PanelPosition(origin=(0.0, 4.0, 0.0))),
    ]
    seam = PanelSeam(first=PanelBorder(panel="low", start=2, end=3), second=PanelBorder(panel="high", start=0, end=1))
    cloth = cloth_from_panels(panels, [seam], edge_length=1.0)
    yarns = lay_knit(cloth, [[1]], wale_spacing=WALE, course_spacing=COURSE)
    check_yarns(cloth, yarns)
    on_rod = yarns.side == 0
    assert np.count_nonzero(on_rod & (yarns.panel == 0)) == 10  # a head for each loop
    assert np.count_nonzero(on_rod & (yarns.panel == 1)) == 9  # between the feet of ten loops
    assert (yarns.neighbours[on_rod, :2] >= 0).all()  # the yarn goes on


@pytest.mark.parametrize(
    ("chart", "spacing", "message"),
    [
        (np.zeros((2, 0)), 0.5, r"shape \(2, 0\)"),
        ([[1]], -1.0, "wale spacing: got -1.0; expected a positive number of cm"),
        ([[1]], 20.0, "knit: no yarn has two nodes on the cloth"),
    ],
)
def test_what_is_refused(chart, spacing, message):
    cloth = cloth_from_panels([rectangle(5.0, 5.0)], [], edge_length=2.0)
    with pytest.raises(ParameterError, match=message) as caught:
        lay_knit(cloth, chart, wale_spacing=spacing, course_spacing=0.4)
    assert "\n" not in str(caught.value)
