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
