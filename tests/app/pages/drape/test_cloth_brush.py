# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which triangles a brush covers."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.app.pages.drape.paint_tool import covered_triangles
from stitchmesh.mesh import BORDER
from stitchmesh.mesh.picking import PickedPlace
from stitchmesh.mixed.cloth.cloth import Cloth, border_sides
from stitchmesh.mixed.cloth.panels import Panel, PanelPosition
from stitchmesh.mixed.cloth.seams import cloth_from_panels

SQUARE = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]
CLOTH = cloth_from_panels(
    [Panel(name="front", outline=SQUARE, position=PanelPosition(origin=(0.0, 0.0, 0.3))),
     Panel(name="back", outline=SQUARE)], (), edge_length=0.8,
)  # fmt: skip
"""Two layers, 0.3 cm apart."""
CENTRE = CLOTH.vertices[CLOTH.triangles].mean(axis=1)


def place(face: int) -> PickedPlace:
    return PickedPlace(face, 3 * face, 3 * face, int(CLOTH.triangles[face, 0]), CENTRE[face], 10.0)


def middle_of(panel: int) -> int:
    own = np.flatnonzero(CLOTH.panel == panel)
    return int(own[np.linalg.norm(CENTRE[own, :2] - [2.0, 2.0], axis=1).argmin()])


def test_a_circle_covers_the_triangles_around_its_place_on_the_same_layer():
    face = middle_of(0)
    covered = covered_triangles(CLOTH, CLOTH.vertices, "Circle", [place(face)], 1.2)
    near = np.flatnonzero((np.linalg.norm(CENTRE - CENTRE[face], axis=1) <= 1.2) & (CLOTH.panel == 0))
    assert np.array_equal(covered, near) and 5 < len(covered) < (CLOTH.panel == 0).sum()


def test_a_circle_smaller_than_a_triangle_covers_the_triangle():
    assert covered_triangles(CLOTH, CLOTH.vertices, "Circle", [place(middle_of(1))], 1e-3).tolist() == [middle_of(1)]


@pytest.mark.parametrize("brush", ["Triangle", "Circle", "Panel"])
def test_a_path_covers_what_its_places_cover(brush):
    path = [place(middle_of(0)), place(0), place(middle_of(1))]
    parts = [covered_triangles(CLOTH, CLOTH.vertices, brush, [one], 0.9) for one in path]
    assert np.array_equal(covered_triangles(CLOTH, CLOTH.vertices, brush, path, 0.9), np.unique(np.concatenate(parts)))
    if brush == "Panel":
        assert np.array_equal(parts[2], np.flatnonzero(CLOTH.panel == 1))  # the panel as a whole


def test_the_border_is_covered_along_its_nearest_side():
    low = int(np.argmin(np.where(CLOTH.panel == 0, np.linalg.norm(CENTRE[:, :2] - [2.0, 0.3], axis=1), np.inf)))
    covered = covered_triangles(CLOTH, CLOTH.vertices, "Border", [place(low)], 0.0)
    sides = np.flatnonzero(CLOTH.twin == BORDER)
    ends = CLOTH.vertices[CLOTH.side_vertices[sides]]
    lower = (ends[:, :, 1] == 0.0).all(axis=1) & (CLOTH.panel[sides // 3] == 0)
    assert np.array_equal(covered, np.unique(sides[lower] // 3)) and lower.sum() == 5


def test_the_border_of_a_square_has_four_sides_and_that_of_a_cylinder_two():
    assert len(border_sides(CLOTH)) == 2 * 4
    turns = np.linspace(0.0, 2.0 * np.pi, 10, endpoint=False)  # A coarse hem: it turns by 36 degrees at each vertex.
    ring = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    rings = np.concatenate([np.column_stack([ring, np.full(10, height)]) for height in (0.0, 1.0)])
    here, there = np.arange(10), np.roll(np.arange(10), -1)
    triangles = np.concatenate([np.stack([here, there, here + 10], 1), np.stack([there, there + 10, here + 10], 1)])
    flat = np.tile([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], (20, 1, 1))
    tube = Cloth(vertices=rings, triangles=triangles, rest=flat, panel=np.zeros(20, dtype=int), panel_names=("tube",))
    assert [len(part) for part in border_sides(tube)] == [10, 10]
