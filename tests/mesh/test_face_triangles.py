# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Faces divided into triangles."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import Mesh
from stitchmesh.mesh.face_triangles import face_triangles

# A quad, a triangle and a pentagon; the pentagon is not planar.
MESH = Mesh.from_polygons(
    [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0.5, 0.2), (2, 1.5, 0.4), (1, 2, 0), (0, 2, 0.3)],
    [(0, 1, 2, 3), (1, 4, 2), (3, 2, 5, 6, 7)],
)


def test_a_face_of_n_corners_has_n_minus_two_triangles_in_the_order_of_the_faces():
    assert face_triangles(MESH).face.tolist() == [0, 0, 1, 2, 2, 2]


def test_the_triangles_use_all_corners_of_their_face_and_no_other():
    found = face_triangles(MESH)
    for face in range(MESH.face_count):
        assert set(found.corners[found.face == face].ravel()) == set(MESH.sides_of(np.array([face])))


def test_the_vector_areas_of_the_triangles_add_up_to_those_of_the_faces():
    found = face_triangles(MESH)
    one, two, three = (MESH.corner_position[found.corners[:, k]] for k in range(3))
    area = np.zeros((MESH.face_count, 3))
    np.add.at(area, found.face, 0.5 * np.cross(two - one, three - one))
    np.testing.assert_allclose(area, MESH.face_vector_area, atol=1e-15)  # Sums of a few products near 1.


def test_two_quads_that_share_two_sides_form_a_mesh_of_triangles():
    """A roof over a vertex of two faces. The diagonal between the ends of the common sides is shorter in both."""
    points = [(-1, 0, 0), (0, 0, 0.4), (1, 0, 0), (0, 2.5, 0.1), (0, -2.5, 0.1)]
    mesh = Mesh.from_polygons(points, [(0, 1, 2, 3), (2, 1, 0, 4)])
    triangles = mesh.face_vertex[face_triangles(mesh).corners]
    assert Mesh.from_polygons(points, triangles.tolist()).face_count == 4
    found = {frozenset(triangle) for triangle in triangles.tolist()}
    assert found == {frozenset(three) for three in ((0, 1, 3), (1, 2, 3), (1, 2, 4), (0, 1, 4))}


def test_the_triangles_are_the_same_for_every_first_corner():
    polygons = np.split(MESH.face_vertex, MESH.face_start[1:-1])
    found = set()
    for turn in range(5):
        mesh = Mesh.from_polygons(MESH.vertices, [np.roll(polygon, turn).tolist() for polygon in polygons])
        triangles = mesh.face_vertex[face_triangles(mesh).corners]
        found.add(frozenset(frozenset(triangle) for triangle in triangles.tolist()))
    assert len(found) == 1
