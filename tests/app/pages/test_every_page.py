# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What holds for each page: help, hints of all controls, and what to do first while the page has nothing to show."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from stitchmesh.app.pages.all_pages import PAGES
from stitchmesh.app.pages.navigation import help_html, help_paragraphs
from tests.app.pages.headless import Headless, headless, on_project
from tests.app.pages.test_even_out import with_wide_rows
from tests.app.project.projects import YARNS, divided_project
from tests.gallery import tube


@pytest.mark.parametrize("page", PAGES)
def test_each_page_has_help_without_marks_of_markdown(page):
    paragraphs = help_paragraphs(page)
    assert paragraphs and all(len(text) > 20 for text in paragraphs)
    assert not any(mark in text for text in paragraphs for mark in ("](", "**", "`", "![", "##"))
    assert f'aria-label="Help on {page}"' in str(help_html(page))


@pytest.fixture(scope="module")
def with_yarns(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Headless]:
    """The application on a project of which all pages have something to show."""
    folder = tmp_path_factory.mktemp("yarns")
    project = divided_project(folder / "project")
    project.set_evened(with_wide_rows(project.fabric))
    project.set_yarns(YARNS, {})
    with pytest.MonkeyPatch.context() as surroundings:
        surroundings.setenv("XDG_STATE_HOME", str(folder / "state"))
        with on_project(project, "Project") as opened:
            yield opened


@pytest.mark.parametrize("page", [page for page in PAGES if page not in ("Swatch", "Outline")])  # These relax at once.
def test_every_control_has_a_hint(with_yarns, page):
    with_yarns.app.open_page(page)
    made = with_yarns.controls.made + with_yarns.front.left_controls.made
    silent = ("html", "group", "plot", "progress")
    assert made and [one.label for one in made if one.kind not in silent and not one.hint] == []


@pytest.mark.parametrize(
    ("page", "has_mesh", "button", "words"),
    [
        ("Label", False, "Go to Project", "Open the page Project"),
        ("Divide", False, "Go to Project", "Open the page Project"),
        ("Divide", True, "Go to Label", "Go back to Label"),
        ("Rows", False, "Go to Project", "Open the page Project"),
        ("Edit", True, "Go to Label", "on the page Divide"),
        ("Even out", True, "Go to Label", "on the page Divide"),  # the faces have no rows yet
        ("Yarns", True, "Go to Label", "on the page Even out"),
        ("Take home", True, "Go to Label", "on the page Divide"),
    ],
)
def test_a_page_with_nothing_to_show_says_what_to_do_first(tmp_path: Path, page, has_mesh, button, words):
    with headless(tmp_path, tube(8, 3) if has_mesh else None, page) as opened:
        assert [control.label for control in opened.controls.made] == [button]
        assert words in opened.front.navigation.text_shown()
        opened.click((0.0, 0.0, 3.0))
        opened.front.listener.camera_moved()
        assert opened.front.notices == []
