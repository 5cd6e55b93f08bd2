# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The starting shape of sewn panels: strain is spread, nothing moves without strain, momentum stays."""

from __future__ import annotations

import numpy as np

from stitchmesh.mixed.cloth.panels import PanelPosition
from stitchmesh.mixed.cloth.seams import PanelBorder, PanelSeam, cloth_from_panels
from stitchmesh.mixed.cloth.starting_shape import evened_vertices
from tests.mixed.cloth.panel_shapes import edge_stretch, rectangle, side_by_side


def test_a_cloth_without_strain_stays_where_it_is():
    cloth = side_by_side(8.0, 8.0)
    np.testing.assert_allclose(evened_vertices(cloth, rounds=50), cloth.vertices, atol=1e-12)  # rounding of 50 rounds


def test_panels_that_are_apart_come_together():
    panels = [
        rectangle(10.0, 10.0, "front", position=PanelPosition(origin=(0.0, 0.0, 6.0))),
        rectangle(10.0, 10.0, "back", position=PanelPosition(origin=(10.0, 0.0, 0.0), x_axis=(-1.0, 0.0, 0.0))),
    ]
    seams = [
        PanelSeam(first=PanelBorder(panel="front", start=1, end=2), second=PanelBorder(panel="back", start=3, end=0)),
        PanelSeam(first=PanelBorder(panel="back", start=1, end=2), second=PanelBorder(panel="front", start=3, end=0)),
    ]
    cloth = cloth_from_panels(panels, seams, edge_length=1.0)
    assert np.abs(edge_stretch(cloth, cloth.vertices) - 1.0).max() > 1.5
    vertices = evened_vertices(cloth, rounds=300)
    assert np.abs(edge_stretch(cloth, vertices) - 1.0).max() < 0.15
    assert vertices[:, 2].max() - vertices[:, 2].min() > 3.0  # a tube, not a flat pair
