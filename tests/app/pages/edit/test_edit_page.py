# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Edit as a whole: history, colours, palettes, keys and hints."""

from __future__ import annotations

from stitchmesh.app.pages.edit.edit_page import TOOLS
from stitchmesh.app.scene.drawing import Colours
from stitchmesh.editing.edit import Edit
from stitchmesh.mesh.stitch import VOCABULARY
from stitchmesh.patterns.library import pattern_names
from tests.app.pages.edit.opened import same_as
from tests.app.pages.headless import headless
from tests.gallery import tube


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


def test_drags_turn_the_view_only_with_tools_that_take_none(page):
    takes = lambda: page.scene.drawings["fabric/0"].takes_strokes  # noqa: E731
    for tool in TOOLS:
        page.act("tool", tool.name)
        assert takes() == tool.takes_strokes


def test_colours_by_stitch_yarn_and_row(page):
    palettes = []
    for words in ("Stitches", "Yarns", "Rows"):
        page.controls.set("Colours", words)
        colours = page.scene.drawings["fabric/0"].colours
        assert isinstance(colours, Colours)
        palettes.append(colours.palette[colours.index].tobytes())
    assert len(set(palettes)) == 3


def test_the_palettes_offer_every_stitch_and_every_pattern(page):
    shown = "".join(control.content for control in page.front.left_controls.made)
    names = [making.code for making in VOCABULARY.values()] + ["cast-on", "draw-through"]
    assert all(f'data-action="stitch" data-value="{name}"' in shown for name in names)
    assert all(f'data-action="pattern" data-value="{name}"' in shown for name in pattern_names())
    assert shown.count("<button") == shown.count("aria-label=")


def test_every_tool_has_a_key_of_its_own(page):
    keys = [control for control in page.controls.made if control.kind == "key"]
    for tool in TOOLS:
        page.press(f"Tool: {tool.name}")
        assert page.page.tool.name == tool.name
    assert len({tool.key for tool in TOOLS}) == len(TOOLS) and len(keys) == len(TOOLS) + 4


def test_every_control_has_a_hint(page):
    made = page.controls.made + page.front.left_controls.made
    assert [control.label for control in made if control.label and control.kind != "group" and not control.hint] == []


def test_results_that_an_edit_drops_are_named(page):
    page.project.set_evened(page.fabric)
    page.act("stitch", "p")
    page.click_stitch(44)
    assert "made older results invalid: evened stitches" in page.notices()


def test_the_page_says_what_to_do_while_there_are_no_stitches(tmp_path):
    with headless(tmp_path, tube(12, 5), "Edit") as page:
        assert "divide the labeled mesh into stitches first" in page.front.navigation.text_shown()
        assert [control.label for control in page.controls.made] == ["Go to Label"]  # the faces have no rows yet


def test_the_page_opens_again_as_it_was_left(page):
    page.act("tool", "Select")
    page.click_stitch(44)
    page.app.open_page("Label")
    page.app.open_page("Edit")
    assert page.selected == [44] and page.page.tool.name == "Select"
    assert "selection/faces" in page.scene.drawings
