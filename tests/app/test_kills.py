# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A server or a browser that is killed loses nothing, and comes back where it was."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest

from stitchmesh.app.pages.yarns.page import INTERRUPTED
from stitchmesh.app.project.division import Division
from stitchmesh.app.project.project import Project
from stitchmesh.labeling import label
from stitchmesh.meshrelax import relax_mesh
from tests.app.browser import BrowserWindow
from tests.app.project.projects import LABEL_ALL, mesh_bytes, same
from tests.gallery import ROOT, tube


class AppProcess:
    """The command ``stitchmesh app`` on a project."""

    def __init__(self, folder: Path, port: int = 0) -> None:
        """Start the program, and wait until it listens."""
        home = folder.parent
        self.process = subprocess.Popen(
            [sys.executable, "-m", "stitchmesh", "app", "--project", str(folder), "--port", str(port), "--no-browser"],
            cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            env={**os.environ, "STITCHMESH_PROJECTS": str(home / "projects"), "XDG_STATE_HOME": str(home / "state"),
                 "PYTHONUNBUFFERED": "1"},
        )  # fmt: skip
        self.lines: list[str] = []
        self.address = self._read_address()

    @property
    def port(self) -> int:
        """The port on which it listens."""
        found = re.search(r":(\d+)/", self.address)
        assert found is not None
        return int(found[1])

    def kill(self) -> None:
        """End the process at once, as a power cut would."""
        self.process.kill()
        self.process.wait()

    def terminate(self) -> int:
        """Ask the process to end, and return its exit status."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(timeout=60)

    def output(self) -> str:
        """Return all that the process has printed; it must have ended."""
        assert self.process.stdout is not None
        return "".join([*self.lines, self.process.stdout.read()])

    def _read_address(self) -> str:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(line)
            if (found := re.search(r"open (http://\S+)", line)) is not None:
                return found[1]
        raise AssertionError("the program ended before it listened: " + "".join(self.lines))


@contextmanager
def app_process(folder: Path, port: int = 0) -> Iterator[AppProcess]:
    """Run the program; it is killed at the end if it still runs."""
    running = AppProcess(folder, port)
    try:
        yield running
    finally:
        if running.process.poll() is None:
            running.kill()


@pytest.fixture
def tube_file(tmp_path):
    path = tmp_path / "tube.obj"
    path.write_bytes(mesh_bytes(tmp_path))
    return path


def saved(folder) -> dict[str, Any]:
    """The table of the project that is on disk."""
    return json.loads((folder / "project.json").read_text())


def saved_steps(folder) -> list[str]:
    """The names of the steps of the labeling that are on disk."""
    return [name for name, _ in saved(folder)["work"]["label_steps"]]


@pytest.mark.nightly
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
                window.wait_for_text("Go on: divide into stitches")
                assert second.terminate() == 0  # What was done last is saved at the end.
                assert "Traceback" not in second.output()
    project = Project.open(folder)
    assert same(project.labeled, label(tube(12, 4)))
    project.close()


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
        window.wait_for(lambda: saved(folder)["settings"].get("Yarns", {}).get(INTERRUPTED), "the start is on disk")
        first.kill()
    assert "relaxed" not in saved(folder)["work"]["files"]
    with app_process(folder) as second, closing(BrowserWindow(browser, second.address)) as window:
        window.press("Continue the relaxation")
        window.wait_for(lambda: "relaxed" in saved(folder)["work"]["files"], "the yarns are relaxed")
        assert second.terminate() == 0
    relaxed = Project.open(folder)
    assert relaxed.report["converged"] and relaxed.history[0]["iteration"] == 0
    relaxed.close()
