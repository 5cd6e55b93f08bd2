# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Edit without a browser: each click, drag and button makes the edit that Python makes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.app.pages.edit.edit_page import TOOLS
from stitchmesh.app.scene.camera_view import CameraView
from stitchmesh.app.scene.drawing import Colours, Labels, Surface
from stitchmesh.app.scene.scene import ScreenBox, Stroke
from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.mesh import BORDER, BOTTOM, TOP, StitchMesh
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.patterns import apply_pattern
from stitchmesh.patterns.library import pattern_names
from stitchmesh.selection import select
from tests.app.pages.edit.opened import OpenedEdit, edit_page
from tests.app.pages.headless import headless
from tests.editing.fabrics import around, flat, top_of
from tests.editing.random_edits import bits
from tests.gallery import tube

WIDE = flat(10, 12)


@pytest.fixture
def page(tmp_path: Path) -> Iterator[OpenedEdit]:
    """The page Edit on a flat piece of 10 x 12 knit stitches; faces are numbered row * 10 + column."""
    with edit_page(tmp_path, WIDE) as opened:
        yield opened


def same_as(page: OpenedEdit, *edits: Edit, start: StitchMesh = WIDE) -> bool:
    """Whether the fabric of the page is that of the edits."""
    for edit in edits:
        start = apply_edit(start, edit).fabric
    return bits(page.fabric) == bits(start)


def test_a_click_paints_the_stitch_that_was_chosen(page):
    page.act("stitch", "p")
    page.click_stitch(44)
    assert same_as(page, Edit("change_stitch", {"faces": [44], "stitch": "p"}))
    assert page.front.notices == []


def test_a_drag_paints_all_stitches_on_its_line_as_one_edit(page):
    page.act("stitch", "p")
    page.drag([41, 44])
    assert same_as(page, Edit("change_stitch", {"faces": [41, 42, 43, 44], "stitch": "p"}))
    assert len(page.project.edits) == 1


@pytest.mark.parametrize(
    ("brush", "path", "words"),
    [("Row", [44], "ring 44"), ("Wale", [44, 45], "wale 44 or wale 45"), ("Rectangle", [32, 65], "rectangle 32 4x4")],
)
def test_brushes_cover_rows_wales_and_rectangles(page, brush, path, words):
    """Cast-on stitches keep their stitch, because a purl needs loops below."""
    page.act("stitch", "p")
    page.controls.set("Brush", brush)
    page.drag(path)
    faces = select(WIDE, f"({words}) and not cast-on")
    assert same_as(page, Edit("change_stitch", {"faces": faces.tolist(), "stitch": "p"}))


def test_the_stitches_under_a_drag_are_shown_before_it_ends(page):
    def colour(face: int) -> list[int]:
        colours = page.scene.drawings["fabric/0"].colours
        return colours.palette[colours.index[2 * face]].tolist()  # Each face of this fabric has two triangles.

    page.act("stitch", "p")
    before = colour(44)
    origin = WIDE.corner_position[WIDE.sides_of(np.array([44]))].mean(axis=0) + np.array([0.0, 0.0, 50.0])
    page.page.stroked(Stroke(origin, np.array([0.0, 0.0, -1.0]), "", 0, "start"))
    assert colour(44) != before and page.project.edits == ()
    page.page.stroked(Stroke(origin, np.array([0.0, 0.0, -1.0]), "", 0, "end"))
    assert len(page.project.edits) == 1


def test_a_stitch_that_does_not_fit_is_refused_where_it_was_tried(page):
    page.act("stitch", "d12k")
    page.click_stitch(44)
    assert page.project.edits == ()
    assert "face 44: d12k needs 2 and 1; the face has 1 bottom and 1 top sides" in page.notices()
    marked, reason = page.scene.drawings["refused/faces"], page.scene.drawings["refused/reason"]
    assert isinstance(marked, Surface) and len(marked.triangles) == 2
    assert isinstance(reason, Labels) and "d12k needs 2 and 1" in reason.texts[0]
    page.click((100.0, 100.0, 0.0))
    assert "refused/faces" not in page.scene.drawings


