# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patterns are shown before they are laid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.app.pages.swatch.state import first_state, state_table
from stitchmesh.editing.edit import Edit
from stitchmesh.mesh.palette import colours_of
from stitchmesh.patterns import apply_pattern, parse_pattern, read_pattern
from stitchmesh.patterns.moved import mirrored_pattern, shifted_pattern
from stitchmesh.selection import select
from tests.app.pages.edit.opened import WIDE, OpenedEdit, edit_page, same_as
from tests.editing.fabrics import around, flat
from tests.editing.random_edits import bits


def test_a_pattern_is_shown_before_it_is_laid(page):
    page.controls.set("Select by words", "rows 2-9")
    page.press("Select these")
    page.act("tool", "Lay a pattern")
    page.act("pattern", "eyelet-lace")
    faces = select(WIDE, "rows 2-9")
    wanted = apply_pattern(WIDE, "eyelet-lace", faces=faces)
    assert "Preview of Eyelet lace" in page.controls.text_shown()
    assert bits(page.page.tools["Lay a pattern"].laid.fabric) == bits(wanted)
    assert same_as(page) and len(page.scene.drawings["fabric/0"].triangles) > 2 * WIDE.face_count - 1
    page.press("Lay the pattern")
    assert bits(page.fabric) == bits(wanted)
    assert page.project.edits == (
        Edit("paste_pattern", {"pattern": "eyelet-lace", "on": "rows 2-9", "remainder": "centre"}),
    )


def shown_colours(page: OpenedEdit) -> list[int]:
    """The colours of the first block of the fabric, one after another."""
    colours = page.scene.drawings["fabric/0"].colours
    return colours.palette[colours.index].ravel().tolist()


def test_a_preview_is_discarded_and_shows_the_colours_of_several_yarns(page):
    before = shown_colours(page)
    page.act("tool", "Lay a pattern")
    page.act("pattern", "rib2x2")
    page.controls.set("Where", "Whole fabric")
    assert shown_colours(page) != before
    page.press("Discard the preview")
    assert shown_colours(page) == before and same_as(page)
    page.act("pattern", "garter")
    assert shown_colours(page) != before
    page.act("tool", "Select")
    assert shown_colours(page) == before and same_as(page)
    page.act("tool", "Lay a pattern")
    page.act("pattern", "checks")
    assert page.controls.find("Colours").value == "Yarns" and len(set(shown_colours(page))) > 6


def test_a_pattern_goes_around_a_click_or_over_the_whole_fabric(page):
    page.act("tool", "Lay a pattern")
    page.act("pattern", "rib1x1")
    page.click_stitch(44)
    page.press("Lay the pattern")
    page.controls.set("Where", "Whole fabric")
    page.controls.set("Stitches left over", "stretch the pattern")
    page.act("pattern", "rope-cable")
    page.press("Lay the pattern")
    first = Edit("paste_pattern", {"pattern": "rib1x1", "face": 44, "remainder": "centre"})
    assert same_as(page, first, Edit("paste_pattern", {"pattern": "rope-cable", "remainder": "stretch"}))


def test_patterns_of_files_stay_in_the_lists_of_the_project(page):
    page.act("tool", "Lay a pattern")
    for name in ("Own", "Second", "Own"):
        text = f'pattern "{name}"\nsource "me"\nrow 1 RS: k1 p1\nrow 2 WS: k1 p1\n'.encode()
        page.run(lambda: page.controls.send("Pattern from a file", "own.knit", text))  # noqa: B023
    left = page.front.left_controls
    assert left.text_shown().count("own 1: Own") and left.text_shown().count("own 2: Second")
    assert "own 3" not in left.text_shown()
    page.app.open_page("Swatch")
    left.set("Start from", "own 2: Second")
    assert 'pattern "Second"' in page.project.settings("Swatch")["charts"][0]
    page.run(lambda: left.send("Open a chart", "third.knit", text.replace(b"Own", b"Third")))
    assert "own 3: Third" in left.find("Start from").options
    page.app.open_page("Edit")
    page.act("tool", "Lay a pattern")
    page.controls.set("Where", "Whole fabric")
    page.act("pattern", "own 3: Third")
    page.press("Lay the pattern")
    assert page.project.edits[-1].arguments["pattern"].startswith('pattern "Third"\n')


