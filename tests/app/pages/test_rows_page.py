# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Rows, without a browser: marks by clicks, rows at once, stitches into the project, undo."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.app.pages.gauge_panel import yarn_of
from stitchmesh.app.pages.project_page import next_page
from stitchmesh.app.pages.rows.page import BORDER, LINE, MOVE, TIP
from stitchmesh.app.project.project import Project
from stitchmesh.app.project.shaping import Shaping, shaping_of, shaping_table
from stitchmesh.app.scene.drawing import Labels, Lines
from stitchmesh.app.scene.scene import Stroke
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.face_triangles import face_triangles
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.shaping.auto_stitches import shape_fabric
from stitchmesh.shaping.marks import TimeMark
from stitchmesh.shaping.options import ShapingOptions
from stitchmesh.yarn.yarn_presets import Yarn
from tests.app.pages.headless import Headless, call, headless, on_project, wait_for_task
from tests.app.project.projects import LABEL_ALL, PURL, same, same_project
from tests.gallery import tube

WIDTH = 1.2


def triangles_of(mesh: Mesh) -> Mesh:
    """The same mesh with each face divided into triangles."""
    return Mesh.from_polygons(mesh.vertices, mesh.face_vertex[face_triangles(mesh).corners].tolist())


@pytest.fixture
def page(tmp_path: Path) -> Iterator[Headless]:
    """The page Rows on a tube of triangles, 8 cm high and 19 cm around."""
    with headless(tmp_path, triangles_of(tube(12, 8)), "Project") as opened:
        call(opened, opened.app.open_page, next_page(opened.project))
        settle(opened)
        set_value(opened, "Stitch width [cm]", WIDTH)
        yield opened


def settle(page: Headless) -> None:
    """Wait until the rows are found."""
    page.app.queue.settle()
    wait_for_task(page)


def set_value(page: Headless, label: str, value: object) -> None:
    call(page, page.controls.set, label, value)
    settle(page)


def press(page: Headless, label: str, option: str | None = None) -> None:
    call(page, page.controls.press, label, option)
    settle(page)


def click(page: Headless, point: tuple[float, float, float]) -> None:
    call(page, page.click, point)
    settle(page)


def marks(page: Headless) -> list[tuple[str, str]]:
    """Kind and role of each mark of the draft that the project keeps."""
    return [(mark["kind"], mark["role"]) for mark in page.project.settings("Rows")["draft"]["marks"]]


def points(page: Headless, mark: int) -> list[list[float]]:
    found: list[list[float]] = page.project.settings("Rows")["draft"]["marks"][mark]["points"]
    return found


def front(page: Headless, height: float) -> tuple[float, float, float]:
    """A point of the front of the tube."""
    return 0.0, height, 3.0


def text(page: Headless) -> str:
    return page.controls.text_shown()


def knit(page: Headless) -> None:
    press(page, "Find the stitches")
    press(page, "Knit these rows")


def test_a_mesh_of_triangles_leads_here_and_one_of_quads_to_label(page, tmp_path):
    assert page.app.page.name == "Rows"
    with headless(tmp_path / "quads", tube(12, 8), "Project") as other:
        assert next_page(other.project) == "Label"
    call(page, page.app.open_page, "Label")
    press(page, "Go to Rows")
    assert page.app.page.name == "Rows"


def test_rows_are_drawn_at_once_with_the_lengths_at_begin_and_end(page):
    times = page.scene.drawings["times"]
    assert isinstance(times, Labels) and sorted(times.texts) == ["begin 0 cm", "end 8 cm"]
    lines = page.scene.drawings["row lines"]
    assert isinstance(lines, Lines)
    rows = round(8.0 / (0.77 * WIDTH))
    place = lines.segments[:, :, 1] * rows / 8.0
    assert np.abs(place - np.rint(place)).max() < 0.02, "the lines divide the height of the tube evenly"
    assert set(np.rint(place).ravel()) >= set(range(1, rows))
    assert f">{rows}</td>" in text(page)


