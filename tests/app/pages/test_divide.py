# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Divide, without a browser: it estimates what the division gives, and divides as Python does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.app.pages.gauge_panel import yarn_of
from stitchmesh.app.project.division import Division, division_of, division_table
from stitchmesh.app.project.project import Project
from stitchmesh.app.scene.drawing import Lines, Surface
from stitchmesh.errors import ParameterError
from stitchmesh.labeling.steps import LabelStep
from stitchmesh.mesh import StitchMesh
from stitchmesh.recipe.estimate import estimate_garment
from stitchmesh.tessellate import tessellate
from stitchmesh.yarn.yarn_presets import Yarn
from tests.app.pages.headless import Headless, headless
from tests.app.project.projects import same
from tests.gallery import tube

WIDTH = 0.5


@pytest.fixture
def page(tmp_path: Path) -> Iterator[Headless]:
    """The page Divide on a labeled tube of 12 x 4 faces, 4 cm high and 36 cm around, with stitches of half a cm."""
    with headless(tmp_path, tube(12, 4, radius=6.0, height=1.5), "Label") as opened:
        opened.project.apply_label_step(LabelStep("label_all"))
        opened.app.open_page("Divide")
        opened.controls.set("Stitch width [cm]", WIDTH)
        yield opened


def labeled_of(page: Headless) -> StitchMesh:
    assert page.project.labeled is not None
    return page.project.labeled


def ends(page: Headless, side: int) -> tuple[int, int]:
    labeled = labeled_of(page)
    return int(labeled.face_vertex[side]), int(labeled.face_vertex[labeled.side_next[side]])


def divided(page: Headless) -> None:
    """Press the button, and wait for the worker thread."""
    page.controls.press("Divide into stitches")
    wait_until(page, lambda: not page.app.tasks.running)


def wait_until(page: Headless, condition: Callable[[], bool]) -> None:
    while not condition():
        page.front.queue.settle()
    page.front.queue.settle()


def lines(page: Headless, name: str) -> int:
    """Number of lines of a drawing; 0 if there is none."""
    drawing = page.scene.drawings.get(name)
    if drawing is None:
        return 0
    assert isinstance(drawing, Lines)
    return len(drawing.segments)


def test_the_division_is_that_of_python_and_is_kept(page):
    page.controls.set("Increases", "yarn over, with a hole")
    divided(page)
    expected = tessellate(labeled_of(page), stitch_width=WIDTH, increase="yo")
    assert same(page.project.fabric, expected)
    assert division_of(division_table(page.project.division)) == Division(stitch_width=WIDTH, increase="yo")


def test_the_estimate_follows_the_size_and_the_quality_and_says_its_doubts(page):
    assert "Please note" not in page.controls.text_shown()
    page.controls.set("Stitch width [cm]", 0.8)  # which the faces of 1.5 cm can only nearly have
    page.controls.set("Quality", "reference")
    estimate = estimate_garment(labeled_of(page), stitch_width=0.8, quality="reference")
    text = page.controls.text_shown()
    assert f"{estimate.stitches:,} in {estimate.rows:,} rows" in text
    assert f"{estimate.yarn_length / 100.0:,.0f} m" in text
    assert f"{estimate.control_points:,}" in text and "Please note" in text


def test_a_yarn_gives_its_gauge_and_the_weight(page):
    page.controls.set("Yarn", "worsted")
    yarn = Yarn.named("worsted")
    divided(page)
    assert page.project.division == Division(
        stitch_width=yarn.gauge.stitch_width, stitch_height=yarn.gauge.stitch_height
    )
    assert " g</td>" in page.controls.text_shown()
    page.controls.set("Stitch width [cm]", 0.6)
    assert page.controls.find("Yarn").value == "worsted"  # at the user's own gauge
    assert yarn_of(page.project) == yarn
    # 10 cm / 0.6 cm, and 10.16 cm / 0.6 cm
    assert "16.7 stitches" in page.controls.text_shown() and "16.9 and" in page.controls.text_shown()


def test_the_height_is_the_usual_one_until_it_is_set(page):
    with pytest.raises(ParameterError, match="is hidden"):
        page.controls.find("Stitch height [cm]")
    page.controls.set("Usual height", False)
    page.controls.set("Stitch height [cm]", 0.6)
    divided(page)
    assert page.project.division == Division(stitch_width=WIDTH, stitch_height=0.6)
    page.controls.set("Usual height", True)
    divided(page)
    assert page.project.division == Division(stitch_width=WIDTH)


def test_a_number_on_a_clicked_edge(page):
    side = int(labeled_of(page).face_start[14])
    page.click_side(side)
    first, second = ends(page, side)
    text = page.controls.text_shown()
    assert f"Edge {first},{second}" in text or f"Edge {second},{first}" in text
    assert lines(page, "chosen") == 1
    page.controls.set("Number", 9)
    assert page.scene.drawings["numbers"].texts == ("9",)
    divided(page)
    assert same(page.project.fabric, tessellate(labeled_of(page), stitch_width=WIDTH, counts={side: 9}))
    assert lines(page, "counted") == 1
    page.click((60.0, 60.0, 0.0))  # beside the mesh
    assert lines(page, "chosen") == 0
    with pytest.raises(ParameterError, match="is hidden"):
        page.controls.find("Number")
    page.click_side(side)
    page.controls.press("Number by length")
    assert lines(page, "counted") == 0


