# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Names and messages that hold HTML are shown as text on every page, so that no file can run a script in the page."""

from __future__ import annotations

import json
from html.parser import HTMLParser

import pytest

from stitchmesh.app.application import App
from stitchmesh.app.pages.all_pages import PAGES
from stitchmesh.app.pages.edit.palettes import CHOSEN
from stitchmesh.app.project.project import Project
from stitchmesh.errors import StitchMeshError
from stitchmesh.markup import Markup, checked, css_text, joined, markup
from tests.app.null_front import NullFront
from tests.app.project.projects import COARSE, LABEL_ALL, YARNS, mesh_bytes

HOSTILE = "'\"><img src=x onerror=hit()><iframe srcdoc='<script>hit()'><script>hit()`[x](javascript:hit()) {hit()} &lt;"
"""What ends an attribute, an element and a text of markdown or of a template; it may also be the name of a file."""
PATTERN = HOSTILE.replace('"', "'")
"""The same as the name of a pattern."""
TAGS = {"iframe", "script", "a", "object", "embed", "form", "link", "meta", "base"}
"""Elements that no page makes."""


class Harm(HTMLParser):
    """What a piece of HTML shows, and what of it could run a script."""

    def __init__(self, content: str) -> None:
        super().__init__()
        self.found: list[str] = []
        self.texts: list[str] = []
        self.feed(content)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.found += [tag] if tag in TAGS else []
        self.found += [name for name, _ in attrs if name.startswith("on") or name in ("srcdoc", "href")]
        self.found += [value for name, value in attrs if name == "src" and not value.startswith("data:image")]
        self.texts += [value or "" for _, value in attrs]

    def handle_data(self, data):
        self.texts.append(data)


@pytest.fixture
def project(tmp_path, monkeypatch):
    monkeypatch.setenv("STITCHMESH_PROJECTS", str(tmp_path / "projects"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    Project.create(tmp_path / f"other {HOSTILE}", HOSTILE)
    made = Project.create(tmp_path / "project", HOSTILE)
    made.import_mesh(f"{HOSTILE}.obj", mesh_bytes(tmp_path))
    made.apply_label_step(LABEL_ALL)
    made.divide(COARSE)
    made.set_evened(made.fabric)
    made.set_yarns(YARNS, {})
    stage = {"name": HOSTILE, "key": "0", "kept": False, "seconds": 1.0}
    status = {"time": "now", "state": "running", "stage": HOSTILE, "done": 0.5, "seconds": 1.0, "note": HOSTILE,
              "seconds_left": [1.0, 2.0], "stages": [stage], "process": 1, "host": HOSTILE}  # fmt: skip
    (tmp_path / "job").mkdir()
    (tmp_path / "job" / "status.json").write_text(json.dumps(status))
    for page in PAGES:
        kept = {"path": HOSTILE, "show": HOSTILE, "body": f"{HOSTILE}.obj", "selections": {HOSTILE: HOSTILE}}
        made.set_settings(page, kept)
    return made


def pieces(app):
    """Return every piece of HTML that is shown."""
    app.queue.settle()
    every = (control for part in (app.front.navigation, app.controls, app.left_controls) for control in part.made)
    return [control.content for control in every if control.kind == "html"]


def show(app, name):
    try:
        app.open_page(name)
    except StitchMeshError as error:
        app.report(error)


def test_names_are_shown_as_text_on_every_page(project):
    app = App(project, NullFront())
    for name in PAGES:
        show(app, name)
        if name == "View":
            app.controls.set("Path", str(project.folder.parent / "job"))
            app.controls.press("Open path")
        assert [harm for piece in pieces(app) for harm in Harm(piece).found] == [], name
    app.close()


def test_the_name_of_a_project_a_selection_and_a_pattern_is_shown_as_it_is(project):
    app = App(project, NullFront())
    show(app, "Project")
    assert any(HOSTILE in text for piece in pieces(app) for text in Harm(piece).texts)
    show(app, "Edit")
    assert HOSTILE in [text for piece in pieces(app) for text in Harm(piece).texts]
    app.controls.act("tool", "Lay a pattern")
    app.controls.set("Where", "Whole fabric")
    pattern = f'pattern "{PATTERN}"\nsource "me"\nrow 1 RS: k1 p1\nrow 2 WS: k1 p1\n'
    app.controls.send("Pattern from a file", "own.knit", pattern.encode())
    shown = [Harm(piece) for piece in pieces(app)]
    assert f"Preview of {PATTERN}" in [text for harm in shown for text in harm.texts]
    assert [found for harm in shown for found in harm.found] == []
    app.close()


@pytest.mark.nightly
def test_no_script_of_a_name_runs_in_a_browser(project, app_in_browser, tmp_path):
    project.close()
    with app_in_browser() as rig:
        rig.browser_page.evaluate("() => { window.hits = 0; window.hit = () => { window.hits += 1; }; }")
        for name in PAGES:
            rig.call(show, rig.app, name)
            rig.settle()
        rig.call(show, rig.app, "Edit")
        rig.act("tool", "Lay a pattern")
        pattern = tmp_path / "own.knit"
        pattern.write_text(f'pattern "{PATTERN}"\nsource "me"\nrow 1 RS: k1 p1\nrow 2 WS: k1 p1\n')
        rig.choose("Where", "Whole fabric")
        rig.upload(pattern)
        rig.wait_for_text(f"Preview of {PATTERN}")
        found = "document.querySelectorAll('iframe,[onerror],[srcdoc],a[href^=javascript],img[src=x]').length"
        assert rig.browser_page.evaluate(f"() => [window.hits, {found}]") == [0, 0]


def test_a_text_becomes_markup_by_a_template_only():
    bold = markup("<b>{}</b>", HOSTILE)
    assert Harm(bold).found == [] and Harm(bold).texts == [HOSTILE]
    within = markup('<p title="{}" aria-label=\'{}\'></p>', HOSTILE, HOSTILE)
    assert Harm(within).found == [] and Harm(within).texts == [HOSTILE, HOSTILE]
    assert markup("{}{}", bold, bold) == joined([bold, bold]) == bold + bold == f"{bold}{bold}"
    for plain in (f"{bold}", "".join([bold]), bold.upper(), bold[1:], "<p>" + bold, HOSTILE):
        with pytest.raises(TypeError, match="where HTML is shown"):
            checked(plain)
        with pytest.raises(TypeError, match="where HTML is shown"):
            bold + plain
        with pytest.raises(TypeError, match="where HTML is shown"):
            joined([plain])
    assert isinstance(Markup() + bold, Markup) and markup("{}") == "{}"


def test_a_name_in_a_style_sheet_is_numbers():
    assert css_text("k2tog") == "k2tog" and css_text('"]}</') == r"\22 \5d \7d \3c \2f "
    assert "</style><" not in markup(CHOSEN, css_text("</style><img src=x>"))