def test_clicks_at_a_border_give_it_one_role_after_another(page):
    for role in ("begin", "end", "side"):
        click(page, front(page, 0.0))
        assert marks(page) == [("border", role)]
        assert page.controls.find("Role of the border").value == role
    click(page, front(page, 0.0))
    assert marks(page) == []


def test_a_line_is_made_of_clicks_and_a_point_of_it_is_moved_and_removed(page):
    set_value(page, "A click", LINE)
    click(page, front(page, 4.0))
    press(page, "Finish the line")
    assert "has one point" in page.notices() and marks(page) == []
    click(page, front(page, 4.5))
    assert "2 points" in text(page)
    click(page, front(page, 7.0))
    call(page, page.controls.act, "undo")
    press(page, "Finish the line")
    assert marks(page) == [("stroke", "row")]
    assert [point[1] for point in points(page, 0)] == pytest.approx([4.0, 4.5], abs=0.01)
    set_value(page, "A click", MOVE)
    set_value(page, "Point", 2)
    click(page, front(page, 5.0))
    assert [point[1] for point in points(page, 0)] == pytest.approx([4.0, 5.0], abs=0.01)
    press(page, "Remove the point")
    assert marks(page) == [], "a line of one point is no line"


def test_a_tip_is_put_chosen_by_a_click_and_dragged(page):
    set_value(page, "A click", TIP)
    click(page, front(page, 4.0))
    assert marks(page) == [("point", "end")]
    call(page, page.controls.act, "undo")
    call(page, page.controls.act, "redo")
    set_value(page, "A click", BORDER)
    click(page, front(page, 4.0))
    assert page.controls.find("Role").value == "end"
    for phase, height in (("start", 4.0), ("move", 4.5), ("end", 5.0)):
        origin = np.array(front(page, height)) + np.array([0.0, 0.0, 100.0])
        call(page, page.app.page.stroked, Stroke(origin, np.array([0.0, 0.0, -1.0]), phase=phase))
    settle(page)
    assert points(page, 0)[0][1] == pytest.approx(5.0, abs=0.01)
    call(page, page.controls.act, "undo")
    assert points(page, 0)[0][1] == pytest.approx(4.0, abs=0.01)
    set_value(page, "Role", "begin")
    assert marks(page) == [("point", "begin")]
    press(page, "Remove the mark")
    assert marks(page) == []


def test_a_plain_place_has_a_radius_and_no_time(page):
    set_value(page, "A click", TIP)
    click(page, front(page, 4.0))
    set_value(page, "Given time", True)
    set_value(page, "Role", "plain")
    set_value(page, "Plain up to", 2.5)
    (mark,) = page.project.settings("Rows")["draft"]["marks"]
    assert (mark["role"], mark["time"], mark["radius"]) == ("plain", None, 2.5)
    with pytest.raises(ParameterError, match="'Given time': is hidden"):
        page.controls.find("Given time")
    assert "row lines" in page.scene.drawings and "up to 2.5 cm" in text(page)
    set_value(page, "Plain up to", 0.0)
    assert "radius" not in page.project.settings("Rows")["draft"]["marks"][0], "0 is the usual radius"
    set_value(page, "Role", "end")
    with pytest.raises(ParameterError, match="'Plain up to': is hidden"):
        page.controls.find("Plain up to")


def test_a_listed_border_and_a_typed_place_are_as_good_as_clicks(page):
    call(page, page.controls.act, "border", "0")
    settle(page)
    assert marks(page) == [("border", "begin")]
    call(page, page.controls.act, "remove", "0")
    settle(page)
    set_value(page, "A click", TIP)
    set_value(page, "Place", "0, 4, 3")
    press(page, "Act at this place")
    assert points(page, 0)[0] == pytest.approx([0.0, 4.0, 3.0], abs=1.0)
    set_value(page, "Place", "0, 4")
    press(page, "Act at this place")
    assert "expected three numbers" in page.notices()


