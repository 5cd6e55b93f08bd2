# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits of whole rows and columns: insert, remove, reverse; and bobbles."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit, apply_changes, apply_edit
from stitchmesh.errors import MeshError, ParameterError
from stitchmesh.labeling import label
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.tessellate import tessellate
from stitchmesh.yarngen import generate_yarns
from tests.editing.fabrics import around, face_at, flat, names, top_of
from tests.editing.random_edits import bits
from tests.gallery import torus

pytestmark = pytest.mark.decides


def edited(fabric: StitchMesh, name: str, **arguments: object) -> StitchMesh:
    return apply_edit(fabric, Edit(name, arguments)).fabric


def new_faces(before: StitchMesh, after: StitchMesh) -> np.ndarray:
    return np.arange(before.face_count, after.face_count)


@pytest.mark.parametrize("make", [flat, around])
def test_a_row_that_is_inserted_can_be_removed_again(make):
    fabric = make()
    for row in range(fabric.row.max() + 1):
        face = int(np.flatnonzero(fabric.row == row)[0])
        more = edited(fabric, "insert_row", face=face)
        width = int((fabric.row == row).sum())
        assert np.bincount(more.row).tolist() == [width] * (fabric.row.max() + 2)
        assert (more.row[new_faces(fabric, more)] == row + 1).all()
        assert bits(edited(more, "remove_row", face=fabric.face_count)) == bits(fabric)


def test_a_row_inserted_above_an_increase_has_a_stitch_on_each_loop():
    fabric = flat()
    face = face_at(fabric, 2, 3)
    wide = edited(fabric, "split_course_edge", side=top_of(fabric, face))
    more = edited(wide, "insert_row", face=face, stitch="p")
    assert names(more, *new_faces(wide, more)) == [Stitch.PURL] * 8
    assert names(more, face, face_at(fabric, 3, 3)) == [Stitch.KY, Stitch.D12K]


def test_the_loops_below_an_inserted_row_keep_their_cables():
    fabric = flat()
    side = top_of(fabric, face_at(fabric, 2, 1))
    crossed = edited(fabric, "cross_cable", side=side, left=2, right=1, front="left")
    more = edited(crossed, "insert_row", face=face_at(fabric, 2, 0))
    marked = np.flatnonzero(more.cable_shift)
    assert sorted(more.cable_shift[marked]) == [-2, 1, 1] and (more.row[more.side_face[marked]] == 2).all()
    assert bits(edited(more, "remove_row", face=fabric.face_count)) == bits(crossed)


@pytest.mark.parametrize(("make", "column"), [(flat, 0), (flat, 2), (around, 2)])
def test_a_column_from_border_to_border_can_be_removed_again(make, column):
    """The copies of a vertex lie symmetrically about it, a third of the distance to its neighbours."""
    fabric = make()
    side = int(fabric.left_wale[face_at(fabric, 1, column)])
    more = edited(fabric, "insert_wale", side=side)
    rows = int(fabric.row.max()) + 1
    assert more.face_count == fabric.face_count + rows and len(more.vertices) == len(fabric.vertices) + rows + 1
    assert len(more.boundary_loops) == len(fabric.boundary_loops)
    assert names(more, *new_faces(fabric, more)) == [Stitch.CAST_ON, *[Stitch.KNIT] * (rows - 1)]
    again = edited(more, "remove_wale", face=fabric.face_count)
    np.testing.assert_array_equal(again.twin, fabric.twin)
    np.testing.assert_array_equal(again.stitch, fabric.stitch)
    if make is flat and column == 2:
        np.testing.assert_allclose(again.corner_position, fabric.corner_position, atol=1e-14)  # thirds, rounded


def test_a_column_inside_the_fabric_begins_with_an_increase_and_ends_with_a_decrease():
    fabric = flat()
    right = [face_at(fabric, row, 3) for row in range(6)]
    more = edited(fabric, "insert_wale", side=int(fabric.left_wale[right[2]]), courses=2)
    assert names(more, *right) == [Stitch.CAST_ON, Stitch.KY, Stitch.KNIT, Stitch.KNIT, Stitch.D12K, Stitch.KNIT]
    assert names(more, *new_faces(fabric, more)) == [Stitch.KNIT] * 2
    assert generate_yarns(more).yarn_count == 1
    again = edited(more, "remove_wale", face=fabric.face_count)
    np.testing.assert_array_equal(again.twin, fabric.twin)
    np.testing.assert_array_equal(again.stitch, fabric.stitch)


def test_a_column_ends_where_a_decrease_ends_its_wale():
    fabric = flat()
    low, high = face_at(fabric, 2, 3), face_at(fabric, 3, 3)
    wide = edited(edited(fabric, "insert_row", face=low), "insert_wale",
                  side=int(fabric.left_wale[low]), courses=1)  # fmt: skip
    column = wide.face_count - 1
    assert Stitch.D12K in names(wide, *range(wide.face_count))
    longer = edited(wide, "insert_wale", side=int(wide.right_wale[column]))
    assert Stitch.D213K in names(longer, *range(longer.face_count)) and high < longer.face_count


@pytest.mark.parametrize("courses", [None, 36])
def test_a_column_is_closed_if_its_wale_is_closed(courses):
    fabric = tessellate(label(torus(8, 12), seeds=[(0, 1)]), stitch_width=0.8)
    rows = int(fabric.row.max()) + 1
    assert rows == 36
    more = edited(fabric, "insert_wale", side=int(fabric.left_wale[5]), courses=courses)
    assert more.face_count == fabric.face_count + rows and (more.stitch == Stitch.KNIT).all()
    fewer = edited(fabric, "remove_wale", face=5, courses=courses)
    assert fewer.face_count == fabric.face_count - rows and (fewer.stitch == Stitch.KNIT).all()


