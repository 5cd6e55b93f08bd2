# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Lines of equal value lie where the function has the values, and cross each triangle that they pass once."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.pages.rows.rows_view import contour_segments
from stitchmesh.mesh.face_triangles import face_triangles
from tests.gallery import grid


def test_lines_of_a_linear_function_are_straight_and_as_long_as_the_piece_is_wide():
    mesh = grid(5, 4)  # one unit for each face
    points, triangles = mesh.vertices, mesh.face_vertex[face_triangles(mesh).corners]
    low = points[:, 1].min()
    segments = contour_segments(points, triangles, points[:, 1] - low, 0.3)
    height = segments[:, :, 1] - low
    assert np.allclose(height, 0.3 * np.rint(height / 0.3), atol=1e-6)
    length = np.linalg.norm(np.diff(segments, axis=1), axis=2)[:, 0]
    level = np.rint(height[:, 0] / 0.3).astype(int)
    inner = np.bincount(level, length)[1:13]  # The lines at 0.3 to 3.6; the piece is 4 high.
    assert np.allclose(inner, 5.0, atol=1e-6)
    assert contour_segments(points, triangles, np.full(len(points), 0.55), 1.0).shape == (0, 2, 3)
