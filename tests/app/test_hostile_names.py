# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Names and messages that hold HTML are shown as text on every page, so that no file can run a script in the page."""

from __future__ import annotations

import html

import pytest

from stitchmesh.app.application import App
from stitchmesh.app.front import NullFront
from stitchmesh.app.pages.all_pages import PAGES
from stitchmesh.app.project.project import Project
from stitchmesh.errors import StitchMeshError
from tests.app.project.projects import COARSE, LABEL_ALL, YARNS, mesh_bytes

HOSTILE = "<img src=x onerror=alert(1)>"


@pytest.fixture
def project(tmp_path, monkeypatch):
    monkeypatch.setenv("STITCHMESH_PROJECTS", str(tmp_path / "projects"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    made = Project.create(tmp_path / HOSTILE, HOSTILE)
    made.import_mesh(f"{HOSTILE}.obj", mesh_bytes(tmp_path))
    made.apply_label_step(LABEL_ALL)
    made.divide(COARSE)
    made.set_evened(made.fabric)
    made.set_yarns(YARNS, {})
    for page in PAGES:
        made.set_settings(page, {"path": HOSTILE, "show": HOSTILE, "body": HOSTILE, "selections": {HOSTILE: "hem 1"}})
    return made


@pytest.mark.parametrize("name", PAGES)
def test_names_are_shown_as_text(project, name):
    app = App(project, NullFront())
    try:
        app.open_page(name)
    except StitchMeshError as error:
        app.report(error)
    app.queue.settle()
    for controls in (app.front.navigation, app.controls, app.left_controls):
        for control in controls.made:
            if control.kind in ("html", "markdown"):
                assert "<img src=x" not in control.content, control.content
    app.close()


def test_the_page_project_shows_the_name_as_text(project):
    app = App(project, NullFront())
    app.open_page("Project")
    assert html.escape(HOSTILE) in app.controls.text_shown()
    app.close()
