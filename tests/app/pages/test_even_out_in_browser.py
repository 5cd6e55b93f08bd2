# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Even out in a real browser: buttons, the map and the list of uneven rows."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from stitchmesh.app.pages.even_out import START
from stitchmesh.app.project.project import Project
from tests.app.pages.test_even_out import DIVISION, evened, uneven_tube, with_wide_rows
from tests.app.project.projects import LABEL_ALL

if TYPE_CHECKING:
    from tests.app.browser import Rig


def write_project(folder: Path) -> None:
    """Write a divided project."""
    from stitchmesh.io.meshes import write_mesh

    project = Project.create(folder)
    write_mesh(folder / "garment.obj", uneven_tube())
    project.import_mesh("garment.obj", (folder / "garment.obj").read_bytes())
    project.apply_label_step(LABEL_ALL)
    project.divide(DIVISION)
    project.close()


@pytest.mark.nightly
def test_one_button_evens_the_stitches_out(tmp_path: Path, app_in_browser: Callable[..., AbstractContextManager[Rig]]):
    write_project(tmp_path / "project")
    with app_in_browser("Even out") as rig:
        rig.press(START)
        rig.wait_for(lambda: rig.app.project.evened is not None, "the stitches are even")
        rig.wait_for_text("of the sides of stitches are within 20 % of the average")
        assert np.array_equal(rig.app.project.evened.vertices, evened(rig.app.project).vertices)


def test_uneven_rows_are_outlined_by_a_click_in_the_list(
    tmp_path: Path, app_in_browser: Callable[..., AbstractContextManager[Rig]]
):
    write_project(tmp_path / "project")
    with app_in_browser("Even out") as rig:
        rig.call(lambda: rig.app.project.set_evened(with_wide_rows(rig.app.project.fabric)))
        rig.call(rig.app.refresh)
        rig.wait_for_text("Some rows are uneven")
        rig.settle()
        before = rig.screenshot()
        rig.act("rows", "0")
        rig.settle()
        assert rig.screenshot() != before
        rig.choose("Colours show", "Width")
        rig.settle()
        rig.key("p")  # no relaxation runs, so that the key has no effect
        rig.settle()
