# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Even out, without a browser: it gives what the library gives, and says where stitches are uneven."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.app.pages.even_out import AGAIN, START, EvenOutPage
from stitchmesh.app.pages.page_run import STALE
from stitchmesh.app.project.division import Division
from stitchmesh.app.project.project import Project
from stitchmesh.app.scene.drawing import Colours, Lines, Surface
from stitchmesh.compute.device import alone
from stitchmesh.editing.edit import Edit
from stitchmesh.labeling.steps import LabelStep
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.meshrelax import MeshRelaxOptions, relax_mesh
from tests.app.pages.headless import Headless, call, headless, press, wait_for_task
from tests.gallery import tube

DIVISION = Division(stitch_width=0.6)
NEXT = "Go on to the yarns"


def uneven_tube() -> Mesh:
    """A tube with a waist, whose stitches are not even after division."""
    mesh = tube(12, 4)
    height = mesh.vertices[:, 1]
    scale = 1.0 - 0.35 * np.exp(-(((height - height.mean()) / np.ptp(height) / 0.3) ** 2))
    return replace(mesh, vertices=mesh.vertices * np.stack([scale, np.ones_like(scale), scale], axis=1))


@pytest.fixture
def shown(tmp_path: Path) -> Iterator[Headless]:
    with headless(tmp_path, uneven_tube(), "Label") as app:
        app.project.apply_label_step(LabelStep("label_all"))
        app.project.divide(DIVISION)
        app.app.open_page("Even out")
        yield app


def evened(project: Project, **arguments: float) -> StitchMesh:
    assert project.fabric is not None and project.mesh is not None
    options = MeshRelaxOptions(**{"aspect": 0.77} | arguments)  # type: ignore[arg-type]
    return relax_mesh(project.fabric, surface=project.mesh, options=options).fabric


def with_wide_rows(fabric: StitchMesh) -> StitchMesh:
    """The fabric with the stretch of a relaxation in which the stitches of rows 1 and 2 are far too wide."""
    wide = ~fabric.is_wale & np.isin(fabric.row[fabric.side_face], [1, 2])
    stretch = np.ones(len(fabric.edge_side))
    stretch[fabric.side_edge[wide]] = 2.5
    return replace(fabric, stretch=stretch)


def test_the_result_is_that_of_the_library_to_the_last_bit(shown: Headless):
    expected = evened(shown.project)
    press(shown, START)
    wait_for_task(shown)
    found = shown.project.evened
    assert found is not None and np.array_equal(found.vertices, expected.vertices)
    assert np.array_equal(found.stretch, expected.stretch)
    assert "even" in shown.controls.text_shown()
    shown.controls.find(NEXT), shown.controls.find(AGAIN)  # both are shown, or an error says that they are not


def test_settings_reach_the_library_and_stay_in_the_project(shown: Headless):
    shown.controls.set("Covered part", 0.5)
    shown.controls.set("Height over width", 1.2)
    shown.controls.set("Resist folding", False)
    expected = evened(shown.project, aspect=1.2, alpha=0.5, area_force=False)
    press(shown, START)
    wait_for_task(shown)
    assert np.array_equal(shown.project.evened.vertices, expected.vertices)
    shown.app.open_page("Label")
    shown.app.open_page("Even out")
    assert shown.controls.find("Covered part").value == 0.5


def test_a_paused_relaxation_is_shown_stepped_and_stopped_with_what_was_shown_last(shown: Headless):
    with alone():  # The relaxation cannot begin before it is paused.
        press(shown, START)
        press(shown, "Pause")
    surface = shown.scene.drawings["fabric"]
    press(shown, "Step")
    page = shown.app.page
    assert isinstance(page, EvenOutPage) and page._run.live is not None
    run = page._run.live
    while run.newest is None or run.newest.iteration < 1:
        shown.app.queue.settle()
    shown.app.queue.settle()  # The snapshot is kept before it is drawn.
    assert shown.scene.drawings["fabric"] is not surface
    assert "Paused: iteration 1," in shown.controls.text_shown()
    press(shown, "Stop")
    wait_for_task(shown)
    assert np.array_equal(shown.project.evened.vertices, run.newest.state.vertices)
    assert "You stopped after 1 iterations" in shown.controls.text_shown()


def test_the_map_shows_widths_and_heights_and_moves_no_point(shown: Headless):
    call(shown, shown.project.set_evened, with_wide_rows(shown.project.fabric))
    call(shown, shown.app.refresh)
    maps = {}
    for measure in ("Size", "Width", "Height"):
        shown.controls.set("Colours show", measure)
        drawing = shown.scene.drawings["fabric"]
        assert isinstance(drawing, Surface) and isinstance(drawing.colours, Colours)
        maps[measure] = drawing.colours.index
        assert np.array_equal(drawing.points, shown.project.evened.vertices)
    assert len({index.tobytes() for index in maps.values()}) == 3
    assert maps["Width"].max() > 250  # the wide rows are at the end of the scale
    assert len(np.unique(maps["Height"])) == 1


def test_a_click_at_a_finding_outlines_its_rows_and_the_next_click_removes_the_outline(shown: Headless):
    call(shown, shown.project.set_evened, with_wide_rows(shown.project.fabric))
    call(shown, shown.app.refresh)
    assert "stretched, " in shown.controls.text_shown()
    shown.controls.act("rows", "0")
    lines = shown.scene.drawings["rows"]
    assert isinstance(lines, Lines) and len(lines.segments) > 0
    shown.controls.act("rows", "0")
    assert "rows" not in shown.scene.drawings


def test_a_relaxation_goes_on_while_another_page_is_open_and_is_shown_again(shown: Headless):
    with alone():
        press(shown, START)
        call(shown, shown.app.open_page, "Label")
        call(shown, shown.app.open_page, "Even out")
        assert shown.controls.find("Stop").visible
        call(shown, shown.app.open_page, "Label")
    wait_for_task(shown)
    assert shown.project.evened is not None and "fabric" not in shown.scene.drawings
    call(shown, shown.app.open_page, "Even out")
    shown.controls.find(NEXT)


def test_another_project_gets_no_result_of_the_one_before_even_if_it_was_paused(shown: Headless, tmp_path: Path):
    press(shown, START)
    wait_for_task(shown)
    with alone():
        press(shown, AGAIN)
        press(shown, "Pause")
    call(shown, shown.app.set_project, Project.create(tmp_path / "other"))
    wait_for_task(shown)
    assert shown.project.evened is None and not shown.front.notices
    assert not shown.app.tasks.running


def test_stitches_that_are_edited_meanwhile_get_no_result_of_the_stitches_before(shown: Headless):
    with alone():
        press(shown, START)
        call(shown, shown.project.apply_edit, Edit("change_stitch", {"faces": [30], "stitch": "p"}))
    wait_for_task(shown)
    assert shown.project.evened is None and STALE in shown.notices()


def test_a_new_mesh_relaxation_says_what_it_removes(shown: Headless):
    press(shown, START)
    wait_for_task(shown)
    from tests.app.project.projects import YARNS

    call(shown, shown.project.set_yarns, YARNS, {})
    press(shown, AGAIN)
    wait_for_task(shown)
    assert shown.project.yarns is None and "these were removed: yarns" in shown.notices()


def test_settings_of_another_version_do_not_stop_the_page(shown: Headless):
    call(shown, shown.project.set_settings, "Even out", {"options": {"alpha": 7, "unknown": 1}})
    call(shown, shown.app.open_page, "Even out")
    assert shown.controls.find("Covered part").value == 0.9
