# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Holes and parts of a mesh that are finer than its stitches, as scans have them."""

from __future__ import annotations

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import MeshError
from stitchmesh.mesh import Mesh
from stitchmesh.shaping.counts import StitchSize
from stitchmesh.shaping.finer_than_stitches import knitted_surface, with_small_holes_spanned
from tests.gallery import grid, tube
from tests.shaping.surfaces import closed_ball, in_triangles, surface_of

SIZE = StitchSize(1.2, 0.9)
BALL = closed_ball(24, 20)
"""The perimeter of its triangles, about 4 cm, is less than four stitches of 1.2 cm, and more than four of 0.4 cm."""


def without_faces(mesh: Mesh, faces: list[int]) -> Mesh:
    corners = np.delete(mesh.face_vertex.reshape(-1, 3), faces, axis=0)
    used, places = np.unique(corners, return_inverse=True)
    return Mesh.from_polygons(mesh.vertices[used], places.reshape(-1, 3).tolist())


def together(first: Mesh, second: Mesh) -> Mesh:
    faces = np.concatenate([first.face_vertex, second.face_vertex + len(first.vertices)]).reshape(-1, 3)
    away = second.vertices + np.array([50.0, 0.0, 0.0])
    return Mesh.from_polygons(np.concatenate([first.vertices, away]), faces.tolist())


SPECK = Mesh.from_polygons([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0, 1, 2]])


def test_a_hole_that_is_finer_than_a_stitch_is_spanned_with_its_area(caplog):
    damaged = without_faces(BALL, [300, 500])
    surface, notes = knitted_surface(damaged, SIZE, ())
    assert surface.borders == () and len(surface.vertices) == len(damaged.vertices) + 2
    # A triangle is filled by three in its plane: rounding of sums.
    assert surface.area.sum() == pytest.approx(surface_of(BALL).area.sum(), rel=1e-12)
    assert (surface.vector_area.sum(axis=0) ** 2).sum() < 1e-18  # All triangles of a closed surface look outwards.
    assert notes[0].startswith("2 holes of the mesh are finer than the stitches, and spanned by them; see (")
    shaped = sm.shape_fabric(damaged, stitch_width=SIZE.width, progress=False)
    assert shaped.report.lost is None and notes[0] in caplog.text


def test_holes_that_are_wider_or_marked_stay_open():
    damaged = without_faces(BALL, [300])
    corner = BALL.vertices[BALL.face_vertex.reshape(-1, 3)[300, 0]]
    assert len(knitted_surface(damaged, SIZE, (sm.TimeMark("border", [corner], "side"),))[0].borders) == 1
    assert len(knitted_surface(damaged, StitchSize(0.4, 0.3), ())[0].borders) == 1


def test_outlines_and_ends_of_tubes_are_no_holes():
    for mesh in (in_triangles(grid(2, 2, width=0.3, height=0.3)), in_triangles(tube(12, 4, radius=0.5))):
        surface = surface_of(mesh)
        spanned, centres = with_small_holes_spanned(surface, 100.0)
        assert spanned is surface and len(centres) == 0


def test_debris_is_left_out_and_the_rest_is_as_without_it(caplog):
    alone = in_triangles(tube(24, 6, radius=3.0))
    expected = sm.auto_stitches(alone, stitch_width=0.7)
    found = sm.auto_stitches(together(alone, SPECK), stitch_width=0.7)
    np.testing.assert_array_equal(found.vertices, expected.vertices)
    np.testing.assert_array_equal(found.face_vertex, expected.face_vertex)
    assert "1 part of the mesh is smaller than a few stitches, and left out; see (50, 0, 0) cm" in caplog.text


def test_a_mesh_of_debris_alone_is_refused_in_one_line():
    with pytest.raises(MeshError, match=r"^the largest connected part has room for 0\.8 stitches of 0\.9 cm") as caught:
        sm.auto_stitches(together(SPECK, SPECK), stitch_width=0.9, stitch_height=0.7)
    assert "\n" not in str(caught.value)