def test_a_row_that_is_reversed_twice_is_unchanged():
    fabric = around()
    face = face_at(fabric, 2, 3)
    turned = edited(fabric, "flip_row", face=face)
    sides = np.flatnonzero(turned.mismatched)
    assert len(sides) == 4 * (fabric.row == 2).sum()  # both sides of the edges below and above
    assert bits(edited(turned, "flip_row", face=face)) == bits(fabric)


def test_two_reversed_rows_change_places_in_the_numbering():
    """One reversed row has no seams that match. With its neighbour reversed too, the upper row comes first."""
    fabric = around()
    lower, upper = face_at(fabric, 2, 3), face_at(fabric, 3, 3)
    one = edited(fabric, "flip_row", face=lower)
    assert (one.row == fabric.row).all()
    two = edited(one, "flip_row", face=upper)
    assert (two.row == np.array([0, 1, 3, 2, 4, 5, *range(6, 99)])[fabric.row]).all()
    back = edited(edited(two, "flip_row", face=lower), "flip_row", face=upper)
    assert bits(back) == bits(fabric)


def test_an_increase_in_a_reversed_row_is_a_decrease():
    fabric = flat()
    face = face_at(fabric, 2, 3)
    wide = edited(fabric, "split_course_edge", side=top_of(fabric, face), stitch_below="py")
    assert names(edited(wide, "flip_row", face=face), face) == [Stitch.D12P]


def test_a_reversed_first_row_is_bound_off_and_a_reversed_last_row_is_cast_on():
    fabric = flat()
    first, last = face_at(fabric, 0, 0), face_at(fabric, 5, 0)
    assert names(edited(fabric, "flip_row", face=first), first) == [Stitch.KNIT]
    assert names(edited(fabric, "flip_row", face=last), last) == [Stitch.CAST_ON]
    generate_yarns(edited(edited(fabric, "flip_row", face=first), "flip_row", face=last))


def test_a_flat_piece_with_a_bobble_still_has_one_yarn():
    fabric = flat()
    face = face_at(fabric, 2, 3)
    knobbed = edited(fabric, "bobble", face=face)
    assert names(knobbed, face, *new_faces(fabric, knobbed)) == [Stitch.KYK, *[Stitch.PURL] * 3, Stitch.D213K]
    assert sorted(len(loop) for loop in knobbed.boundary_loops) == [2, 2, 26]
    yarns = generate_yarns(knobbed)
    assert yarns.yarn_count == 1 and not yarns.closed[0]


def test_spirals_and_grafts_are_edits_with_an_exact_inverse():
    fabric = around()
    side = top_of(fabric, face_at(fabric, 2, 3))
    cut, spiral = edited(fabric, "ungraft", side=side), edited(fabric, "spiral")
    joining = Edit("graft", {"first_side": side, "second_side": int(fabric.twin[side])})
    for start, edit in ((fabric, Edit("spiral")), (fabric, Edit("ungraft", {"side": side})), (cut, joining)):
        made = apply_edit(start, edit)
        assert bits(apply_changes(made.fabric, made.inverse).fabric) == bits(start) != bits(made.fabric)
    for there, back in ((cut, joining), (spiral, Edit("unspiral"))):
        np.testing.assert_array_equal(apply_edit(there, back).fabric.twin, fabric.twin)
    turned = edited(spiral, "flip_row", face=7)
    assert (turned.row == spiral.row.max() - spiral.row).all()
    assert bits(edited(turned, "flip_row", face=7)) == bits(spiral)
    with pytest.raises(ParameterError, match="its row climbs from row 0 to row 4; turn the spiral back first"):
        edited(spiral, "insert_row", face=0)


REFUSED = {
    "first row": ("remove_row", {"face": 0}, "face 0: lies on the border; the first row carries all others"),
    "row gone": ("flip_row", {"face": -1}, "face -1: does not exist"),
    "row of increases": ("insert_row", {"face": 0, "stitch": "ky"}, "stitch ky: does not make one loop on one"),
    "too long": ("insert_wale", {"side": 101, "courses": 9}, "courses: got 9; the line has 3 from side 101"),
    "column too long": ("remove_wale", {"face": 24, "courses": 9}, "courses: got 9; the column runs over 3 from"),
    "nothing to take": ("remove_wale", {"face": 24, "courses": 1}, "would have 1 bottom and 0 top sides; no stitch"),
    "border": ("bobble", {"face": 7}, "face 7: touches the border in vertex"),
    "no loop below": ("bobble", {"face": 0}, "face 0: does not work one loop to one loop"),
}


@pytest.mark.parametrize(("name", "arguments", "message"), REFUSED.values(), ids=REFUSED)
def test_the_message_of_a_refused_edit_gives_the_reason(name, arguments, message):
    with pytest.raises(ParameterError, match=message):
        edited(flat(), name, **arguments)


def test_the_only_column_cannot_be_removed():
    with pytest.raises(ParameterError, match="face 0: is all of its row; without it the fabric would fall apart"):
        edited(flat(columns=1, rows=3), "remove_wale", face=1)


def test_a_row_with_an_increase_cannot_be_removed():
    fabric = flat()
    face = face_at(fabric, 2, 3)
    wide = edited(fabric, "split_course_edge", side=top_of(fabric, face))
    with pytest.raises(ParameterError, match=f"face {face}: does not make one loop of one"):
        edited(wide, "remove_row", face=face)
    assert wide.twin[wide.face_start[0]] == BORDER


def test_a_column_of_a_tube_of_two_columns_cannot_be_removed():
    fabric = edited(around(columns=3, rows=2), "remove_wale", face=0)
    with pytest.raises(MeshError, match="would touch itself in a vertex; there is no space for this edit"):
        edited(fabric, "remove_wale", face=0)