def test_times_that_contradict_each_other_are_said_in_one_line(page):
    for height, role, time in ((0.0, "begin", 8.0), (8.0, "end", 2.0)):
        click(page, front(page, height))
        set_value(page, "Role of the border", role)
        set_value(page, "Given time", True)
        set_value(page, "Time", time)
    assert "Not possible:" in text(page) and "exchange the times" in text(page)
    assert page.front.notices == [], "the page says it, not a notice for each change"
    assert "row lines" not in page.scene.drawings
    set_value(page, "Time", 20.0)
    assert "Not possible:" not in text(page) and "row lines" in page.scene.drawings
    assert page.scene.drawings["times"].texts[0] in ("begin 8 cm", "end 20 cm")


def test_the_stitches_are_those_of_python_and_relax_on_the_mesh(page):
    click(page, front(page, 8.0))
    knit(page)
    mark = TimeMark("border", tuple(map(tuple, points(page, 0))), "begin")
    expected = shape_fabric(page.project.mesh, stitch_width=WIDTH, options=ShapingOptions(marks=[mark]))
    assert same(page.project.fabric, expected.fabric)
    assert f"{expected.report.stitches:,} in" in text(page)
    relaxed = relax_mesh(page.project.fabric, surface=page.project.mesh).fabric
    assert relaxed.face_count == expected.fabric.face_count
    for name in ("Even out", "Edit"):
        call(page, page.app.open_page, name)
        assert page.app.page.unavailable() is None


def test_a_change_asks_for_new_stitches_and_undo_brings_the_known_ones_back(page):
    knit(page)
    assert page.controls.find("Go on: edit the stitches")
    set_value(page, "Multiple of", 4)
    assert page.controls.find("Find the stitches")
    call(page, page.controls.act, "undo")
    assert page.controls.find("Go on: edit the stitches")


def test_a_project_is_opened_again_with_its_marks_stitches_and_edits(page, tmp_path):
    click(page, front(page, 8.0))
    knit(page)
    page.project.apply_edit(PURL)
    page.project.close()
    again = Project.open(tmp_path / "project")
    assert same_project(again, page.project) and again.shaping == page.project.shaping
    with on_project(again, "Rows") as shown:
        assert marks(shown) == [("border", "begin")]
        assert shown.controls.find("Go on: edit the stitches")


def test_a_division_takes_the_place_of_the_rows_and_can_be_taken_back(tmp_path):
    with headless(tmp_path, tube(12, 4), "Rows") as page:
        settle(page)
        knit(page)
        shaped = page.project.fabric
        page.project.apply_label_step(LABEL_ALL)
        assert page.project.shaping is None
        page.project.restore()
        assert page.project.fabric is shaped


def test_how_rows_and_increases_are_found_is_chosen_and_kept(page):
    set_value(page, "Short rows", False)
    set_value(page, "Increases in a row", "1 in 4")
    set_value(page, "Shaping", "at seams and edges")
    set_value(page, "Increases", "lifted, from the loop below")
    knit(page)
    shaping = page.project.shaping
    assert (shaping.short_rows, shaping.most_shaping) == (False, 0.25)
    assert (shaping.shaping, shaping.increase) == ("seams", "lifted")
    assert shaping_of(shaping_table(shaping)) == shaping
    assert page.project.fabric.stitch.tolist() == shaping.shape(page.project.mesh).fabric.stitch.tolist()


def test_a_shaping_of_an_earlier_version_has_the_other_options_by_default():
    earlier = {"stitch_width": 1.2, "stitch_height": None, "marks": [], "up": [0.0, 1.0, 0.0], "multiple": 2}
    assert shaping_of(earlier) == Shaping(stitch_width=1.2, multiple=2)


def test_a_yarn_gives_its_gauge(page):
    yarn = Yarn.named("super-bulky")
    set_value(page, "Yarn", yarn.name)
    assert yarn_of(page.project) == yarn
    assert page.controls.find("Stitch width [cm]").value == pytest.approx(yarn.stitch_width, abs=0.0005)  # 3 digits
    assert "10 cm" in text(page) and "4 inches" in text(page)
    knit(page)
    assert page.project.shaping.stitch_width == yarn.stitch_width
    assert "Not validated" not in page.controls.text_shown()
    set_value(page, "Stitch width [cm]", 1.5 * yarn.stitch_width)
    assert "The size of stockinette with loops of 24.4 core diameters was compared" in page.controls.text_shown()
