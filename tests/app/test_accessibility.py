# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Axe, a checker of accessibility, finds no missing label and no text that is hard to read on any page.

By day ``tests/app/pages/test_in_browser.py`` lets axe look at one page.
"""

from __future__ import annotations

from shutil import copytree
from typing import TYPE_CHECKING

import pytest
from axe_playwright_python.sync_playwright import Axe

from stitchmesh.app.pages.all_pages import PAGES
from stitchmesh.meshrelax import relax_mesh
from tests.app.project.projects import divided_project

if TYPE_CHECKING:
    from tests.app.browser import Rig

RULES = {"runOnly": {"type": "tag", "values": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"]}}


def faults(rig: Rig) -> list[str]:
    """What axe finds on the open page."""
    violations = Axe().run(rig.browser_page, options=RULES).response["violations"]
    return [f"{violation['id']}: {node['html'][:200]}" for violation in violations for node in violation["nodes"]]


def faults_in_both_themes(rig: Rig) -> list[str]:
    """What axe finds on the open page, in light and in dark colours."""
    found = []
    for dark in (False, True):
        rig.call(rig.app.front.set_dark, dark)
        rig.settle()
        found += faults(rig)
    return found


@pytest.fixture(scope="module")
def evened_folder(tmp_path_factory):
    """The folder of a project of which all pages have something to show."""
    project = divided_project(tmp_path_factory.mktemp("evened") / "project")
    project.set_evened(relax_mesh(project.fabric, surface=project.mesh).fabric)
    project.close()
    return project.folder


@pytest.mark.nightly
@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_no_fault_of_ours(app_in_browser, evened_folder, tmp_path, name):
    copytree(evened_folder, tmp_path / "project")
    with app_in_browser(page=name) as rig:
        assert faults_in_both_themes(rig) == []
