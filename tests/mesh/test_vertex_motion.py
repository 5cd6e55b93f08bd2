# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A mesh that moves has the same faces in all frames."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.vertex_motion import MovingMesh

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


def square(faces: list[list[int]]) -> Mesh:
    return Mesh.from_polygons(SQUARE, faces)


@pytest.mark.parametrize(
    ("faces", "message"),
    [
        ([[0, 1, 2, 3]], "frame 1: got 4 vertices and 1 faces; expected 4 and 2, those of the first frame"),
        ([[0, 1, 3], [1, 2, 3]], r"frame 1: face 0: got vertices \[0, 1, 3\]; expected \[0, 1, 2\]"),
    ],
)
def test_a_frame_with_other_faces_is_refused(faces: list[list[int]], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        MovingMesh.of_frames([square([[0, 1, 2], [0, 2, 3]]), square(faces)], [0.0, 1.0])


def test_times_that_do_not_increase_are_refused() -> None:
    with pytest.raises(ParameterError, match="keyframe 1: got 0 s after 0 s; expected times that increase"):
        MovingMesh.of_frames([square([[0, 1, 2, 3]])] * 2, [0.0, 0.0])
