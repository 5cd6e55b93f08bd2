# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The faces of selections on small fabrics whose faces are known."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.selection import borders, parse_selection, select
from tests.editing.fabrics import around, face_at, flat, top_of

COLUMNS, ROWS = 7, 6


def grid_of(faces: np.ndarray) -> set[tuple[int, int]]:
    """Return the row and the column of faces of the flat fabric, whose faces are numbered row by row."""
    return {(int(face) // COLUMNS, int(face) % COLUMNS) for face in faces}


@pytest.fixture(scope="module")
def piece():
    fabric = flat(COLUMNS, ROWS)
    assert all(
        face_at(fabric, row, column) == row * COLUMNS + column for row in range(ROWS) for column in range(COLUMNS)
    )
    return fabric


@pytest.mark.parametrize(
    ("text", "rows"),
    [("rows 2", {2}), ("rows 1-3", {1, 2, 3}), ("rows 0- step 3", {0, 3}), ("rows 0- step 3 height 2", {0, 1, 3, 4}),
     ("rows 1, 4-5", {1, 4, 5}), ("last 2 rows", {4, 5}), ("ring 20", {2}), ("ring 20 up 3", {2, 3, 4}),
     ("ring 20 down 2", {1, 2}), ("ring 20 2", {1, 2, 3}), ("all", set(range(6)))],
)  # fmt: skip
def test_whole_rows(piece, text, rows):
    assert grid_of(select(piece, text)) == {(row, column) for row in rows for column in range(COLUMNS)}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("wale 17", {(row, 3) for row in range(6)}),
        ("wale 17 up", {(row, 3) for row in range(2, 6)}),
        ("wale 17 up 2", {(2, 3), (3, 3)}),
        ("wale 17 down", {(row, 3) for row in range(3)}),
        ("rectangle 8 3x2", {(row, column) for row in (1, 2) for column in (1, 2, 3)}),
        ("rectangle 8 to 24", {(row, column) for row in (1, 2, 3) for column in (1, 2, 3)}),
        ("rectangle 10 to 22", {(row, column) for row in (1, 2, 3) for column in (1, 2, 3)}),
        ("rectangle 22 to 10", {(row, column) for row in (1, 2, 3) for column in (1, 2, 3)}),
        ("front panel 3", {(row, column) for row in range(6) for column in (2, 3, 4)}),
        ("faces 3, 9-10", {(0, 3), (1, 2), (1, 3)}),
        ("rows 2 and wale 17", {(2, 3)}),
        ("border 0", {(r, c) for r in range(6) for c in range(7) if r in (0, 5) or c in (0, 6)}),
        ("border 0 2-", {(r, c) for r in range(1, 5) for c in range(1, 6)}),
        ("not border 0 2", {(r, c) for r in range(2, 4) for c in range(2, 5)}),
    ],
)
def test_pieces_of_rows_and_wales(piece, text, expected):
    assert grid_of(select(piece, text)) == expected


def test_a_wale_above_a_course_edge(piece):
    assert grid_of(select(piece, f"wale side {top_of(piece, 17)}")) == {(row, 3) for row in range(3, 6)}
    with pytest.raises(ParameterError, match="has no face above it"):
        select(piece, f"wale side {top_of(piece, 38)}")
    with pytest.raises(ParameterError, match="is a wale side; expected a course side"):
        select(piece, f"wale side {int(piece.right_wale[17])}")


def test_stitches_yarns_and_marks(piece):
    purl = apply_edit(piece, Edit("change_stitch", {"faces": [8, 9], "stitch": "p"})).fabric
    assert select(purl, "stitch p").tolist() == [8, 9]
    assert select(apply_edit(piece, Edit("stripe", {"yarn": 2, "faces": [5]})).fabric, "yarn 1-2").tolist() == [5]
    assert select(apply_edit(piece, Edit("twist_loop", {"side": top_of(piece, 9), "twist": 1})).fabric, "twists") == [9]
    cable = Edit("cross_cable", {"side": top_of(piece, 9), "left": 1, "right": 1, "front": "left"})
    assert select(apply_edit(piece, cable).fabric, "cables").tolist() == [9, 10]
    split = apply_edit(piece, Edit("split_course_edge", {"side": top_of(piece, 17)})).fabric
    assert len(select(split, "increases")) == len(select(split, "decreases")) == 1


