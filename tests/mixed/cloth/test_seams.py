# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Panels sewn together: areas and lengths at rest, shared vertices, seams, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.mesh import BORDER
from stitchmesh.mixed.cloth.panels import Panel, PanelPosition
from stitchmesh.mixed.cloth.seams import PanelBorder, PanelSeam, cloth_from_panels
from tests.mixed.cloth.panel_shapes import OUTLINES, edge_stretch, rectangle, side_by_side, tube


def rest_lengths(cloth) -> np.ndarray:
    ends = cloth.side_rest[cloth.seam_sides]
    return np.linalg.norm(ends[..., 1, :] - ends[..., 0, :], axis=-1)


def test_sewing_keeps_areas_and_the_lengths_of_both_borders():
    cloth = side_by_side(8.0, 10.0)
    np.testing.assert_allclose(cloth.rest_area.sum(), 180.0, rtol=1e-12)
    np.testing.assert_allclose(rest_lengths(cloth).sum(axis=0), [8.0, 10.0], rtol=1e-12)
    assert len(cloth.seam_edges) == 10  # the longer border decides


def test_borders_of_equal_length_meet_without_strain():
    cloth = side_by_side(8.0, 8.0)
    np.testing.assert_allclose(edge_stretch(cloth, cloth.vertices), 1.0, rtol=1e-12)


def test_a_seam_runs_along_its_first_border_and_has_its_angle():
    cloth = side_by_side(8.0, 8.0)
    np.testing.assert_array_equal(cloth.seam_edges[1:, 0], cloth.seam_edges[:-1, 1])
    assert (cloth.panel[cloth.seam_sides // 3] == [0, 1]).all()
    angle = cloth.hinge_angle
    assert np.count_nonzero(angle) == len(cloth.seam_edges)
    np.testing.assert_allclose(angle[angle > 0], np.radians(20.0))


def test_a_tube_has_two_borders_and_no_more():
    cloth = tube(12.0, 8.0)
    assert np.count_nonzero(cloth.twin == BORDER) == 24
    euler = len(cloth.vertices) - len(cloth.hinges) - 24 + len(cloth.triangles)
    assert euler == 0
    np.testing.assert_allclose(np.hypot(cloth.vertices[:, 0], cloth.vertices[:, 2] + 6 / np.pi), 6 / np.pi, rtol=1e-12)


def test_the_outer_side_of_a_wrapped_panel_is_its_front():
    cloth = tube(12.0, 8.0)
    corners = cloth.vertices[cloth.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outwards = corners.mean(axis=1) - np.array([0.0, 0.0, -6 / np.pi])
    assert ((normal * outwards * [1, 0, 1]).sum(axis=1) > 0).all()


def test_a_whole_border_can_be_sewn_to_a_whole_border():
    disc = Panel(name="lid", outline=np.array(OUTLINES["disc"]), side_edges=(1,) * 40)
    ring = [[0, 0], [62.8, 0], [62.8, 5], [0, 5]]
    wall = Panel(name="wall", outline=ring, position=PanelPosition(radius=10.0))
    seams = [
        PanelSeam(first=PanelBorder(panel="wall", start=1, end=2), second=PanelBorder(panel="wall", start=3, end=0)),
        PanelSeam(
            first=PanelBorder(panel="lid", start=0, end=0),
            second=PanelBorder(panel="wall", start=2, end=3),
            angle=90.0,
        ),
    ]
    cloth = cloth_from_panels([disc, wall], seams, edge_length=1.5)
    assert len(cloth.seam_edges) - cloth.seam_start[1] == 40
    assert cloth.seam_edges[cloth.seam_start[1], 0] == cloth.seam_edges[-1, 1]


def test_borders_with_other_numbers_of_edges_are_refused_with_both_numbers():
    seam = PanelSeam(first=PanelBorder(panel="a", start=1, end=2), second=PanelBorder(panel="b", start=3, end=0))
    fixed = [rectangle(4.0, 6.0, "a", side_edges=(4, 6, 4, 6)), rectangle(4.0, 6.0, "b", side_edges=(4, 9, 4, 9))]
    with pytest.raises(ParameterError, match=r"seam 0 .*'a', corners 1 to 2; .* got 6 and 9 edges; expected the same"):
        cloth_from_panels(fixed, [seam], edge_length=1.0)
    with pytest.raises(ParameterError, match="got 6 and 7 edges"):
        cloth_from_panels([fixed[0], rectangle(4.0, 6.0, "b")], [replace(seam, edges=7)], edge_length=1.0)


A, B = PanelBorder(panel="a", start=1, end=2), PanelBorder(panel="b", start=3, end=0)
REFUSED = {
    "there is no panel 'c'; the panels are a, b": [PanelSeam(first=A, second=replace(B, panel="c"))],
    "got end 4; expected a corner from 0 to 3": [PanelSeam(first=replace(A, end=4), second=B)],
    "side 1 is in seam 0 too": [PanelSeam(first=A, second=B), PanelSeam(first=A, second=replace(B, start=0, end=1))],
    "got 1 edges; expected at least 2": [PanelSeam(first=replace(A, end=3), second=B, edges=1)],
    "joins two corners of one triangle": [PanelSeam(first=A, second=replace(A, start=2, end=3), edges=1)],
}


@pytest.mark.parametrize("message", REFUSED)
def test_seams_that_are_refused(message):
    with pytest.raises(StitchMeshError, match=message) as caught:
        cloth_from_panels([rectangle(4.0, 4.0, "a"), rectangle(4.0, 4.0, "b")], REFUSED[message], edge_length=4.0)
    assert "\n" not in str(caught.value)


def test_numbers_of_seams_and_names_of_panels_that_are_refused():
    with pytest.raises(ParameterError, match="seam: angle"):
        PanelSeam(first=A, second=B, angle=np.nan)
    with pytest.raises(ParameterError, match="occurs twice"):
        cloth_from_panels([rectangle(1.0, 1.0), rectangle(1.0, 1.0)], [], edge_length=1.0)
    with pytest.raises(ParameterError, match="got none"):
        cloth_from_panels([], [], edge_length=1.0)


POSITIONS = {
    "origin: got": {"origin": (0.0, np.inf, 0.0)},
    "y_axis: got a zero vector": {"y_axis": (0.0, 0.0, 0.0)},
    "got an angle of 45 degrees; expected 90": {"y_axis": (1.0, 1.0, 0.0)},
    "radius: got 0": {"radius": 0.0},
}


@pytest.mark.parametrize("message", POSITIONS)
def test_positions_that_are_refused(message):
    with pytest.raises(ParameterError, match=message):
        PanelPosition(**POSITIONS[message])


def test_positions_keep_lengths():
    position = PanelPosition(origin=(1, 2, 3), x_axis=(1, 1, 0), y_axis=(0, 0, 2), radius=3.0)
    line = np.stack([np.linspace(0, 6, 20001), np.linspace(0, 2, 20001)], axis=1)
    length = np.linalg.norm(np.diff(position.place(line), axis=0), axis=1).sum()
    np.testing.assert_allclose(length, np.hypot(6, 2), rtol=1e-8)  # chords of 20,000 parts
