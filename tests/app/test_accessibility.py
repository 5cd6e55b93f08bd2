# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Axe, a checker of accessibility, finds no missing label and no text that is hard to read on any page."""

from __future__ import annotations

import pytest
from axe_playwright_python.sync_playwright import Axe

from stitchmesh.app.pages.all_pages import PAGES
from tests.app.project.projects import divided_project

RULES = {"runOnly": {"type": "tag", "values": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"]}}


@pytest.mark.parametrize("name", PAGES)
@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_axe_finds_no_fault_of_ours(app_in_browser, tmp_path, name, dark):
    project = divided_project(tmp_path / "project")
    project.set_evened(project.fabric)  # All pages have something to show.
    project.close()
    with app_in_browser(page=name) as rig:
        rig.call(rig.app.front.set_dark, dark)
        rig.settle()
        found = Axe().run(rig.browser_page, options=RULES).response["violations"]
        assert [violation["id"] + ": " + node["html"][:200] for violation in found for node in violation["nodes"]] == []