def test_a_click_on_one_corner_says_how_to_paint_a_rectangle(page):
    page.controls.set("Brush", "Rectangle")
    page.click_stitch(44)
    assert "rectangle: got one click; drag from one corner of the rectangle to the opposite one" in page.notices()


def test_yarns_are_painted_and_recoloured(page):
    page.act("tool", "Paint yarns")
    page.act("yarn", "2")
    page.drag([40, 49])
    page.front.left_controls.set("Colour of the yarn", "navy")
    page.run(lambda: page.front.left_controls.press("Set the colour"))
    stripe = Edit("stripe", {"faces": list(range(40, 50)), "yarn": 2})
    assert same_as(page, stripe, Edit("recolour", {"yarn": 2, "colour": "navy"}))
    shown = page.scene.drawings["fabric/0"].colours
    assert shown.palette[shown.index[2 * 44]].tolist() == [0, 0, 128]


def test_a_colour_that_is_none_is_refused(page):
    page.act("tool", "Paint yarns")
    page.front.left_controls.set("Colour of the yarn", "nafy")
    page.run(lambda: page.front.left_controls.press("Set the colour"))
    assert "did you mean 'navy'?" in page.notices() and page.project.edits == ()


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


def test_selections_by_click_drag_words_and_rectangle(page):
    page.act("tool", "Select")
    page.click_stitch(44)
    assert page.selected == [44]
    page.click_stitch(45, "ctrl")
    assert page.selected == [44, 45]
    page.click_stitch(44, "ctrl")
    assert page.selected == [45]
    page.drag([61, 63], "ctrl")
    assert page.selected == [45, 61, 62, 63]
    page.controls.set("Select by words", "rows 2-3 and not faces 20-24")
    page.press("Select these")
    assert page.selected == [25, 26, 27, 28, 29, *range(30, 40)]
    page.press("Choose", "Others")
    assert len(page.selected) == 105 and 25 not in page.selected
    page.press("Choose", "None")
    assert page.selected == [] and "selection/faces" not in page.scene.drawings


def test_words_that_name_nothing_are_refused_with_their_reason(page):
    page.controls.set("Select by words", "rows 90")
    page.press("Select these")
    assert "the fabric has no such row; its rows are 0 to 11" in page.notices()


def box_over(low: tuple[float, float], high: tuple[float, float], distance: float = 40.0) -> ScreenBox:
    """A rectangle on the screen of a camera that looks at the fabric from the front."""
    camera = CameraView(np.array([5.0, 4.3, distance]), np.array([0.0, 1.0, 0.0, 0.0]), 0.6, 1.0)
    return ScreenBox(camera, low, high)


def test_a_rectangle_on_the_screen_selects_or_paints_what_faces_the_camera(page):
    centres = WIDE.corner_position.reshape(-1, 4, 3).mean(axis=1)
    box = box_over((0.3, 0.3), (0.6, 0.5))
    inside = np.flatnonzero(box.inside(centres)).tolist()
    assert 5 < len(inside) < WIDE.face_count
    page.act("tool", "Select")
    page.page.boxed(box)
    assert page.selected == inside
    page.page.boxed(box_over((0.3, 0.3), (0.6, 0.5), distance=-40.0))  # The camera sees the wrong side, and no face.
    assert page.selected == inside
    page.act("stitch", "p")
    page.page.boxed(box)
    assert same_as(page, Edit("change_stitch", {"faces": inside, "stitch": "p"}))


def test_the_selection_is_filled_by_its_words(page):
    page.controls.set("Select by words", "rows 3-5")
    page.press("Select these")
    page.act("stitch", "p")
    page.press("Fill the selection with the stitch")
    assert page.project.edits[-1] == Edit("change_stitch", {"on": "rows 3-5", "stitch": "p"})


