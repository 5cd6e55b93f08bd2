# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which triangles a brush covers."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.app.pages.drape.cloth_brush import covered_triangles
from stitchmesh.mesh.picking import PickedPlace
from stitchmesh.mixed.cloth.panel_position import PanelPosition
from stitchmesh.mixed.cloth.panels import Panel
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
    covered = covered_triangles(CLOTH, "Circle", [place(face)], 1.2)
    near = np.flatnonzero((np.linalg.norm(CENTRE - CENTRE[face], axis=1) <= 1.2) & (CLOTH.panel == 0))
    assert np.array_equal(covered, near) and 5 < len(covered) < (CLOTH.panel == 0).sum()


def test_a_circle_smaller_than_a_triangle_covers_the_triangle():
    assert covered_triangles(CLOTH, "Circle", [place(middle_of(1))], 1e-3).tolist() == [middle_of(1)]


@pytest.mark.parametrize("brush", ["Triangle", "Circle", "Panel"])
def test_a_path_covers_what_its_places_cover(brush):
    path = [place(middle_of(0)), place(0), place(middle_of(1))]
    parts = [covered_triangles(CLOTH, brush, [one], 0.9) for one in path]
    assert np.array_equal(covered_triangles(CLOTH, brush, path, 0.9), np.unique(np.concatenate(parts)))


def test_a_panel_is_covered_whole():
    covered = covered_triangles(CLOTH, "Panel", [place(middle_of(1))], 0.0)
    assert np.array_equal(covered, np.flatnonzero(CLOTH.panel == 1))
