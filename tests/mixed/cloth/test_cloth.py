# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a cloth refuses, and the sign of its angles."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import StitchMeshError
from stitchmesh.mixed.cloth.cloth import Cloth

POINTS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])


def square(**changes) -> Cloth:
    fields = {
        "vertices": np.column_stack([POINTS, np.zeros(4)]), "triangles": TRIANGLES, "rest": POINTS[TRIANGLES],
        "panel": [0, 0], "panel_names": ("front",), "seam_edges": [[0, 2]], "seam_start": [0, 1], "seam_angle": [0.5],
    }  # fmt: skip
    return Cloth(**{**fields, **changes})


def test_a_square():
    cloth = square()
    np.testing.assert_array_equal(cloth.hinges, [[2, 0, 1, 3]])
    np.testing.assert_array_equal(cloth.hinge_angle, [0.5])
    np.testing.assert_array_equal(cloth.seam_sides, [[3, 2]])
    np.testing.assert_array_equal(cloth.border_sides, range(6))
    assert repr(cloth) == "Cloth(2 triangles, 4 vertices, 1 panels, 1 seams, 1.0 x 1.0 x 0.0 cm)"


def test_a_ridge_has_a_positive_angle():
    cloth = square(vertices=[[0, 0, 0], [1, 0, -1], [1, 1, 0], [0, 1, -1]])
    start, end, left, right = cloth.vertices[cloth.hinges[0]]
    first, second = np.cross(end - start, left - start), np.cross(right - start, end - start)
    assert first[2] > 0 and second[2] > 0  # both normals point up, to the outside, and the edge is the highest line
    assert (end - start) @ np.cross(first, second) > 0


REFUSED = {
    r"vertices: got shape \(4, 2\)": {"vertices": POINTS},
    "vertex 1: got vertices that are not finite": {"vertices": [[0, 0, 0], [np.nan, 0, 0], [1, 1, 0], [0, 1, 0]]},
    r"triangle 1 \(panel 'front'\): has no area": {"rest": np.stack([POINTS[[0, 1, 2]], POINTS[[0, 2, 2]]])},
    "got its corners clockwise at rest": {"rest": POINTS[TRIANGLES] * [-1, 1]},
    "got panel 1; expected 0 to 0": {"panel": [0, 1]},
    "both faces pass it in the same direction": {"triangles": [[0, 1, 2], [0, 3, 2]]},
    "vertex 4: no triangle uses it": {"vertices": np.zeros((5, 3))},
    "seam edge 0-1: no two triangles meet there": {"seam_edges": [[0, 1]]},
    "got a vertex that does not exist": {"seam_edges": [[0, 9]]},
    "seam_start: expected 0 to 1": {"seam_start": [0, 2]},
    "do not meet": {"seam_edges": [[0, 2], [0, 2]], "seam_start": [0, 2]},
    "an edge occurs twice": {"seam_edges": [[0, 2], [2, 0]], "seam_start": [0, 2]},
    "has no edges": {"seam_start": [0, 1, 1], "seam_angle": [0.0, 0.0]},
    "seam_angle: got numbers that are not finite": {"seam_angle": [np.nan]},
}


@pytest.mark.parametrize("message", REFUSED)
def test_what_is_refused(message):
    with pytest.raises(StitchMeshError, match=message) as caught:
        square(**REFUSED[message])
    assert "\n" not in str(caught.value)
