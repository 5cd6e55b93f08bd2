# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Rows in a real browser: a border is marked, a tip is put and dragged, and the stitches are knitted."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.app.project.project import Project
from stitchmesh.app.project.shaping import Shaping
from stitchmesh.io.meshes import write_mesh
from stitchmesh.shaping.marks import TimeMark
from tests.app.pages.test_rows_page import triangles_of
from tests.gallery import tube


@pytest.fixture
def opened(app_in_browser, tmp_path):
    """The page Rows on a tube of triangles."""
    write_mesh(tmp_path / "tube.obj", triangles_of(tube(12, 8)))
    project = Project.create(tmp_path / "project")
    project.import_mesh("tube.obj", (tmp_path / "tube.obj").read_bytes())
    project.set_settings("Rows", {"draft": {
        "stitch_width": 1.2, "stitch_height": None, "marks": [], "up": [0.0, 1.0, 0.0], "multiple": 1
    }})  # fmt: skip
    project.close()
    with app_in_browser(page="Rows") as rig:
        rig.settle()
        yield rig


def tip_of(rig) -> np.ndarray:
    (mark,) = rig.app.project.settings("Rows")["draft"]["marks"]
    assert mark["kind"] == "point"
    return np.array(mark["points"][0])


def test_a_tip_is_put_by_a_click_and_dragged_along_the_surface(opened):
    start, middle, end = ([0.0, height, 3.0] for height in (3.0, 4.0, 5.0))
    opened.choose("A click", "puts a tip")
    opened.settle()
    opened.click_at(start)
    put = tip_of(opened)
    assert np.allclose(put, start, atol=0.1)
    opened.drag([put, middle, end])
    assert np.allclose(tip_of(opened), end, atol=0.15)
    opened.key("Control+z")
    opened.settle()
    assert np.allclose(tip_of(opened), put)
    opened.key("x")
    opened.settle()
    assert opened.app.project.settings("Rows")["draft"]["marks"] == []


def test_a_border_is_marked_and_its_rows_are_knitted(opened):
    opened.click_at([0.0, 8.0, 3.0])
    opened.press("Find the stitches")
    opened.press("Knit these rows")
    opened.wait_for(lambda: opened.app.project.fabric is not None, "the stitches are in the project")
    project = opened.app.project
    assert [mark.role for mark in project.shaping.marks] == ["begin"]
    top = tuple(project.shaping.marks[0].points[0])
    assert project.shaping == Shaping(stitch_width=1.2, marks=(TimeMark("border", (top,), "begin"),))
    opened.press("Go on: edit the stitches")
    opened.wait_for_text("Lay a pattern")
