# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tools that paint: each click, drag and button makes the edit that Python makes."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.app.scene.drawing import Labels, Surface
from stitchmesh.app.scene.scene import Stroke
from stitchmesh.editing.edit import Edit
from stitchmesh.selection import select
from tests.app.pages.edit.opened import WIDE, same_as


def test_a_drag_paints_all_stitches_on_its_line_as_one_edit(page):
    page.act("stitch", "p")
    page.drag([41, 44])
    assert page.project.edits == (Edit("change_stitch", {"faces": [41, 42, 43, 44], "stitch": "p"}),)
    assert page.front.notices == []


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
    assert "face 44: k2tog needs 2 and 1; the face has 1 bottom and 1 top sides" in page.notices()
    marked, reason = page.scene.drawings["refused/faces"], page.scene.drawings["refused/reason"]
    assert isinstance(marked, Surface) and len(marked.triangles) == 2
    assert isinstance(reason, Labels) and "k2tog needs 2 and 1" in reason.texts[0]
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
    page.front.left_controls.set("Colour of the yarn", "#000080")
    page.run(lambda: page.front.left_controls.press("Set the colour"))
    stripe = Edit("stripe", {"faces": list(range(40, 50)), "yarn": 2})
    assert same_as(page, stripe, Edit("recolour", {"yarn": 2, "colour": "#000080"}))
    shown = page.scene.drawings["fabric/0"].colours
    assert shown.palette[shown.index[2 * 44]].tolist() == [0, 0, 128]


def test_stripes_are_knitted_on_the_selection_or_on_all(page):
    page.act("tool", "Paint yarns")
    page.controls.set("Stripes", "1 navy, 2 0")
    page.press("Knit stripes")
    page.page.session.choose(np.arange(40, 50))
    page.controls.set("Stripes", "1 madder")
    page.press("Knit stripes")
    first = Edit("stripes", {"bands": "1 navy, 2 0"})
    assert same_as(page, first, Edit("stripes", {"bands": "1 madder", "faces": list(range(40, 50))}))