def test_a_broken_file_of_a_pattern_is_refused(page):
    page.act("tool", "Lay a pattern")
    for number, (name, content) in enumerate([("a.knit", b"row 1: ?"), ("b.png", b"no picture"), ("c.txt", b"")], 1):
        page.run(lambda: page.controls.send("Pattern from a file", name, content))  # noqa: B023
        assert len(page.front.notices) == number and page.front.notices[-1][2] == "error" and same_as(page)


def test_stitches_that_a_pattern_leaves_out_are_marked_and_described(tmp_path):
    with edit_page(tmp_path, flat(8, 9)) as page:
        page.act("tool", "Lay a pattern")
        page.act("pattern", "rib3x3")
        page.controls.set("Where", "Whole fabric")
        assert "left over beside whole repeats" in page.controls.text_shown()
        assert "left out/faces" in page.scene.drawings


def test_the_ground_is_chosen_and_rounds_of_whole_repeats_are_proposed(tmp_path):
    text = b'colours "navy, cream"\nchart colours:\n0111\n'
    with edit_page(tmp_path, around(9, 5)) as page:
        page.act("tool", "Lay a pattern")
        page.controls.set("Where", "Whole fabric")
        page.run(lambda: page.controls.send("Pattern from a file", "chart.knit", text))
        assert "Rounds of a multiple of 4 stitches leave none over" in page.controls.text_shown()
        page.controls.set("Ground", "navy")
        page.press("Lay the pattern")
        assert page.project.edits[-1].arguments["ground"] == "navy"
        assert colours_of(page.fabric.yarn, page.fabric.palette)[:9].tolist() == [[0, 0, 128]] * 9  # the cast-on row


def test_a_pattern_is_moved_mirrored_and_centred_on_the_front_before_it_is_laid(tmp_path):
    with edit_page(tmp_path, around(14, 5)) as page:
        page.act("tool", "Lay a pattern")
        page.controls.set("Where", "Whole fabric")
        page.act("pattern", "left-diagonal-rib")
        page.press("Move the pattern", "Mirror")
        page.press("Move the pattern", "Up")
        page.controls.set("In the middle of the front", True)
        page.press("Lay the pattern")
        wanted = shifted_pattern(mirrored_pattern(read_pattern("left-diagonal-rib")), 0, 1)
        assert page.project.edits[-1].arguments["centre"] is True
        assert bits(page.fabric) == bits(apply_pattern(around(14, 5), wanted, centre=True))


def test_the_list_is_searched_and_has_repeats_families_and_own_swatches(tmp_path):
    state = first_state()
    with edit_page(tmp_path, flat(8, 9)) as page:
        own = parse_pattern('pattern "Mine"\nrow 1 RS: k p\nrow 2 WS: k p\n')
        design = replace(state.design, pattern=own)
        page.project.set_settings("Swatch", state_table(state.with_design(design)))
        page.app.open_page("Edit")
        page.act("tool", "Lay a pattern")
        left = page.front.left_controls
        assert "Your own" in left.text_shown() and "Cables" in left.text_shown()
        assert "6 x 4" in left.text_shown()
        left.set("Search", "rope")
        assert "rope cable" in left.text_shown() and "Lace" not in left.text_shown()
        left.set("Search", "mine")
        page.controls.set("Where", "Whole fabric")
        page.act("pattern", "swatch 1: Mine")
        page.press("Lay the pattern")
        assert bits(page.fabric) == bits(apply_pattern(flat(8, 9), own))


def test_the_selection_is_captured_saved_and_laid_elsewhere(page):
    page.act("tool", "Lay a pattern")
    page.press("Capture the selection")
    assert "nothing is selected" in page.front.notices[-1][1]
    page.page.session.edit("change_stitch", {"faces": [22, 33], "stitch": "p"})
    page.page.session.choose(np.array([22, 23, 32, 33]))
    page.press("Capture the selection")
    page.press("Save the pattern", "Text")
    name, content = page.front.downloads[-1]
    assert name == "pattern.knit" and parse_pattern(content.decode()).rows == read_pattern("seed").rows
    page.page.session.choose(np.array([22, 23, 33]))
    page.press("Capture the selection")
    assert "expected a rectangle of wales and courses" in page.front.notices[-1][1]
    page.controls.set("Where", "Whole fabric")
    page.press("Lay the pattern")
    assert bits(page.fabric) == bits(apply_pattern(page.fabric, "seed"))
