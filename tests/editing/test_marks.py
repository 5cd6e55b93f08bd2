# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits that change only marks: stitches, twists, yarns, cables, and patterns of plain stitches."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.editing.history import read_log, write_log
from stitchmesh.editing.marks import faces_for_stitch
from stitchmesh.errors import LabelError, MeshError, ParameterError
from stitchmesh.labeling import label
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.palette import STOCK
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import apply_pattern, read_pattern
from tests.editing.fabrics import around, face_at, flat, names, top_of
from tests.editing.random_edits import bits
from tests.gallery import grid

pytestmark = pytest.mark.decides


def edited(fabric: StitchMesh, name: str, **arguments: object) -> StitchMesh:
    return apply_edit(fabric, Edit(name, arguments)).fabric


def test_only_the_given_faces_change_their_stitch():
    fabric = flat()
    changed = edited(fabric, "change_stitch", faces=[10, 12, 10], stitch="p")
    assert np.flatnonzero(changed.stitch != fabric.stitch).tolist() == [10, 12]
    assert names(changed, 10, 12) == [Stitch.PURL] * 2
    assert bits(edited(changed, "change_stitch", faces=[10, 12], stitch="k")) == bits(fabric)


def test_a_loop_is_twisted_and_untwisted():
    fabric = flat()
    side = top_of(fabric, 10)
    twisted = edited(fabric, "twist_loop", side=side, twist=-1)
    assert twisted.twist[side] == -1 and np.count_nonzero(twisted.twist) == 1
    assert bits(edited(twisted, "twist_loop", side=side, twist=0)) == bits(fabric)


def test_stripes_are_rows_and_single_faces():
    fabric = flat()
    striped = edited(fabric, "stripe", yarn=2, rows=[1, 3], faces=[0])
    assert (striped.yarn == np.where(np.isin(fabric.row, [1, 3]) | (np.arange(42) == 0), 2, 0)).all()


def test_stripes_repeat_upwards_and_bring_their_colours():
    """The seven wales of the fabric have six rows, from 0; yarn 0 keeps its stock colour."""
    fabric = flat()
    striped = edited(fabric, "stripes", bands="2 navy, 1 0")
    assert striped.yarn.reshape(6, 7)[:, 0].tolist() == [1, 1, 0, 1, 1, 0]
    assert striped.palette.tolist() == [STOCK[0].tolist(), [0, 0, 128]]
    part = edited(striped, "stripes", bands="1 navy, 1 cream", on="rows 3-5")
    assert part.yarn.reshape(6, 7)[:, 6].tolist() == [1, 1, 0, 1, 0, 1]  # the stock colour of yarn 0 is cream


@pytest.mark.parametrize("kind", [set, np.array])
def test_faces_are_any_collection_of_numbers(kind, tmp_path):
    """An edit with an array of faces is the edit with their list, in memory and in a log."""
    fabric = flat()
    faces = np.flatnonzero(fabric.row == 2)
    edit = Edit("stripe", {"yarn": np.int64(2), "faces": kind(faces.tolist())})
    assert edit == Edit("stripe", {"yarn": 2, "faces": faces.tolist()})
    assert bits(apply_edit(fabric, edit).fabric) == bits(edited(fabric, "stripe", yarn=2, rows=[2]))
    write_log(tmp_path / "log.jsonl", [edit])
    assert read_log(tmp_path / "log.jsonl") == [edit]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"faces": np.arange(3) / 2, "yarn": 1}, "stripe: faces[0] is 0.0; expected a whole number"),
        ({"faces": np.ones(3, dtype=bool), "yarn": 1}, "stripe: faces[0] is true; expected a whole number"),
        ({"faces": np.array(3), "yarn": 1}, "stripe: faces is 3; expected a list or null"),
    ],
)
def test_faces_that_are_no_numbers_are_refused_in_one_line(arguments, message):
    with pytest.raises(ParameterError) as caught:
        apply_edit(flat(), Edit("stripe", arguments))
    assert str(caught.value) == message


def test_arguments_have_names():
    for arguments in ([3, 4], None, {1: 2}):
        with pytest.raises(ParameterError, match=r"^edit 'stripe': got .*; expected arguments by name, such as \{"):
            Edit("stripe", arguments)


@pytest.mark.parametrize(("front", "layers"), [("left", [1, 1, 0]), ("right", [0, 0, 1])])
def test_a_cable_is_crossed_and_cleared(front, layers):
    fabric = flat()
    side = top_of(fabric, face_at(fabric, 2, 1))
    crossed = edited(fabric, "cross_cable", side=side, left=2, right=1, front=front)
    (group,) = cable_groups(crossed)
    assert group.sides[0] == side and group.destination.tolist() == [1, 2, 0] and group.layer.tolist() == layers
    named = edited(fabric, "set_cable", side=side, destinations=[1, 2, 0], layers=layers)
    assert bits(named) == bits(crossed)
    assert bits(edited(crossed, "clear_cable", side=int(group.sides[2]))) == bits(fabric)


def test_a_cable_can_cross_the_seam_of_a_tube():
    fabric = around()
    for face in np.flatnonzero(fabric.row == 2).tolist():
        crossed = edited(fabric, "cross_cable", side=top_of(fabric, face), left=2, right=2, front="left")
        assert sorted(crossed.cable_shift[np.flatnonzero(crossed.cable_shift)]) == [-2, -2, 2, 2]


