# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Edit as a whole: history, colours, palettes, keys and hints."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.pages.edit.edit_page import TOOLS
from stitchmesh.app.scene.drawing import Colours
from stitchmesh.app.scene.scene import Stroke
from stitchmesh.editing.edit import Edit
from stitchmesh.mesh.stitch import VOCABULARY
from stitchmesh.patterns.library import pattern_names
from tests.app.pages.edit.opened import same_as


def test_undo_and_redo_by_buttons_and_keys(page):
    page.act("stitch", "p")
    page.click_stitch(44)
    page.click_stitch(55)
    page.act("undo")
    assert same_as(page, Edit("change_stitch", {"faces": [44], "stitch": "p"}))
    page.press("Undo")
    assert same_as(page)
    page.press("Redo")
    page.act("redo")
    both = [Edit("change_stitch", {"faces": [face], "stitch": "p"}) for face in (44, 55)]
    assert same_as(page, *both)
    assert "disabled" in page.controls.made[0].content  # There is nothing left to redo.


def test_a_click_says_what_the_stitch_is(page):
    page.act("tool", "Look around")
    page.click_stitch(44)
    assert "Stitch 44: <b>k</b>, row 4, loops 1 below, 1 above, yarn 0" in page.controls.text_shown()
    assert "Stitches with these loops: k, p, sl1 wyib, sl1 wyif, w1" in page.controls.text_shown()


def test_colours_by_stitch_yarn_and_row(page):
    palettes = []
    for words in ("Stitches", "Yarns", "Rows"):
        page.controls.set("Colours", words)
        colours = page.scene.drawings["fabric/0"].colours
        assert isinstance(colours, Colours)
        palettes.append(colours.palette[colours.index].tobytes())
    assert len(set(palettes)) == 3


def test_the_palettes_offer_every_stitch_with_its_abbreviation_and_every_pattern(page):
    shown = "".join(control.content for control in page.front.left_controls.made)
    names = [making.code for making in VOCABULARY.values()] + ["cast-on", "draw-through"]
    assert all(f'data-action="stitch" data-value="{name}"' in shown for name in names)
    assert all(f'data-action="pattern" data-value="{name}"' in shown for name in pattern_names())
    assert shown.count("<button") == shown.count("aria-label=")
    # The abbreviations are those of the written instructions; edits keep the codes.
    for word, code in {"k2tog": "d12k", "ssk": "d21k", "yo": "y", "sssk": "d321k"}.items():
        assert f'data-value="{code}" aria-label="{word}: ' in shown


def test_the_numbers_of_rows_stand_on_the_fabric(page):
    assert "rows/numbers" not in page.scene.drawings
    page.controls.set("Row numbers", True)
    numbers = page.scene.drawings["rows/numbers"]
    assert numbers.texts == ("0", "5", "10")  # of 12 rows
    heights = page.fabric.vertices[:, 1].min() + 0.72 * (np.array([0, 5, 10]) + 0.5)
    np.testing.assert_allclose(numbers.points[:, 1], heights, atol=1e-9)  # sums of few doubles
    page.controls.set("Row numbers", False)
    assert "rows/numbers" not in page.scene.drawings


def test_every_tool_has_a_key_of_its_own_and_drags_turn_the_view_with_tools_that_take_none(page):
    keys = [control for control in page.controls.made if control.kind == "key"]
    for tool in TOOLS:
        page.press(f"Tool: {tool.name}")
        assert page.page.tool.name == tool.name
        assert page.scene.drawings["fabric/0"].takes_strokes == tool.takes_strokes  # else a drag turns the view
    assert len({tool.key for tool in TOOLS}) == len(TOOLS) and len(keys) == len(TOOLS) + 4


def test_results_that_an_edit_drops_are_named(page):
    page.project.set_evened(page.fabric)
    page.act("stitch", "p")
    page.click_stitch(44)
    assert "made older results invalid: evened stitches" in page.notices()


def test_a_message_that_no_button_sends_is_refused(page):
    for action, value, reason in (
        ("tool", "Hammer", "tool: got 'Hammer'; expected one of Paint stitches"),
        ("stitch", "zz", "stitch 'zz': is unknown; expected one of k, p"),
        ("yarn", "one", "yarn: got 'one'; expected the number of a yarn"),
        ("yarn", "999999", "expected 0 to 255"),
        ("pattern", "/etc/passwd", "is not in the library; choose one of the palette"),
    ):
        made = page.front.controls.made + page.front.left_controls.made
        control = next(control for control in made if f'data-action="{action}"' in control.content)
        page.run(lambda: control.changed(action, value))  # noqa: B023
        assert reason in page.notices() and page.project.edits == ()


def test_the_page_reads_no_files_by_name(page, tmp_path):
    (tmp_path / "faces.txt").write_text("1 2 3")
    page.controls.set("Select by words", f'rows 1 or file "{tmp_path / "faces.txt"}"')
    page.press("Select these")
    assert "the application reads no files by name" in page.notices() and page.selected == []


def test_an_undo_in_the_middle_of_a_drag_ends_the_drag(page):
    page.act("tool", "Rows and wales")
    page.click_stitch(44)
    page.act("stitch", "p")
    last = page.fabric.face_count - 1
    towards = np.array([0.0, 0.0, -1.0])
    origin = page.fabric.corner_position[page.fabric.sides_of(np.array([last]))].mean(axis=0) - 50.0 * towards
    page.page.stroked(Stroke(origin, towards, "", 3, "start"))
    page.act("undo")
    page.page.stroked(Stroke(origin, towards, "", 4, "move"))  # Of another browser, which has begun no drag.
    page.page.stroked(Stroke(np.array([90.0, 90.0, 9.0]), towards, "", 3, "end"))
    assert same_as(page) and page.front.notices == []
