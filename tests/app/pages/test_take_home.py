# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Take home offers six kinds of file in words, and all others under More."""

from __future__ import annotations

from stitchmesh.app.pages.downloads import exports
from stitchmesh.app.pages.take_home import KINDS
from tests.app.pages.headless import call, headless
from tests.app.pages.test_project_page import end_downloads
from tests.app.project.projects import COARSE, LABEL_ALL
from tests.gallery import tube


def test_the_kinds_and_the_rest_are_all_files_of_the_project_and_are_sent(tmp_path):
    with headless(tmp_path, tube(12, 4), "Project") as app:
        app.project.apply_label_step(LABEL_ALL)
        app.project.divide(COARSE)
        app.app.open_page("Take home")
        shown = app.controls.text_shown()
        assert len(KINDS) == 6 and all(title in shown for title, _, _ in KINDS)
        assert shown.count("make the yarns first") == 2  # the two kinds of yarns
        held = {file.name for file in exports(app.project)}
        made = [name for control in app.controls.made for name in held if f'data-value="{name}"' in control.content]
        assert sorted(made) == sorted(held)  # each once
        call(app, lambda: app.controls.act("download", "pattern.pdf"))
        assert "the pattern has no picture" in app.notices()
        end_downloads(app.app)
        name, content = app.front.downloads[-1]
        assert name == "pattern.pdf" and content.startswith(b"%PDF-")
