# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pieces of HTML are well formed, say everything in words, and let no text of a user become HTML."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

from stitchmesh.app.controls.html_pieces import LegendEntry, colour_bar, figures, legend, legend_of_key, message

HOSTILE = '<script>alert(1)</script> & "quotes"'
PIECES = {
    "legend": legend_of_key([(HOSTILE, (10, 20, 30)), ("knit", (1, 2, 3))], HOSTILE),
    "colour_bar": colour_bar([[0, 0, 0], [255, 255, 255]], [HOSTILE, "1"], HOSTILE),
    "figures": figures([(HOSTILE, HOSTILE)], HOSTILE),
    "message": message(HOSTILE, "doubtful"),
}


@pytest.mark.parametrize("name", PIECES)
def test_a_piece_is_well_formed_and_shows_texts_as_they_are(name):
    tree = ElementTree.fromstring(f"<div>{PIECES[name]}</div>")
    assert HOSTILE in "".join(tree.itertext())
    assert tree.find(".//script") is None


def test_messages_of_different_kinds_differ_without_colour():
    marks = {"".join(ElementTree.fromstring(message("", kind)).itertext()) for kind in ("good", "doubtful", "info")}
    assert len(marks) == 3


def test_each_colour_of_a_legend_has_a_mark_that_screen_readers_leave_out():
    entries = [LegendEntry("rows", ((1, 2, 3), (4, 5, 6))), LegendEntry("a < b & c", ((7, 8, 9),), line=True)]
    found = ElementTree.fromstring(legend(entries))
    assert found.get("aria-label") == "Legend"
    assert ["".join(item.itertext()) for item in found] == ["rows", "a < b & c"]
    marks = next(part for part in found[0].iter("span") if part.get("aria-hidden") == "true")
    assert ["rgb(1, 2, 3)" in str(mark.get("style")) for mark in marks] == [True, False]
    assert ["rgb(4, 5, 6)" in str(mark.get("style")) for mark in marks] == [False, True]
    assert len(ElementTree.fromstring(legend([]))) == 0
