# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A sewn cloth that cuts a body at the start is put round it with little strain."""

from __future__ import annotations

import numpy as np

from stitchmesh.mixed.cloth.panel_position import PanelPosition
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.cloth.seams import PanelBorder, PanelSeam, cloth_from_panels
from stitchmesh.mixed.contact.body import SolidBody
from stitchmesh.mixed.contact.dressing import WornBody, dressed_vertices
from tests.mixed.contact.bodies import ball
from tests.mixed.contact.sheets import cpu

SQUARE = [[-3.3, 0.0], [3.3, 0.0], [3.3, 4.0], [-3.3, 4.0]]


def band():
    """A band 13.2 cm round, of two flat panels that lie 1 cm apart."""
    panels = [
        Panel(name="front", outline=SQUARE, position=PanelPosition(origin=(0.0, -2.0, 0.5))),
        Panel(name="back", outline=SQUARE, position=PanelPosition(origin=(0.0, -2.0, -0.5), x_axis=(-1.0, 0.0, 0.0))),
    ]
    seams = [
        PanelSeam(first=PanelBorder(panel="front", start=1, end=2), second=PanelBorder(panel="back", start=3, end=0)),
        PanelSeam(first=PanelBorder(panel="back", start=1, end=2), second=PanelBorder(panel="front", start=3, end=0)),
    ]
    return cloth_from_panels(panels, seams, edge_length=0.8)


def largest_stretch(cloth, vertices) -> float:
    corners = vertices[cloth.triangles]
    length = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    at_rest = np.linalg.norm(np.roll(cloth.rest, -1, axis=1) - cloth.rest, axis=2)
    return float((length / at_rest).max())


def test_a_band_goes_round_a_ball_that_it_cuts():
    """A ball of radius 2 is 12.6 cm round, 5 % less than the band, and 1.5 cm of it stick out of each panel."""
    cloth, body = band(), SolidBody(ball(2.0, 3))
    dressed = dressed_vertices(cloth, cloth.vertices, [WornBody(body, 0.05)], thickness=0.1, device=cpu())
    distance = np.linalg.norm(dressed, axis=1)
    assert distance.min() > 2.0
    assert largest_stretch(cloth, dressed) < 1.1  # without the rounds some edges are stretched by half and more


def test_a_cloth_outside_stays_where_it_is():
    cloth = band()
    body = SolidBody(ball(0.2, 2))
    dressed = dressed_vertices(cloth, cloth.vertices, [WornBody(body, 0.05)], thickness=0.1, device=cpu())
    assert dressed is cloth.vertices
