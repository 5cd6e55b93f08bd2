# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The application opens pages, passes on events, and turns errors into notices."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.app import application
from stitchmesh.app.application import App
from stitchmesh.app.pages.page import Page
from stitchmesh.app.project.project import Project
from stitchmesh.app.scene.drawing import Lines
from stitchmesh.app.scene.scene import Pick
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.markup import markup
from tests.app.null_front import NullFront


class Plain(Page):
    """A page that notes what happens to it."""

    name = "Label"
    hint = "Click a border."

    def __init__(self, app):
        super().__init__(app)
        self.seen = []

    def build(self):
        self.app.controls.button("Fail", "Fails.", self.fail)
        self.app.scene.show("rows", Lines(np.zeros((1, 2, 3)), (0, 0, 0)))

    def fail(self):
        raise ParameterError("rows: got 0; expected at least 1")

    def picked(self, pick):
        self.seen.append("pick")

    def refresh(self):
        self.seen.append("refresh")

    def leave(self):
        self.seen.append("leave")


class Later(Page):
    """A page that needs something first."""

    name = "Divide"
    hint = "Choose a size."
    needs = "Label"

    def unavailable(self):
        return "Label the mesh first."


@pytest.fixture
def app(tmp_path, monkeypatch):
    monkeypatch.setattr(application, "PAGES", {"Label": Plain, "Divide": Later})
    app = App(Project.create(tmp_path / "hat"), NullFront())
    yield app
    app.close()


def do(app, function, *arguments):
    app.post(function, *arguments)
    app.queue.settle()


def test_an_open_page_has_its_controls_and_drawings_and_gets_events(app):
    do(app, app.open_page, "Label")
    page = app.page
    assert [control.label for control in app.controls.made] == ["Fail"] and list(app.scene.drawings) == ["rows"]
    assert "Click a border." in app.front.navigation.text_shown()
    do(app, app.front.listener.picked, Pick(np.zeros(3), np.ones(3)))
    do(app, app.refresh)
    do(app, app.open_page, "Divide")
    assert page.seen == ["pick", "refresh", "leave"]
    assert [control.label for control in app.controls.made] == ["Go to Label"] and app.scene.drawings == {}


def test_help_and_dark_colours_are_a_click_away_and_colours_are_remembered(app, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    do(app, app.open_page, "Label")
    do(app, app.front.navigation.act, "help", "")
    assert 'aria-label="Help on Label"' in app.front.navigation.text_shown()
    do(app, app.front.navigation.act, "dark", "dark")
    assert app.front.dark and "Light colours" in app.front.navigation.text_shown()
    other = App(Project.create(tmp_path / "sock"), NullFront())
    assert other.front.dark
    other.close()
    do(app, app.open_page, "Divide")
    assert "Help on Divide" in app.front.navigation.text_shown()
    assert "sm-help" not in app.front.navigation.text_shown().split("</style>")[-1]  # help on another page is closed


def test_an_unavailable_page_says_what_to_do_first_and_is_built_as_soon_as_it_is_available(app, monkeypatch):
    do(app, app.open_page, "Divide")
    assert "Label the mesh first." in app.front.navigation.text_shown()
    do(app, app.controls.press, "Go to Label")
    assert isinstance(app.page, Plain)
    do(app, app.open_page, "Divide")
    monkeypatch.setattr(Later, "unavailable", lambda page: None)
    monkeypatch.setattr(Later, "build", lambda page: page.app.controls.html(markup("built")))
    do(app, app.refresh)
    assert app.controls.text_shown() == "built" and "Choose a size." in app.front.navigation.text_shown()
    monkeypatch.setattr(Later, "unavailable", lambda page: "Label the mesh first.")
    do(app, app.refresh)
    assert app.controls.text_shown() == "" and "Label the mesh first." in app.front.navigation.text_shown()


def test_an_error_of_the_library_is_a_notice_and_the_application_lives_on(app):
    do(app, app.open_page, "Label")
    do(app, app.controls.press, "Fail")
    assert app.front.notices == [("Not possible", "rows: got 0; expected at least 1", "error")]
    do(app, app.open_page, "Nowhere")
    assert "expected one of Label, Divide" in app.front.notices[-1][1]


def test_an_error_of_ours_is_a_notice_too_and_is_logged(app, caplog):
    do(app, lambda: {}["missing"])
    title, text, kind = app.front.notices[-1]
    assert (title, kind) == ("Internal error", "error") and "KeyError" in text
    assert "Traceback" in caplog.text


def test_the_navigation_opens_pages_and_marks_the_open_one_and_the_project_remembers_it(app):
    do(app, app.open_page, "Label")
    do(app, app.front.navigation.act, "page", "Divide")
    assert isinstance(app.page, Later)
    shown = app.front.navigation.text_shown()
    assert shown.index('aria-current="page"') > shown.index('data-value="Divide"')
    assert app.last_page() == "Divide"
    do(app, app.front.navigation.act, "section", "Garment")
    assert isinstance(app.page, Later), "a section opens on the page on which it was left"


def test_a_project_that_the_disk_refuses_at_the_end_is_an_error_after_everything_has_ended(tmp_path, monkeypatch):
    app = App(Project.create(tmp_path / "hat"), NullFront())
    closed, ended = app.project.close, []

    def refuse():
        closed()
        raise FileError("project.json: cannot be written (No space left on device)")

    monkeypatch.setattr(app.project, "close", refuse)
    monkeypatch.setattr(app.front, "close", lambda: ended.append(True))
    with pytest.raises(FileError, match="No space left"):
        app.close()
    assert ended == [True]
