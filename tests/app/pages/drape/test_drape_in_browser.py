# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Drape in a real browser: a scene is opened, painted with the mouse, run and looked at frame by frame."""

from __future__ import annotations

import numpy as np
from axe_playwright_python.sync_playwright import Axe

from stitchmesh.app.pages.drape.page import RUN
from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.scene.scene_file import write_scene
from tests.app.test_accessibility import RULES
from tests.mixed.small_scene import SWINGING


def test_a_scene_is_opened_painted_and_run(tmp_path, app_in_browser):
    write_scene(tmp_path / "swinging.toml", SWINGING)
    with app_in_browser("Drape") as rig:
        rig.type("Path", tmp_path / "swinging.toml")
        rig.press("Open path")
        rig.wait_for(lambda: rig.app.page.session.opened is not None, "the scene opens")
        rig.settle()
        session = rig.app.page.session
        rig.choose("A drag", "adds to the region")
        rig.choose("Brush", "Triangle")
        rig.settle()
        mesh = session.opened.mesh
        corner = mesh.vertices[mesh.face_vertex.reshape(-1, 3)].mean(axis=1)
        lowest = int(np.argmin(corner[:, 1]))
        rig.click_at(corner[lowest])
        assert session.opened.scene.region.faces == (lowest,)
        rig.drag([corner[lowest], [1.5, 0.3, 0.0]])
        painted = session.opened.scene.region
        assert len(painted.faces) > 1
        rig.drag([[0.2, 0.2, 0.0], [2.8, 2.7, 0.0]], "Shift")
        assert len(session.opened.marked) > len(painted.faces) + len(SWINGING.region.boxes)
        rig.key("Control+z")
        rig.wait_for(lambda: session.opened.scene.region == painted, "undo")
        rig.press(RUN)
        rig.wait_for(lambda: rig.app.page.run.result is not None, "the run ends")
        rig.wait_for_text("The run has converged")
        rig.settle()
        assert np.array_equal(rig.app.page.run.result.yarns.points, drape(session.opened.scene).yarns.points)
        rig.type("Moment", 0)
        rig.wait_for(lambda: rig.app.page._view.frame.time == 0.0, "the first frame")
        for group in ("Box and selection", "What is held", "Bodies", "Scene", "Save and download"):
            rig.open_group(group)
        rig.settle()
        found = Axe().run(rig.browser_page, options=RULES).response["violations"]
        assert [f"{one['id']}: {node['html'][:200]}" for one in found for node in one["nodes"]] == []