def test_edits_that_would_cut_a_cable_are_refused():
    fabric = flat()
    side = top_of(fabric, face_at(fabric, 2, 2))
    crossed = edited(fabric, "set_cable", side=side, destinations=[2, 1, 0], layers=[2, 1, 0])
    middle = top_of(fabric, face_at(fabric, 2, 3))
    assert crossed.cable_shift[middle] == 0
    with pytest.raises(LabelError, match="cable_shift"):
        edited(crossed, "split_course_edge", side=middle)
    with pytest.raises(ParameterError, match="its loop is part of a cable; clear the cable first"):
        edited(crossed, "split_course_edge", side=side)
    with pytest.raises(ParameterError, match="its loop is part of another cable; clear it first"):
        edited(crossed, "cross_cable", side=middle, left=1, right=1, front="left")
    with pytest.raises(LabelError, match="the row above has the opposite wale direction"):
        edited(crossed, "flip_row", face=face_at(fabric, 3, 0))
    with pytest.raises(LabelError, match=r"crosses the loop from .* in the same cable_layer 0"):
        edited(fabric, "set_cable", side=side, destinations=[1, 0], layers=[0, 0])


def test_pasting_a_pattern_equals_applying_it():
    fabric = flat(columns=12, rows=12)
    face = face_at(fabric, 5, 5)
    pasted = edited(fabric, "paste_pattern", pattern="eyelet-lace", face=face)
    assert bits(pasted) == bits(apply_pattern(fabric, read_pattern("eyelet-lace"), face=face)) != bits(fabric)


REFUSED = {
    "face gone": ("change_stitch", {"faces": [3, 42], "stitch": "p"}, "face 42: does not exist"),
    "no such stitch": ("change_stitch", {"faces": [3], "stitch": "z"}, "stitch 'z': is unknown; expected one of k, p"),
    "other counts": ("change_stitch", {"faces": [10], "stitch": "d12k"}, "face 10: k2tog needs 2 and 1; the face has"),
    "border": ("change_stitch", {"faces": [0], "stitch": "k"}, "face 0: lies on the border with 1 of its 1 bottom"),
    "cast on loops": ("change_stitch", {"faces": [10], "stitch": "cast-on"}, "face 10: cast-on has loops on top and"),
    "ends nowhere": ("change_stitch", {"faces": [10], "stitch": "draw-through"}, "face 10: a drawn-through stitch has"),
    "bottom": ("twist_loop", {"side": 40, "twist": 1}, "is a bottom side; expected a top side"),
    "two turns": ("twist_loop", {"side": 42, "twist": 2}, "twist 2; expected -1, 0 or 1"),
    "no row": ("stripe", {"yarn": 1, "rows": [6]}, "row 6: does not exist; the mesh has rows 0 to 5"),
    "no yarn": ("stripe", {"yarn": -1, "rows": [1]}, "yarn: got -1; yarns are numbered from 0"),
    "no rows": ("stripes", {"bands": "navy"}, "stripes: got 'navy'; expected 1 to 10000 rows and a colour, such as"),
    "nothing striped": ("stripe", {"yarn": 1}, "faces: got none; expected at least one"),
    "too wide": ("cross_cable", {"side": 42, "left": 4, "right": 4, "front": "left"}, "a cable of 8 loops does not"),
    "no front": ("cross_cable", {"side": 42, "left": 1, "right": 1, "front": "up"}, "front: got 'up'; expected left"),
    "no loops": ("cross_cable", {"side": 42, "left": 0, "right": 1, "front": "left"}, "got 0 loops on the left and 1"),
    "no permutation": ("set_cable", {"side": 42, "destinations": [0, 0], "layers": [0, 1]}, "expected the places 0 to"),
    "few layers": ("set_cable", {"side": 42, "destinations": [1, 0], "layers": [0]}, "layers: got 1 for 2 loops"),
    "no cable": ("clear_cable", {"side": 42}, "its loop is not part of a cable"),
    "how": ("paste_pattern", {"pattern": "garter", "remainder": "cut"}, "remainder 'cut': is unknown"),
}


@pytest.mark.parametrize(("name", "arguments", "message"), REFUSED.values(), ids=REFUSED)
def test_the_message_of_a_refused_edit_gives_the_reason(name, arguments, message):
    with pytest.raises(ParameterError, match=message):
        edited(flat(), name, **arguments)


def test_edits_of_panels_are_refused():
    with pytest.raises(MeshError, match=r"edit: the mesh has panels \(face 0\); expected a tessellated mesh"):
        edited(label(grid(2, 2)), "flip_row", face=0)


@pytest.mark.parametrize("stitch", ["p", "ky", "d12k", "y", "cast-on", "draw-through"])
def test_the_faces_for_a_stitch_are_those_that_change_stitch_accepts(stitch):
    fabric = apply_pattern(flat(8, 9), read_pattern("eyelet-lace"))
    accepted = []
    for face in range(fabric.face_count):
        try:
            edited(fabric, "change_stitch", faces=[face], stitch=stitch)
            accepted.append(face)
        except (ParameterError, LabelError):
            continue
    assert faces_for_stitch(fabric, np.arange(fabric.face_count), stitch).tolist() == accepted