def test_a_file_of_faces(piece, tmp_path):
    path = tmp_path / "faces.txt"
    path.write_text("3, 9 10  # the first ones\n\n12\n")
    assert select(piece, f'file "{path}"').tolist() == [3, 9, 10, 12]
    path.write_text("3\n4 x\n")
    with pytest.raises(FileError, match=r"faces.txt line 2: got 'x'; expected numbers of faces"):
        select(piece, f'file "{path}"')
    path.write_text("42\n")
    with pytest.raises(ParameterError, match="face 42 does not exist; the mesh has faces 0 to 41"):
        select(piece, f'file "{path}"')
    with pytest.raises(FileError, match="there is no such file"):
        select(piece, f'file "{tmp_path / "none.txt"}"')


def test_selections_combine_as_sets(piece):
    def faces(text: str) -> set[int]:
        return set(select(piece, text).tolist())

    rows, wale = faces("rows 1-3"), faces("wale 17")
    assert faces("rows 1-3 and wale 17") == rows & wale
    assert faces("rows 1-3 or wale 17") == rows | wale
    assert faces("rows 1-3 and not wale 17") == rows - wale
    assert select(piece, parse_selection("rows 1-3") & ~parse_selection("wale 17")).tolist() == sorted(rows - wale)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("rows 9", "rows 9: the fabric has no such row; its rows are 0 to 5"),
        ("rows 1 and rows 2", "selection 'rows 1 and rows 2': is empty; no face of the 42"),
        ("back", "selection 'back': is empty"),
        ("stitch p", "selection 'stitch p': is empty"),
        ("hem 3", "hem 3: the fabric has no such border; its borders are border 0"),
        ("border 1", "border 1: the fabric has no such border"),
        ("sleeves", "a sleeve is a tube of rows from a cuff to the body"),
        ("wale 42", "face 42: does not exist; the mesh has faces 0 to 41"),
        ("faces 42", "faces 42: face 42 does not exist"),
        ("rectangle 8 7x2", "the row ends 6 stitches after face 8; make it narrower"),
        ("rectangle 8 2x7", "the wales have 5 rows from face 8 upwards; make it lower"),
        ("front panel 8", "the row there has 7 stitches; make the panel narrower"),
    ],
)
def test_what_does_not_exist_is_refused_in_one_line(piece, text, message):
    with pytest.raises(ParameterError) as refused:
        select(piece, text)
    assert message in str(refused.value) and "\n" not in str(refused.value)


def test_a_tube_has_a_hem_a_neck_and_four_sides():
    tube = around(12, 5)
    assert [border.name for border in borders(tube)] == ["hem", "neck"]
    assert set(tube.row[select(tube, "hem 2")]) == {0, 1} and len(select(tube, "hem 2")) == 24
    assert set(tube.row[select(tube, "neck 2-3")]) == {2, 3}
    halves = select(tube, "front"), select(tube, "back")
    assert sorted(np.concatenate(halves)) == list(range(60)) and abs(len(halves[0]) - 30) <= 10  # 2 faces a row
    for side in ("front", "back", "left", "right"):
        assert np.isin(select(tube, f"{side} panel 2"), select(tube, side)).all()
        assert np.bincount(tube.row[select(tube, f"{side} panel 3")]).tolist() == [3] * 5


def test_a_rectangle_goes_on_around_a_tube():
    tube = around(12, 5)
    ring = select(tube, "rows 0")
    assert len(select(tube, f"rectangle {ring[-1]} 12x2")) == 24