def test_saved_selections_stay_in_the_project_and_follow_their_stitches(page):
    page.act("tool", "Select")
    page.drag([61, 63])
    page.controls.set("Name", "my band")
    page.press("Save the selection")
    page.press("Choose", "None")
    page.act("tool", "Rows and wales")
    page.click_stitch(25)  # A row is inserted below the saved stitches.
    page.act("use", "my band")
    fabric = page.fabric
    centre = fabric.corner_position[fabric.sides_of(np.array(page.selected))].mean(axis=0)
    expected = WIDE.corner_position[WIDE.sides_of(np.array([61, 62, 63]))].mean(axis=0)
    assert len(page.selected) == 3 and np.allclose(centre, expected, atol=0.8)  # At most one row has moved.
    page.act("undo")
    assert page.selected == [61, 62, 63]
    assert page.project.settings("Edit")["selections"] == {"my band": "faces 61-63"}
    page.act("delete", "my band")
    assert page.project.settings("Edit")["selections"] == {}


def test_an_empty_selection_and_an_empty_name_are_not_saved(page):
    page.press("Save the selection")
    assert "expected 1 to 40 characters" in page.notices()
    page.controls.set("Name", "band")
    page.press("Save the selection")
    assert "nothing is selected; select stitches first" in page.notices()


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


def test_a_preview_is_discarded(page):
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


def test_a_preview_of_several_yarns_shows_their_colours(page):
    page.act("tool", "Lay a pattern")
    page.controls.set("Where", "Whole fabric")
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


def test_a_pattern_of_a_file_is_laid_as_its_text(page):
    page.act("tool", "Lay a pattern")
    page.controls.set("Where", "Whole fabric")
    text = b'pattern "Own"\nsource "me"\nrow 1 RS: k1 p1\nrow 2 WS: k1 p1\n'
    page.run(lambda: page.controls.send("Pattern from a file", "../own.knit", text))
    page.press("Lay the pattern")
    assert page.project.edits[-1].arguments["pattern"].startswith('pattern "Own"\n')
    assert (page.fabric.stitch == Stitch.PURL).sum() == 55


@pytest.mark.parametrize(("name", "content"), [("a.knit", b"row 1: ?"), ("b.png", b"no picture"), ("c.txt", b"")])
def test_a_broken_file_of_a_pattern_is_refused(page, name, content):
    page.act("tool", "Lay a pattern")
    page.run(lambda: page.controls.send("Pattern from a file", name, content))
    assert len(page.front.notices) == 1 and page.front.notices[0][2] == "error" and same_as(page)


def test_stitches_that_a_pattern_leaves_out_are_marked_and_described(tmp_path):
    with edit_page(tmp_path, flat(8, 9)) as page:
        page.act("tool", "Lay a pattern")
        page.act("pattern", "rib3x3")
        page.controls.set("Where", "Whole fabric")
        assert "left over beside whole repeats" in page.controls.text_shown()
        assert "left out/faces" in page.scene.drawings


def test_a_drag_along_a_row_crosses_its_loops_in_the_middle(page):
    page.act("tool", "Cross a cable")
    page.drag([42, 45])
    side = top_of(WIDE, 42)
    assert same_as(page, Edit("cross_cable", {"side": side, "left": 2, "right": 2, "front": "left"}))
    assert "loops" in page.scene.drawings
    page.click_stitch(43, "ctrl")
    assert same_as(page) and "loops" not in page.scene.drawings


def test_a_click_crosses_as_many_loops_as_the_controls_say(page):
    page.act("tool", "Cross a cable")
    page.controls.set("Loops from the left", 1)
    page.controls.set("Loops from the right", 3)
    page.controls.set("In front", "the right loops")
    page.click_edge(top_of(WIDE, 42))
    arguments = {"side": top_of(WIDE, 42), "left": 1, "right": 3, "front": "right"}
    assert same_as(page, Edit("cross_cable", arguments))


def test_a_drag_over_several_rows_is_no_cable(page):
    page.act("tool", "Cross a cable")
    page.drag([42, 62])
    assert "the drag covers no two loops of one row" in page.notices() and page.project.edits == ()


@pytest.mark.parametrize("label", ["Insert a row", "Remove a row", "Flip a row", "Remove a wale"])
def test_edits_of_rows_are_made_at_a_click(page, label):
    page.act("tool", "Rows and wales")
    page.controls.set("Rows and wales: edit", label)
    page.click_stitch(44)
    name = label.lower().replace("a ", "").replace(" ", "_")
    extra = {"stitch": "k"} if name == "insert_row" else {}
    assert same_as(page, Edit(name, {"face": 44, **extra}))


