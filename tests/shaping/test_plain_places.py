# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Marks from which increases and decreases are kept away."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import cKDTree

import stitchmesh as sm
from stitchmesh.errors import ParameterError
from stitchmesh.shaping.plain_places import plain_places
from stitchmesh.shaping.report import irregular_faces
from stitchmesh.shaping.triangle_surface import triangle_surface
from tests.gallery import ROOT, tube
from tests.shaping.surfaces import in_triangles

WIDTH = 1.0
FRONT = [[0.0, 0.0, 10.137], [0.0, 11.8, 10.214], [0.0, 20.3, 1.722]]
"""Points up the front of the hat [cm]."""


@pytest.fixture(scope="module")
def hat() -> sm.Mesh:
    return in_triangles(sm.read_mesh(ROOT / "assets" / "meshes" / "hat.obj"))


def places_of_shaping(fabric: sm.StitchMesh) -> np.ndarray:
    """Centres of the increases and decreases [cm]."""
    faces = np.flatnonzero(irregular_faces(fabric))
    corner = fabric.corner_position
    return np.array([corner[fabric.side_face == face].mean(axis=0) for face in faces])


def line_through(points: list[list[float]]) -> np.ndarray:
    """Points along a polyline, closer than a tenth of a stitch."""
    return np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(points)])


@pytest.mark.decides
def test_increases_and_decreases_keep_away_from_a_plain_stroke(hat):
    free = sm.auto_stitches(hat, stitch_width=WIDTH)
    front = sm.TimeMark("stroke", FRONT, "plain", radius=3.0)
    plain = sm.auto_stitches(hat, stitch_width=WIDTH, options=sm.ShapingOptions(marks=[front]))
    away = [cKDTree(line_through(FRONT)).query(places_of_shaping(fabric))[0].min() for fabric in (free, plain)]
    # The middle of a stitch whose vertices are all outside may lie half a stitch inside.
    assert away[0] < 1.0 and away[1] > 3.0 - 0.5 * WIDTH


def test_rounds_that_are_plain_all_around_keep_their_stitches(hat):
    crown = sm.TimeMark("point", [[0.0, 20.7, 0.0]], "plain", radius=8.0)
    fabric = sm.auto_stitches(hat, stitch_width=WIDTH, options=sm.ShapingOptions(marks=[crown]))
    assert np.linalg.norm(places_of_shaping(fabric) - [0.0, 20.7, 0.0], axis=1).min() > 6.0


def test_a_plain_place_does_not_reach_through_a_thin_fabric():
    """Two walls of a flat tube are 0.4 cm apart, and the way around its edge is 10 cm."""
    mesh = tube(40, 6, radius=5.0)
    flat = mesh.vertices * [1.0, 1.0, 0.04]
    surface = triangle_surface(in_triangles(sm.Mesh.from_polygons(flat, mesh.face_vertex.reshape(-1, 4).tolist())), 0.5)
    plain = plain_places(surface, [sm.TimeMark("point", [[0.0, 3.0, 0.2]], "plain", radius=2.0)], 0.5)
    held = plain.hold(surface.vertices)
    front = surface.vertices[:, 2] > 0.01
    near = np.linalg.norm(surface.vertices - [0.0, 3.0, 0.2], axis=1) < 1.9
    assert held[front & near].all() and not held[~front].any()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"role": "plain", "radius": 0.0}, "expected a positive number of centimetres"),
        ({"role": "plain", "radius": np.nan}, "expected a positive number of centimetres"),
        ({"role": "begin", "radius": 1.0}, "only the role plain has one"),
        ({"role": "plain", "time": 1.0}, "only begin, end and row have one"),
    ],
)
def test_plain_marks_that_make_no_sense_are_refused(arguments, words):
    with pytest.raises(ParameterError, match=words):
        sm.TimeMark("point", [[0.0, 0.0, 0.0]], **arguments)
