# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Yarns in a real browser: generate, relax, pause, step and stop by keys and buttons, pin by a click."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from stitchmesh.app.pages.yarns.page import CONTINUE, GENERATE, RELAX
from stitchmesh.app.project.division import Division
from stitchmesh.app.project.project import Project
from stitchmesh.compute.device import alone
from stitchmesh.io.meshes import write_mesh
from stitchmesh.meshrelax import relax_mesh
from tests.app.pages.test_even_out import uneven_tube, with_wide_rows
from tests.app.pages.yarns.test_yarns_page import MOST, relaxed
from tests.app.project.projects import LABEL_ALL
from tests.app.test_accessibility import faults_in_both_themes

if TYPE_CHECKING:
    from tests.app.browser import Rig

CHOICES = {"quality": "draft", "most_iterations": MOST}


def write_project(folder: Path) -> None:
    """Write a project whose stitches are even."""
    project = Project.create(folder)
    write_mesh(folder / "garment.obj", uneven_tube())
    project.import_mesh("garment.obj", (folder / "garment.obj").read_bytes())
    project.apply_label_step(LABEL_ALL)
    project.divide(Division(stitch_width=1.3))
    assert project.fabric is not None and project.mesh is not None
    project.set_evened(relax_mesh(project.fabric, surface=project.mesh).fabric)
    project.set_settings("Yarns", {"choices": CHOICES})
    project.close()


def generate(rig: Rig) -> None:
    rig.press(GENERATE)
    rig.wait_for(lambda: rig.app.project.yarns is not None, "the yarns are generated")
    rig.settle()


def test_yarns_are_generated_relaxed_paused_stepped_stopped_and_continued(
    tmp_path: Path, app_in_browser: Callable[..., AbstractContextManager[Rig]]
):
    write_project(tmp_path / "project")
    with app_in_browser("Yarns") as rig:
        generate(rig)
        page = rig.app.page
        with alone():  # The relaxation cannot begin before it is paused.
            rig.press(RELAX)
            rig.wait_for(lambda: page._run.live is not None, "the relaxation starts")
            rig.key("p")
            rig.wait_for(lambda: page._run.live.paused, "the key pauses")
        rig.key("n")
        rig.wait_for_text("Paused: iteration 20,")
        rig.press("Step")
        rig.wait_for_text("Paused: iteration 40,")
        rig.press("Stop")
        rig.wait_for(lambda: rig.app.project.relaxed is not None, "the relaxation stops")
        rig.wait_for_text("was stopped after 40 iterations")
        rig.press(CONTINUE)
        rig.wait_for(lambda: rig.app.project.report["iterations"] == MOST, "the relaxation ends")
        assert np.array_equal(rig.app.project.relaxed.points, relaxed(rig.app.project).yarns.points)
        rig.settle()
        rig.browser_page.locator(".js-plotly-plot").first.wait_for()


def test_a_click_pins_the_stitch_under_the_pointer(
    tmp_path: Path, app_in_browser: Callable[..., AbstractContextManager[Rig]]
):
    write_project(tmp_path / "project")
    with app_in_browser("Yarns") as rig:
        generate(rig)
        rig.browser_page.get_by_text("Pins", exact=True).click()
        rig.tick("Pin by clicking")
        rig.settle()
        yarns = rig.app.project.yarns
        rig.click_at(yarns.points[yarns.points[:, 2].argmax()])
        rig.wait_for_text("1 stitch held")
        (face,) = rig.app.page.settings.pins
        centre = yarns.points[yarns.face == face].mean(axis=0)
        assert centre[2] > yarns.points[:, 2].mean()  # it is on the side that is seen
        rig.press("Remove all pins")
        rig.wait_for_text("0 stitches held")


@pytest.mark.nightly
def test_axe_finds_no_fault_on_the_pages_with_results(
    tmp_path: Path, app_in_browser: Callable[..., AbstractContextManager[Rig]]
):
    write_project(tmp_path / "project")
    with app_in_browser("Yarns", size=(1280, 800)) as rig:
        generate(rig)
        rig.press(RELAX)
        rig.wait_for(lambda: rig.app.project.relaxed is not None, "the relaxation ends")
        for group in ("Figures", "Accuracy and edges", "Lengths and forces", "Body", "Pins"):
            rig.browser_page.get_by_text(group, exact=True).click()
        rig.choose("Colours show", "Strain")
        rig.settle()
        assert faults_in_both_themes(rig) == []
        rig.call(lambda: rig.app.project.set_evened(with_wide_rows(rig.app.project.fabric)))
        rig.page_button("Even out")
        rig.wait_for_text("Some rows are uneven")
        rig.browser_page.get_by_text("Settings", exact=True).click()
        rig.settle()
        assert faults_in_both_themes(rig) == []
