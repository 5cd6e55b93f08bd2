# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A legend is a list with one item for each mark, which can be read without its colours."""

from __future__ import annotations

from xml.etree import ElementTree

from stitchmesh.app.controls.legend import LegendEntry, legend


def test_a_legend_has_an_item_with_its_text_for_each_entry():
    entries = [LegendEntry("rows", ((1, 2, 3), (4, 5, 6))), LegendEntry("a < b & c", ((7, 8, 9),), line=True)]
    found = ElementTree.fromstring(legend(entries))
    assert found.get("aria-label") == "Legend"
    assert ["".join(item.itertext()) for item in found] == ["rows", "a < b & c"]


def test_each_colour_has_a_mark_that_screen_readers_leave_out():
    found = ElementTree.fromstring(legend([LegendEntry("rows", ((1, 2, 3), (4, 5, 6)))]))
    (marks,) = [part for part in found.iter("span") if part.get("aria-hidden") == "true"]
    assert ["rgb(1, 2, 3)" in str(mark.get("style")) for mark in marks] == [True, False]
    assert ["rgb(4, 5, 6)" in str(mark.get("style")) for mark in marks] == [False, True]


def test_a_legend_without_entries_is_empty():
    assert len(ElementTree.fromstring(legend([]))) == 0
