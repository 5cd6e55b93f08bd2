# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Edit in a real browser: what the mouse and the keyboard do is what Python does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.app.project.project import Project
from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.io import write_stitches
from stitchmesh.mesh import StitchMesh
from stitchmesh.patterns import apply_pattern
from stitchmesh.selection import select
from tests.app.browser import Rig
from tests.editing.fabrics import flat, top_of
from tests.editing.random_edits import bits

FABRIC = flat(10, 12)
COLOUR_OF_FACE = """(name) => {
  let mesh = null;
  const scene = window.__viserMutable.nodeRefFromName;
  for (const key of Object.keys(scene)) if (key.startsWith(name) && !key.includes("edges")) {
    scene[key] && scene[key].traverse((part) => { if (part.isMesh && part.geometry.attributes.color) mesh = part; });
  }
  return mesh ? Array.from(mesh.geometry.attributes.color.array) : [];
}"""
"""Script that returns the colours of all corners of the triangles of a block."""


@pytest.fixture
def opened(app_in_browser: Callable[..., AbstractContextManager[Rig]], tmp_path: Path) -> Iterator[Rig]:
    """The page Edit on a flat piece of 10 x 12 knit stitches."""
    write_stitches(path := tmp_path / "piece.h5", FABRIC)
    project = Project.create(tmp_path / "project")
    project.import_mesh(path.name, path.read_bytes())
    project.close()
    with app_in_browser("Edit") as rig:
        yield rig


def middle(face: int, fabric: StitchMesh = FABRIC) -> np.ndarray:
    return fabric.corner_position[fabric.sides_of(np.array([face]))].mean(axis=0)


def corner_colours(rig: Rig) -> np.ndarray:
    """Colour of each triangle of the first block, shape (T, 4)."""
    return np.array(rig.browser_page.evaluate(COLOUR_OF_FACE, "/fabric/0/")).reshape(-1, 3, 4)[:, 0]


def fabric_of(rig: Rig) -> StitchMesh:
    assert rig.app.project.fabric is not None
    return rig.app.project.fabric


def test_a_click_paints_and_keys_undo_and_redo(opened):
    purl = Edit("change_stitch", {"faces": [44], "stitch": "p"})
    before = corner_colours(opened)
    opened.act("stitch", "p")
    opened.click_at(middle(44))
    assert opened.app.project.edits == (purl,)
    changed = np.flatnonzero((corner_colours(opened) != before).any(axis=1))
    assert changed.tolist() == [88, 89]  # The two triangles of face 44; no other colour has changed.
    opened.key("Control+z")
    opened.wait_for(lambda: opened.app.project.edits == (), "undo")
    opened.key("Control+y")
    opened.wait_for(lambda: opened.app.project.edits == (purl,), "redo")
    assert bits(fabric_of(opened)) == bits(apply_edit(FABRIC, purl).fabric)


def test_a_drag_paints_and_a_drag_beside_the_fabric_turns_the_view(opened):
    opened.act("stitch", "p")
    opened.drag([middle(41), middle(44)])
    assert opened.app.project.edits == (Edit("change_stitch", {"faces": [41, 42, 43, 44], "stitch": "p"}),)
    camera = lambda: opened.call(lambda: opened.app.scene.cameras()[0].position)  # noqa: E731
    before = camera()
    opened.drag([(5.0, 10.5, 0.0), (7.0, 11.0, 0.0)])
    opened.wait_for(lambda: not np.allclose(camera(), before), "the view turns")
    assert len(opened.app.project.edits) == 1


def test_a_rectangle_with_the_shift_key_selects_and_the_pattern_is_shown_and_laid(opened):
    opened.act("tool", "Select")
    opened.settle()
    low, high = middle(22) - [0.4, 0.3, 0.0], middle(77) - [-0.4, -0.3, 0.0]
    opened.drag([low, high], "Shift")
    faces = select(FABRIC, "rectangle 22 6x6")
    opened.wait_for_text(f"{len(faces)} stitches are selected")
    opened.act("tool", "Lay a pattern")
    opened.settle()
    opened.act("pattern", "eyelet-lace")
    opened.wait_for_text("Preview of Eyelet lace")
    assert opened.app.project.edits == ()
    opened.press("Lay the pattern")
    opened.settle()
    assert bits(fabric_of(opened)) == bits(apply_pattern(FABRIC, "eyelet-lace", faces=faces))


def test_a_cable_is_dragged_over_a_row(opened):
    opened.act("tool", "Cross a cable")
    opened.settle()
    opened.drag([middle(43), middle(46)])
    cable = Edit("cross_cable", {"side": top_of(FABRIC, 43), "left": 2, "right": 2, "front": "left"})
    assert opened.app.project.edits == (cable,)


def test_a_refused_edit_says_why_in_the_scene_and_in_a_notice(opened):
    opened.act("stitch", "d12k")
    opened.click_at(middle(44))
    reason = "face 44: k2tog needs 2 and 1"
    opened.wait_for_text(reason)
    assert any(reason in notice for notice in opened.notices())
    names = opened.browser_page.evaluate("() => Object.keys(window.__viserMutable.nodeRefFromName)")
    assert any("refused/reason" in name for name in names) and opened.app.project.edits == ()


def test_rows_are_inserted_by_a_click_and_keys_take_up_tools(opened):
    opened.key("r")
    opened.wait_for_text("a new row is knitted above its row")
    opened.click_at(middle(44))
    assert opened.app.project.edits == (Edit("insert_row", {"face": 44, "stitch": "k"}),)
    assert len(corner_colours(opened)) >= 2 * (FABRIC.face_count + 10)


def test_selecting_by_words_needs_no_mouse(opened):
    page = opened.browser_page
    opened.row("Select by words").locator("input").focus()
    page.keyboard.type("rows 3-5")
    words = lambda: opened.app.page._selection._text.value  # noqa: E731
    opened.wait_for(lambda: words() == "rows 3-5", "the browser sends what was typed a moment later")
    opened.button("Select these").focus()
    page.keyboard.press("Enter")
    opened.wait_for_text("30 stitches are selected")
    purl = page.locator('[data-action="stitch"][data-value="p"]')
    purl.focus()
    page.keyboard.press("Enter")
    opened.button("Fill the selection with the stitch").focus()
    page.keyboard.press("Enter")
    wanted = Edit("change_stitch", {"on": "rows 3-5", "stitch": "p"})
    opened.wait_for(lambda: opened.app.project.edits, "the selection is filled")
    assert opened.app.project.edits == (wanted,)


def test_a_second_browser_shows_the_same_edit(opened):
    other = opened.another_window()
    opened.act("stitch", "p")
    opened.click_at(middle(44))
    other.browser_page.wait_for_timeout(500)
    one, two = (window.browser_page.evaluate(COLOUR_OF_FACE, "/fabric/0/") for window in (opened, other))
    assert one == two and len(one) >= 12 * 2 * FABRIC.face_count
    other.close()


def test_no_label_is_missing_in_the_panels(opened):
    for tool in ("Paint stitches", "Paint yarns", "Lay a pattern", "Loops and edges"):
        opened.act("tool", tool)
        opened.settle()
        unnamed = opened.browser_page.evaluate(
            """() => Array.from(document.querySelectorAll("[data-stitchmesh] button"))
               .filter((button) => !(button.getAttribute("aria-label") || button.textContent).trim()).length"""
        )
        assert unnamed == 0, tool
