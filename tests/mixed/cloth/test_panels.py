# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangles of flat panels: areas, borders, shapes of triangles, and outlines that are refused."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.cloth.outline import signed_area
from stitchmesh.mixed.cloth.panels import Panel, PanelTriangles, triangulate, with_edges
from tests.mixed.cloth.panel_shapes import OUTLINES, rectangle


def areas(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def smallest_angle(made: PanelTriangles) -> float:
    corners = made.points[made.triangles]
    one, other = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    cosine = (one * other).sum(axis=2) / np.linalg.norm(one, axis=2) / np.linalg.norm(other, axis=2)
    return float(np.degrees(np.arccos(cosine.max())))


@pytest.mark.parametrize(("name", "edge_length"), [("shirt", 0.7), ("disc", 2.5), ("strip", 0.7), ("needle", 2.5)])
def test_triangles_fill_the_outline_and_keep_its_border(name, edge_length):
    panel = Panel(name=name, outline=OUTLINES[name])
    made = triangulate(panel, edge_length)
    area = areas(made.points, made.triangles)
    assert area.min() > 0.0
    np.testing.assert_allclose(area.sum(), signed_area(panel.corners), rtol=1e-12)  # a sum of rounded areas
    border = np.arange(made.corner_point[-1])
    sides = {tuple(side) for t in made.triangles.tolist() for side in zip(t, t[1:] + t[:1], strict=True)}
    assert all((k, (k + 1) % len(border)) in sides for k in border.tolist())
    np.testing.assert_array_equal(made.points[made.corner_point[:-1]], panel.corners)


def test_triangles_have_no_small_angles():
    made = triangulate(Panel(name="shirt", outline=OUTLINES["shirt"]), 1.0)
    assert smallest_angle(made) > 20.7  # the bound of Ruppert's refinement for outlines without sharp corners


def test_sides_are_divided_evenly_into_given_numbers_of_edges():
    made = triangulate(rectangle(6.0, 4.0, side_edges=(3, 7, 5, 1)), 1.0)
    np.testing.assert_array_equal(made.corner_point, [0, 3, 10, 15, 16])
    for side, count in enumerate((3, 7, 5, 1)):
        line = made.points[made.border_from(side, (side + 1) % 4)]
        assert len(line) == count + 1
        np.testing.assert_allclose(np.diff(line, 2, axis=0), 0.0, atol=1e-14)  # rounding of the places


def test_a_missing_edge_is_recovered_by_flips():
    # a fan whose long diagonals cross the wanted edge from 0 to 1; the points in between are near the edge
    points = np.array(
        [[0.0, 0.0], [10.0, 0.0], [5.0, 6.0], [5.0, -6.0], [2.0, 0.3], [4.0, -0.3], [6.0, 0.3], [8.0, -0.3]]
    )
    from scipy.spatial import Delaunay

    triangles = Delaunay(points).simplices
    triangles = np.where((areas(points, triangles) < 0)[:, None], triangles[:, ::-1], triangles)
    made = with_edges(points, triangles, np.array([[0, 1]]))
    assert any({0, 1} <= set(triangle) for triangle in made.tolist())
    assert areas(points, made).min() > 0.0
    np.testing.assert_allclose(areas(points, made).sum(), areas(points, triangles).sum(), rtol=1e-14)


BAD = {
    "cross or touch": [[0, 0], [10, 10], [10, 0], [0, 10]],
    "sides 0-1 and 3-4: cross or touch": [[0, 0], [10, 0], [10, 5], [8, 5], [5, 0], [2, 5], [0, 5]],
    "runs clockwise": [[0, 0], [0, 10], [10, 10], [10, 0]],
    "sides 0-1 and 2-0: cross or touch": [[0, 0], [1, 0], [2, 0]],
    "corners 1 and 2: lie at the same place": [[0, 0], [1, 0], [1, 0], [0, 1]],
    "got 2 corners": [[0, 0], [1, 0]],
    "two finite numbers": [[0, 0], [1, 0], [np.nan, 1]],
    "got several rings": [[[0, 0], [9, 0], [9, 9], [0, 9]], [[1, 1], [2, 1], [1, 2]]],
    "got 2 rings": [[[0, 0], [9, 0], [0, 9]], [[1, 1], [2, 1], [1, 2]]],
    "expected corners": [1.0, 2.0, 3.0],
}


@pytest.mark.parametrize("message", BAD)
def test_outlines_that_are_refused(message):
    with pytest.raises(ParameterError, match=message) as caught:
        Panel(name="front", outline=BAD[message])
    assert "panel 'front'" in str(caught.value) and "\n" not in str(caught.value)


def test_edges_that_are_refused():
    with pytest.raises(ParameterError, match=r"at least 0\.0001 cm"):
        triangulate(rectangle(1.0, 1.0), np.nan)
    with pytest.raises(ParameterError, match=r"side 0: needs 1e\+08 edges of 1 cm; expected at most 4,000,000"):
        triangulate(rectangle(1e8, 1e8), 1.0)
    with pytest.raises(ParameterError, match=r"needs .* points; expected at most"):
        triangulate(rectangle(100.0, 100.0, side_edges=(1, 1, 1, 1)), 1e-4)
    with pytest.raises(ParameterError, match="side_edges"):
        rectangle(1.0, 1.0, side_edges=(1, 2, 3))