def test_edits_of_edges_are_made_at_the_nearest_edge(page):
    page.act("tool", "Loops and edges")
    page.controls.set("Loops and edges: edit", "Split an edge")
    page.click_edge(top_of(WIDE, 44))
    assert same_as(page, split := Edit("split_course_edge", {"side": top_of(WIDE, 44)}))
    page.act("tool", "Rows and wales")
    page.controls.set("Rows and wales: edit", "Insert a wale")
    page.controls.set("Rows (insert a wale)", 2)
    side = int(page.fabric.right_wale[22])
    page.click_edge(side)
    assert same_as(page, split, Edit("insert_wale", {"side": side, "courses": 2}))


def test_a_loop_is_twisted_and_a_bobble_made(page):
    page.act("tool", "Loops and edges")
    page.controls.set("Twist (twist a loop)", "right leg in front")
    page.click_edge(top_of(WIDE, 44))
    twist = Edit("twist_loop", {"side": top_of(WIDE, 44), "twist": -1})
    assert same_as(page, twist)
    page.controls.set("Loops and edges: edit", "Bobble")
    page.click_stitch(66)
    assert same_as(page, twist, Edit("bobble", {"face": 66}))


def test_an_edit_is_made_at_each_place_of_the_selection(page):
    page.controls.set("Select by words", "rectangle 43 3x2")
    page.press("Select these")
    page.act("tool", "Loops and edges")
    page.press("Do it on the selection (loops and edges)")
    assert same_as(page, Edit("twist_loop", {"on": "rectangle 43 3x2", "twist": 1}))


def test_an_edit_on_an_empty_selection_says_to_select(page):
    page.act("tool", "Rows and wales")
    page.press("Do it on the selection (rows and wales)")
    assert "nothing is selected; select stitches first" in page.notices()


def test_a_refused_edit_of_an_edge_marks_the_edge(page):
    page.act("tool", "Loops and edges")
    page.controls.set("Loops and edges: edit", "Join two stitches")
    page.click_edge(int(WIDE.right_wale[44]))
    assert page.project.edits == () and len(page.front.notices) == 1
    assert "place/lines" in page.scene.drawings and "refused/reason" in page.scene.drawings


def test_rings_become_a_spiral_and_rings_again(tmp_path):
    tube_of_rings = around()
    with edit_page(tmp_path, tube_of_rings) as page:
        page.act("tool", "Whole fabric")
        page.press("Rings to spiral")
        assert same_as(page, Edit("spiral"), start=tube_of_rings)
        page.press("Spiral to rings")
        assert same_as(page, Edit("spiral"), Edit("unspiral"), start=tube_of_rings)


def test_rows_are_separated_and_grafted_by_two_clicks(tmp_path):
    fabric = around()
    with edit_page(tmp_path, fabric) as page:
        page.act("tool", "Rows and wales")
        page.controls.set("Rows and wales: edit", "Separate two rows")
        page.click_edge(top_of(fabric, 20))
        separated = page.fabric
        assert len(separated.boundary_loops) == len(fabric.boundary_loops) + 2
        page.act("tool", "Whole fabric")
        at_border, row = separated.twin == BORDER, separated.row[separated.side_face]
        lower = np.flatnonzero(at_border & (separated.side_role == TOP) & (row < row.max()))
        upper = np.flatnonzero(at_border & (separated.side_role == BOTTOM) & (row > 0))
        page.click_edge(int(lower[0]))
        assert "second border" in page.controls.text_shown()
        page.click_edge(int(upper[0]))
        assert page.project.edits[-1].name == "graft" and len(page.fabric.boundary_loops) == len(fabric.boundary_loops)


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
        assert page.controls.made == []


def test_the_page_opens_again_as_it_was_left(page):
    page.act("tool", "Select")
    page.click_stitch(44)
    page.app.open_page("Label")
    page.app.open_page("Edit")
    assert page.selected == [44] and page.page.tool.name == "Select"
    assert "selection/faces" in page.scene.drawings
