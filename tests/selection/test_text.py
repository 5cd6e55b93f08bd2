# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The language of selections: what each text means, the written form also of given faces, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.patterns.swatch_mesh import plain_piece
from stitchmesh.selection import parse_selection, select
from stitchmesh.selection.selection import (
    AtBorder,
    Both,
    Either,
    Everything,
    GarmentPart,
    RowRange,
    Span,
    Stitches,
    Wale,
    Without,
    selection_of_faces,
)
from tests.hand_knitting.stitch_charts import chart_fabric

TEXTS = [
    "all", "rows 3", "rows 10-20 step 4", "rows 10- step 8 height 3", "rows 1, 3, 5-9", "last 3 rows",
    "hem", "hem 6", "hem 3-8", "cuffs 7- step 8 height 4", "left cuff 6", "right armhole 4", "neck", "tips 2",
    "border 0", "border 2 6", "border 2 3-5", "front", "back", "left", "right", "sleeves", "left sleeve", "body",
    "front panel 20", "left panel 6", "stitch k", "stitch d12k", "increases", "cast-on", "yarn 1", "faces 3, 7-9",
    'file "my faces.txt"', "wale 300", "wale 300 up 12", "wale 300 down", "wale side 40 up", "ring 120",
    "ring 120 up 6", "rectangle 120 20x30", "rectangle 120 to 455", "not hem", "front and not (hem 6 or neck 3)",
    "hem or front and back", "(hem or front) and back", "not (hem and front)", "hem and (front and back)",
]  # fmt: skip


@pytest.mark.parametrize("text", TEXTS)
def test_the_text_of_a_selection_is_the_text_that_was_parsed(text):
    assert str(parse_selection(text)) == text


@pytest.mark.parametrize(
    ("text", "same"),
    [("row 3", "rows 3"), ("HEM 6", "hem 6"), ("hem 1-6", "hem 6"), ("cuff 2", "cuffs 2"), ("rows 1,2", "rows 1, 2"),
     ("((hem))", "hem"), ("rectangle 1 2 x 3", "rectangle 1 2x3"), ("wales 4", "wale 4"), ("rows 3-3", "rows 3")],
)  # fmt: skip
def test_other_forms_of_the_same_selection(text, same):
    assert parse_selection(text) == parse_selection(same)


def test_abbreviations_and_codes_name_the_same_stitches():
    fabric = chart_fabric(["co co co co co co", "d12k k d21k k", "k k k k"])
    assert select(fabric, "stitch k2tog").tolist() == select(fabric, "stitch d12k").tolist() == [6]
    assert select(fabric, "stitch k2tog or stitch ssk").tolist() == [6, 8]


def test_and_binds_more_than_or_and_not_more_than_both():
    hem, front, back = AtBorder("hem"), GarmentPart("front"), GarmentPart("back")
    assert parse_selection("hem or front and not back") == Either(hem, Both(front, Without(back)))
    assert parse_selection("hem or front or back") == Either(Either(hem, front), back)
    assert hem | front & ~back == Either(hem, Both(front, Without(back)))


def test_parsed_selections_are_values():
    assert parse_selection("rows 10-20 step 4") == RowRange((Span(10, 20, 4),))
    assert parse_selection("hem 6") == AtBorder("hem", (Span(1, 6),))
    assert parse_selection("stitch p") == Stitches("p")
    assert parse_selection("wale 7 up") == Wale(7, "up")
    assert len({parse_selection("all"), Everything()}) == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty; expected a selection"),
        ("hmm 6", "'hmm' is unknown; did you mean 'hem'?"),
        ("left cuf", "got 'cuf' after 'left'; did you mean 'cuff'"),
        ("hem 6 neck", "got 'neck' after 'hem 6'; expected 'and', 'or' or the end"),
        ("hem 0", "counted from 1"),
        ("hem and", "ends too early"),
        ("(hem", "a parenthesis is not closed"),
        ("rows", "got 'the end'; expected a number"),
        ("rows 20-10", "got 20-10; expected numbers from low to high"),
        ("rows 1- step 2 height 3", "a height from 1 to the step"),
        ("rows 1- step 0", "expected a step"),
        ("stitch zz", "'zz' is unknown"),
        ("stitch d312", "did you mean 'd312[kp]'?"),
        ("rectangle 5 20", "expected 'x'"),
        ("front panel", "the width of the panel"),
        ("last 3", "expected 'rows'"),
        ("file /faces.txt", "cannot be read from '/faces.txt'; put the name of the file in quotation marks"),
        ("hem $", "cannot be read from '\\$'"),
        ("rows 99999999999", "expected a number"),
    ],
)
def test_a_text_that_is_no_selection_is_refused_in_one_line(text, message):
    with pytest.raises(ParameterError, match=message) as refused:
        parse_selection(text)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "reason"),
    [("not " * 3000 + "hem", "more than 100 parts"), ("(" * 3000 + "hem", "more than 100 parts"),
     ("hem" + " or hem" * 3000, "more than 100 parts"), ("rows " + "9" * 5000, "a whole number from 0"),
     ("x" * 5000, "expected one of all")],
)  # fmt: skip
def test_long_and_nested_texts_are_one_short_line(text, reason):
    with pytest.raises(ParameterError, match=reason) as refused:
        parse_selection(text)
    assert len(str(refused.value)) < 2000 and "\n" not in str(refused.value)
    assert parse_selection("hem" + " or hem" * 99)


def test_the_selection_of_faces_selects_these_faces():
    fabric = plain_piece(6, 5, 1.0, 0.7)
    faces = np.random.default_rng(0).permutation(fabric.face_count)[:13]
    selection = selection_of_faces(faces)
    assert select(fabric, selection).tolist() == select(fabric, str(selection)).tolist() == sorted(faces.tolist())


def test_neighbouring_numbers_become_spans_and_no_faces_are_no_selection():
    assert str(selection_of_faces([12, 4, 5, 6, 3, 7, 5])) == "faces 3-7, 12"
    with pytest.raises(ParameterError, match="selection of faces: got none; expected at least one"):
        selection_of_faces([])
