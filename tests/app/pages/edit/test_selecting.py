# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Selections: by click, drag, words and rectangles, saved and followed through edits."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.scene.scene import CameraView, ScreenBox
from stitchmesh.editing.edit import Edit
from tests.app.pages.edit.opened import WIDE, same_as


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