def test_the_number_of_a_wale_edge_holds_for_its_row(page):
    labeled = labeled_of(page)
    row = labeled.row[20]
    one, other = (int(labeled.left_wale[face]) for face in np.flatnonzero(labeled.row == row)[:2])
    page.click_side(one)
    page.controls.set("Number", 7)
    page.click_side(other)
    assert page.controls.find("Number").value == 7
    page.controls.set("Number", 5)
    divided(page)
    division = page.project.division
    assert division is not None
    assert list(division.counts.values()) == [5]


def test_a_marked_edge(page):
    labeled = labeled_of(page)
    course, wale = int(labeled.face_start[14]), int(labeled.left_wale[14])
    page.click_side(course)
    with pytest.raises(ParameterError, match="is hidden"):
        page.controls.find("Marked edge")
    page.click_side(wale)
    page.controls.set("Marked edge", True)
    assert lines(page, "marked") == 1
    divided(page)
    division = page.project.division
    assert division is not None
    assert {frozenset(edge) for edge in division.marked} == {frozenset(ends(page, wale))}
    page.click_side(wale)
    page.controls.set("Marked edge", False)
    assert lines(page, "marked") == 0


def test_edges_as_text_and_on_the_mesh_are_the_same(page):
    labeled = labeled_of(page)
    course, wale = ends(page, int(labeled.face_start[14])), ends(page, int(labeled.left_wale[20]))
    text = f"{course[0]},{course[1]}=9\n{wale[0]},{wale[1]}\n"
    page.controls.set("Edges", text)
    assert (lines(page, "counted"), lines(page, "marked")) == (1, 1)
    assert page.controls.find("Edges").value == text
    divided(page)
    assert page.project.division == Division(stitch_width=WIDTH, counts={course: 9}, marked=(wale,))


@pytest.mark.parametrize(
    ("text", "message"),
    [("0,1=3\nhem\n", "line:2: got"), ("0,9999=3\n", "no edge joins these vertices")],
)
def test_a_text_with_an_error_says_the_line_and_changes_nothing(page, text, message):
    page.controls.set("Edges", text)
    assert message in page.controls.text_shown()
    assert (lines(page, "counted"), lines(page, "marked")) == (0, 0)


def test_what_is_not_possible_says_why_and_cannot_be_divided(page):
    side = int(labeled_of(page).face_start[14])
    page.click_side(side)
    page.controls.set("Number", 600)
    text = page.controls.text_shown()
    assert "Not possible" in text
    assert "a stitch changes the number of loops by at most a factor of 3" in text
    with pytest.raises(ParameterError, match="is disabled"):
        page.controls.press("Divide into stitches")
    page.controls.press("Undo")
    divided(page)


def test_the_stitches_are_shown_with_their_numbers(page):
    divided(page)
    fabric = page.project.fabric
    assert fabric is not None
    surface = page.scene.drawings["stitches"]
    assert isinstance(surface, Surface)
    assert len(surface.triangles) == fabric.side_count - 2 * fabric.face_count
    assert "faces" not in page.scene.drawings
    assert "cast on: 72" in page.controls.text_shown()
    page.controls.set("Show", "mesh")
    assert "stitches" not in page.scene.drawings
    assert "faces" in page.scene.drawings


def test_changes_are_undone_and_redone_and_the_moves_of_a_slider_together(page):
    page.controls.set("Usual height", False)
    for width in (0.6, 0.7):
        page.controls.set("Stitch width [cm]", width)
    page.controls.press("Undo")
    assert page.controls.find("Stitch width [cm]").value == WIDTH
    page.controls.act("undo")
    assert page.controls.find("Usual height").value is True
    page.controls.press("Redo")
    page.controls.act("redo")
    assert page.controls.find("Stitch width [cm]").value == 0.7
    with pytest.raises(ParameterError, match="no change of the division to undo"):
        for _ in range(9):
            page.controls.press("Undo")


def test_a_text_that_is_typed_is_not_rewritten(page):
    """While a count is typed, its edge alone is a mark for a moment."""
    first, second = ends(page, int(labeled_of(page).left_wale[14]))
    for end in ("", "=", "=7"):
        text = f"# sleeve\n{first},{second}{end}"
        page.controls.set("Edges", text)
        assert page.controls.find("Edges").value == text
    assert (lines(page, "counted"), lines(page, "marked")) == (1, 0)
    page.controls.press("Undo")
    assert (lines(page, "counted"), lines(page, "marked")) == (0, 0)


def test_what_was_chosen_is_there_again_after_the_project_was_closed(tmp_path):
    with headless(tmp_path, tube(12, 4, radius=6.0, height=1.5), "Label") as page:
        page.project.apply_label_step(LabelStep("label_all"))
        page.app.open_page("Divide")
        page.controls.set("Stitch width [cm]", 0.65)
        page.click_side(int(labeled_of(page).face_start[14]))
        page.controls.set("Number", 9)
        page.app.open_page("Label")
        page.app.open_page("Divide")
        assert (page.controls.find("Stitch width [cm]").value, lines(page, "counted")) == (0.65, 1)
    project = Project.open(tmp_path / "project")
    assert project.settings("Divide")["draft"]["stitch_width"] == 0.65
    project.close()


def test_edges_that_another_mesh_does_not_have_are_left_out(page, tmp_path):
    page.click_side(int(labeled_of(page).face_start[40]))
    page.controls.set("Number", 9)
    from stitchmesh.io.meshes import write_mesh

    write_mesh(tmp_path / "small.obj", tube(6, 2, radius=6.0, height=1.5))
    page.project.import_mesh("small.obj", (tmp_path / "small.obj").read_bytes())
    page.project.apply_label_step(LabelStep("label_all"))
    page.app.refresh()
    assert "were left out" in page.notices()
    assert lines(page, "counted") == 0
