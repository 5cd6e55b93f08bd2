# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A server or a browser that is killed loses nothing, and comes back where it was."""

from __future__ import annotations

import json
import os
from contextlib import closing

import pytest

from stitchmesh.app.pages.yarns.page import INTERRUPTED
from stitchmesh.app.project.division import Division
from stitchmesh.app.project.project import Project
from stitchmesh.labeling import label
from stitchmesh.meshrelax import relax_mesh
from tests.app.app_process import app_process
from tests.app.browser import BrowserWindow
from tests.app.project.projects import LABEL_ALL, mesh_bytes, same
from tests.gallery import tube


@pytest.fixture
def tube_file(tmp_path):
    path = tmp_path / "tube.obj"
    path.write_bytes(mesh_bytes(tmp_path))
    return path


def saved_steps(folder) -> list[str]:
    """The names of the steps of the labeling that are on disk."""
    table = json.loads((folder / "project.json").read_text())
    return [name for name, _ in table["work"]["label_steps"]]


def saved_files(folder) -> dict[str, str]:
    """The files of the results that are on disk."""
    return json.loads((folder / "project.json").read_text())["work"]["files"]


def saved_settings(folder) -> dict[str, dict[str, object]]:
    """The settings of the pages that are on disk."""
    return json.loads((folder / "project.json").read_text())["settings"]


def test_a_killed_server_comes_back_where_it_was(browser, tmp_path, tube_file):
    folder = tmp_path / "project"
    with app_process(folder) as first:
        with closing(BrowserWindow(browser, first.address)) as window:
            window.upload(tube_file)
            window.press("Go on: Label")  # The tube is too small for a garment, so that the page Project stays open.
            window.wait_for_text("Label all")
            window.press("Label all")
            window.wait_for(lambda: saved_steps(folder) == ["label_all"], "the step is on disk")
            first.kill()
            with app_process(folder, port=first.port) as second:
                assert second.port == first.port
                window.browser_page.context.request.get(second.address)  # The second program gives it a new token.
                window.press("Undo")  # Playwright waits until the page is connected again and takes clicks.
                window.wait_for(lambda: saved_steps(folder) == [], "the undo is on disk")
                window.press("Redo")
                window.wait_for(lambda: saved_steps(folder) == ["label_all"], "the step is on disk again")
                assert second.terminate() == 0
                assert "Traceback" not in second.output()
    project = Project.open(folder)
    assert same(project.labeled, label(tube(12, 4)))
    project.close()


@pytest.mark.nightly
def test_a_killed_browser_loses_nothing(browser, tmp_path, tube_file):
    folder = tmp_path / "project"
    with app_process(folder, str(tube_file)) as running:
        window = BrowserWindow(browser, running.address)
        window.page_button("Garment")
        window.wait_for_text("Label all")
        window.press("Label all")
        window.wait_for(lambda: saved_steps(folder) == ["label_all"], "the step is on disk")
        window.browser_page.goto("about:blank")  # The connection ends without a word, in the middle of whatever ran.
        window.close()
        with closing(BrowserWindow(browser, running.address)) as again:
            again.wait_for_text("Go on: divide into stitches")
            assert again.faults == []
        assert running.terminate() == 0
        assert "Traceback" not in running.output()


@pytest.mark.nightly
def test_a_relaxation_that_was_killed_goes_on_from_its_checkpoint(browser, tmp_path, tube_file):
    folder = tmp_path / "project"
    project = Project.create(folder)
    project.import_mesh("tube.obj", tube_file.read_bytes())
    project.apply_label_step(LABEL_ALL)
    project.divide(Division(stitch_width=0.7))
    project.set_evened(relax_mesh(project.fabric, surface=project.mesh).fabric)
    project.set_settings("Yarns", {"choices": {"quality": "draft"}})
    project.close()
    with app_process(folder) as first, closing(BrowserWindow(browser, first.address)) as window:
        window.page_button("Garment")
        window.page_button("Yarns")
        window.press("Generate the yarns")
        window.wait_for_text("Not relaxed yet")
        window.press("Relax the yarns")
        window.wait_for((folder / "checkpoint" / "checkpoint.smc").exists, "a checkpoint")
        window.wait_for(lambda: saved_settings(folder).get("Yarns", {}).get(INTERRUPTED), "what is relaxed is on disk")
        first.kill()
    assert "relaxed" not in saved_files(folder)
    with app_process(folder) as second, closing(BrowserWindow(browser, second.address)) as window:
        window.press("Continue the relaxation")
        window.wait_for(lambda: "relaxed" in saved_files(folder), "the yarns are relaxed")
        assert second.terminate() == 0
    relaxed = Project.open(folder)
    assert relaxed.report["converged"] and relaxed.history[0]["iteration"] == 0
    relaxed.close()


@pytest.mark.nightly
def test_what_is_done_last_is_saved_at_the_end(browser, tmp_path, tube_file):
    folder = tmp_path / "project"
    with app_process(folder, str(tube_file)) as running:
        with closing(BrowserWindow(browser, running.address)) as window:
            window.page_button("Garment")
            window.press("Label all")
            window.wait_for_text("Go on: divide into stitches")
        assert running.terminate() == 0
    assert saved_steps(folder) == ["label_all"]


def test_a_second_program_on_a_project_is_refused_and_told_why(tmp_path, tube_file):
    folder = tmp_path / "project"
    with app_process(folder, str(tube_file)) as running:
        with pytest.raises(AssertionError, match="is open in another stitchmesh app"):
            with app_process(folder):
                pass
        assert running.terminate() == 0


@pytest.mark.nightly
def test_a_port_in_use_is_said(tmp_path):
    with app_process(tmp_path / "one") as first:
        with app_process(tmp_path / "two", port=first.port) as second:
            assert second.port > first.port
            assert f"port {first.port} is in use; took {second.port}" in "".join(second.lines)


def test_a_folder_that_cannot_be_written_is_said(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("no folder")
    with pytest.raises(AssertionError, match="cannot be written"):
        with app_process(blocked / "project"):
            pass
    assert os.listdir(tmp_path) == ["file"]

