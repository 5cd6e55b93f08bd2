# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits at a place: cables, loops, edges, rows, wales, spirals and grafts."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit
from stitchmesh.mesh import BORDER, BOTTOM, TOP
from tests.app.pages.edit.opened import WIDE, edit_page, same_as
from tests.editing.fabrics import around, top_of


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
    page.controls.set("From the left", 1)
    page.controls.set("From the right", 3)
    page.controls.set("In front", "the right loops")
    page.click_edge(top_of(WIDE, 42))
    arguments = {"side": top_of(WIDE, 42), "left": 1, "right": 3, "front": "right"}
    assert same_as(page, Edit("cross_cable", arguments))


def test_loops_are_crossed_in_any_order(page):
    page.act("tool", "Cross a cable")
    page.controls.set("Order", "3, 1 2")
    page.drag([42, 44])
    arguments = {"side": top_of(WIDE, 42), "destinations": [2, 0, 1], "layers": [3, 2, 1]}
    assert same_as(page, cable := Edit("set_cable", arguments))
    page.drag([62, 65])
    assert "got an order of 3 loops for 4 loops" in page.notices() and same_as(page, cable)
    page.controls.set("Order", "3 1")  # This is no order, and two groups cross.
    page.drag([62, 65])
    two = Edit("cross_cable", {"side": top_of(WIDE, 62), "left": 2, "right": 2, "front": "left"})
    assert same_as(page, cable, two)


def test_a_drag_over_several_rows_is_no_cable(page):
    page.act("tool", "Cross a cable")
    page.drag([42, 62])
    assert "the drag covers no two loops of one row" in page.notices() and page.project.edits == ()


@pytest.mark.parametrize("label", ["Insert a row", "Remove a row", "Flip a row", "Remove a wale"])
def test_edits_of_rows_are_made_at_a_click(page, label):
    page.act("tool", "Rows and wales")
    page.controls.set("Edit of rows", label)
    page.click_stitch(44)
    name = label.lower().replace("a ", "").replace(" ", "_")
    extra = {"stitch": "k"} if name == "insert_row" else {}
    assert same_as(page, Edit(name, {"face": 44, **extra}))


def test_edits_of_edges_are_made_at_the_nearest_edge(page):
    page.act("tool", "Loops and edges")
    page.controls.set("Edit of loops", "Split an edge")
    page.click_edge(top_of(WIDE, 44))
    assert same_as(page, split := Edit("split_course_edge", {"side": top_of(WIDE, 44)}))
    page.act("tool", "Rows and wales")
    page.controls.set("Edit of rows", "Insert a wale")
    page.controls.set("Rows", 2)
    side = int(page.fabric.right_wale[22])
    page.click_edge(side)
    assert same_as(page, split, Edit("insert_wale", {"side": side, "courses": 2}))


def test_a_loop_is_twisted_and_a_bobble_made(page):
    page.act("tool", "Loops and edges")
    page.controls.set("Twist", "right leg in front")
    page.click_edge(top_of(WIDE, 44))
    twist = Edit("twist_loop", {"side": top_of(WIDE, 44), "twist": -1})
    assert same_as(page, twist)
    page.controls.set("Edit of loops", "Bobble")
    page.click_stitch(66)
    assert same_as(page, twist, Edit("bobble", {"face": 66}))


def test_an_edit_is_made_at_each_place_of_the_selection(page):
    page.controls.set("Select by words", "rectangle 43 3x2")
    page.press("Select these")
    page.act("tool", "Loops and edges")
    page.press("Edit the selected loops")
    assert same_as(page, Edit("twist_loop", {"on": "rectangle 43 3x2", "twist": 1}))


def test_short_rows_are_worked_over_the_selected_stitches(page):
    page.act("tool", "Rows and wales")
    page.controls.set("Edit of rows", "Short rows")
    page.click_stitch(44)
    assert "select the stitches first" in page.notices() and page.project.edits == ()
    page.controls.set("Select by words", "rectangle 43 4x1")
    page.press("Select these")
    page.press("Edit the selected rows")
    assert same_as(page, Edit("short_rows", {"on": "rectangle 43 4x1", "stitch": "k"}))


def test_a_refused_edit_of_an_edge_marks_the_edge(page):
    page.act("tool", "Loops and edges")
    page.controls.set("Edit of loops", "Join two stitches")
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
        page.controls.set("Edit of rows", "Separate two rows")
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
