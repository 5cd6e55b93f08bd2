# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the pointer is over."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.app.pages.edit.tool import nearest_side
from stitchmesh.app.scene.pointer import DragPath, Pointer
from stitchmesh.app.scene.scene import Pick, Stroke
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, TOP
from stitchmesh.mesh.picking import PickedPlace
from tests.app.pages.edit.opened import WIDE

DOWN = np.array([0.0, 0.0, -1.0])


def place_of(face: int, up: float, right: float) -> PickedPlace:
    """The place of a face above and to the right of its middle, in half sizes of the face."""
    corners = WIDE.corner_position[WIDE.sides_of(np.array([face]))]
    point = corners.mean(axis=0) + 0.5 * np.ptp(corners, axis=0) * [right, up, 0.0]
    found = Pointer(WIDE).place(Pick(point - 9.0 * DOWN, DOWN))
    assert found is not None and found.face == face
    return found


@pytest.mark.parametrize(
    ("up", "right", "kind", "number"),
    [
        (0.8, 0.1, "course side", 2),
        (-0.8, 0.1, "course side", 0),
        (0.3, 0.9, "wale side", 1),
        (0.1, -0.4, "wale side", 3),
    ],
)
def test_the_nearest_side_of_a_kind_is_found(up, right, kind, number):
    assert nearest_side(WIDE, place_of(44, up, right), kind) == WIDE.face_start[44] + number


def test_the_nearest_loop_is_that_above_or_that_of_the_stitch_below():
    above, below = (nearest_side(WIDE, place_of(44, up, 0.0), "top side") for up in (0.5, -0.5))
    assert WIDE.role_of(above) == WIDE.role_of(below) == TOP
    assert (WIDE.side_face[above], WIDE.side_face[below]) == (44, 34)


def test_a_stitch_inside_the_fabric_has_no_border():
    with pytest.raises(ParameterError, match="face 44: has no border side; click another stitch"):
        nearest_side(WIDE, place_of(44, 0.0, 0.0), "border side")
    assert WIDE.twin[nearest_side(WIDE, place_of(40, 0.0, -0.5), "border side")] == BORDER


def test_a_fast_drag_passes_every_stitch_between_two_reports():
    pointer, drag = Pointer(WIDE), DragPath()
    eye = np.array([5.0, 4.0, 60.0])
    for face, phase in ((3, "start"), (41, "start"), (48, "move"), (88, "end")):  # a start forgets the drag before
        target = WIDE.corner_position[WIDE.sides_of(np.array([face]))].mean(axis=0)
        found = drag.follow(Stroke(eye, target - eye, phase=phase), pointer)
    assert [place.face for place in found] == [*range(41, 49), 58, 68, 78, 88]


def test_a_ray_beside_the_fabric_has_no_place():
    assert Pointer(WIDE).place(Pick(np.array([50.0, 0.0, 9.0]), DOWN)) is None
