# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits of course edges and wale edges; the opposite edit restores the mesh to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.editing.fitting import fitting_stitch
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.courses import top_sides
from stitchmesh.mesh.stitch import CODES, Stitch
from stitchmesh.yarngen import generate_yarns
from tests.editing.fabrics import around, face_at, flat, names, top_of
from tests.editing.random_edits import bits

pytestmark = pytest.mark.decides


def edited(fabric: StitchMesh, name: str, **arguments: object) -> StitchMesh:
    return apply_edit(fabric, Edit(name, arguments)).fabric


def widened(fabric: StitchMesh, face: int) -> StitchMesh:
    """Return the fabric with an increase in a face and a decrease above that face."""
    return edited(fabric, "split_course_edge", side=top_of(fabric, face))


@pytest.mark.parametrize("make", [flat, around])
def test_every_course_edge_can_be_split_and_collapsed_again(make):
    fabric = make()
    for side in np.flatnonzero(~fabric.is_wale).tolist():
        face, role = int(fabric.side_face[side]), fabric.side_role[side]
        split = edited(fabric, "split_course_edge", side=side)
        new = top_of(split, face, 1) if role == 2 else int(split.face_start[face])
        assert bits(edited(split, "collapse_course_edge", side=new)) == bits(fabric)


def test_at_a_border_only_one_face_changes():
    fabric = flat()
    for side in np.flatnonzero(~fabric.is_wale & (fabric.twin == BORDER)).tolist():
        split = edited(fabric, "split_course_edge", side=side)
        assert np.flatnonzero(np.diff(split.face_start) != 4).tolist() == [fabric.side_face[side]]
        cast_on = fabric.side_role[side] == 0
        assert names(split, fabric.side_face[side]) == [Stitch.CAST_ON if cast_on else Stitch.KY]
    # No wale ends in the new border vertex, so the bind-off uses the wales of the adjacent faces.
    assert generate_yarns(split, quality="draft").yarn_count == 1


def test_arguments_give_the_new_stitches():
    fabric = flat()
    low, high = face_at(fabric, 2, 3), face_at(fabric, 3, 3)
    side = top_of(fabric, low)
    split = edited(fabric, "split_course_edge", side=side, stitch_below="kp", stitch_above="d21p")
    assert names(split, low, high) == [Stitch.KP, Stitch.D21P]
    with pytest.raises(ParameterError, match=f"face {low}: .* in 1 st needs 1 and 3"):
        edited(fabric, "split_course_edge", side=side, stitch_below="kyk")


@pytest.mark.parametrize(
    ("code", "sides", "then"),
    [("p", (1, 2), "py"), ("p", (2, 1), "d12p"), ("d12k", (3, 1), "d213k"), ("kp", (1, 3), "kpk"), ("yk", (1, 1), "k"),
     ("d321p", (2, 1), "d21p"), ("b", (1, 2), "ky"), ("k", (0, 1), "y"), ("sk", (1, 3), "yky")],
)  # fmt: skip
def test_the_new_stitch_is_as_similar_as_possible_to_the_old_one(code, sides, then):
    assert fitting_stitch(CODES[code], *sides) == CODES[then]
    assert fitting_stitch(CODES[code], 2, 2) is None


@pytest.mark.parametrize(("stitch", "turns"), [(None, [0, 1]), ("ky", [0, 0]), ("kp", [0, 0])])
def test_an_increase_that_an_edit_chooses_is_closed_and_one_that_is_named_is_not(stitch, turns):
    fabric = flat()
    low = face_at(fabric, 2, 3)
    split = edited(fabric, "split_course_edge", side=top_of(fabric, low), stitch_below=stitch)
    assert split.twist[top_sides(split, (low,))].tolist() == turns


def test_an_increase_is_divided_into_a_stitch_and_a_yarn_over_and_joined_again():
    fabric = flat()
    face = face_at(fabric, 2, 3)
    wide = edited(widened(fabric, face), "change_stitch", faces=[face], stitch="yk")
    parts = edited(wide, "add_wale_edge", face=face, below=0, above=1)
    assert names(parts, face, wide.face_count) == [Stitch.YARN_OVER, Stitch.KNIT]
    assert parts.twin[parts.right_wale[face]] == parts.left_wale[wide.face_count]
    assert bits(edited(parts, "remove_wale_edge", side=int(parts.right_wale[face]))) == bits(wide)


def test_a_shifted_wale_edge_gives_one_loop_to_the_neighbour():
    fabric = flat()
    left, right = face_at(fabric, 2, 3), face_at(fabric, 2, 4)
    wide = widened(fabric, left)
    side = int(wide.right_wale[left])
    shifted = edited(wide, "shift_wale_edge", side=side, end="top", direction="left")
    assert names(shifted, left, right) == [Stitch.KNIT, Stitch.KY]
    np.testing.assert_array_equal(shifted.vertices, wide.vertices)
    side = int(shifted.right_wale[left])
    assert bits(edited(shifted, "shift_wale_edge", side=side, end="top", direction="right")) == bits(wide)


def test_twists_stay_with_their_loops():
    fabric = flat()
    low, side = face_at(fabric, 2, 3), top_of(flat(), face_at(flat(), 2, 3))
    twisted = edited(fabric, "twist_loop", side=side, twist=1)
    split = edited(twisted, "split_course_edge", side=side)
    assert [split.twist[top_of(split, low, loop)] for loop in (0, 1)] == [1, 1]


REFUSED = {
    "negative": ("collapse_course_edge", {"side": -1}, "side -1: does not exist"),
    "wale side": ("split_course_edge", {"side": 1}, "is a right wale side; expected a course side"),
    "course side": ("shift_wale_edge", {"side": 0, "end": "top", "direction": "left"}, "is a bottom side; expected a"),
    "last loop": ("collapse_course_edge", {"side": 100}, "would have 1 bottom and 0 top sides; no stitch has these"),
    "two of two": ("remove_wale_edge", {"side": 101}, "would have 2 bottom and 2 top sides; no stitch has these"),
    "border": ("remove_wale_edge", {"side": 3}, "lies on the border; expected a wale edge between two faces"),
    "nothing to divide": ("add_wale_edge", {"face": 10, "below": 2, "above": 0}, "below: got 2; face 10 has 1 such"),
    "no such face": ("add_wale_edge", {"face": 42, "below": 0, "above": 0}, "face 42: does not exist; .* 0 to 41"),
    "no such end": ("shift_wale_edge", {"side": 101, "end": "up", "direction": "left"}, "end: got 'up'; expected top"),
}  # fmt: skip


@pytest.mark.parametrize(("name", "arguments", "message"), REFUSED.values(), ids=REFUSED)
def test_the_message_of_a_refused_edit_gives_the_reason(name, arguments, message):
    with pytest.raises(ParameterError, match=message):
        edited(flat(), name, **arguments)
