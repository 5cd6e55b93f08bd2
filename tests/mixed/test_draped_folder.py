# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The folder of a run as a result, also while the run goes on."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.mixed.drape import REPORT, Draped, drape
from stitchmesh.mixed.draped_folder import read_draped
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import ClothSection, write_scene
from stitchmesh.run import Run
from stitchmesh.run_control import RunControl, Snapshot
from tests.mixed.small_scene import SWINGING


def test_a_folder_holds_the_run_that_has_ended(tmp_path):
    made = drape(SWINGING, tmp_path)
    made.write(tmp_path)
    found = read_draped(tmp_path)
    assert len(found.frames) == 3
    for frame, other in zip(found.frames, made.frames, strict=True):
        assert np.array_equal(found.yarns_at(frame).points, made.yarns_at(other).points)
        assert np.array_equal(found.shown_at(frame).surface, made.shown_at(other).surface)
    assert found.report["mixed"]["steps"] == made.report["mixed"]["steps"]


def test_a_folder_is_read_while_the_run_goes_on(tmp_path):
    """Scene and region stand there from the beginning; an earlier report does not belong to the run."""
    tmp_path.joinpath(REPORT).write_text('{"mixed": {}}')
    os.utime(tmp_path / REPORT, (0, 0))
    counts = []

    def look(snapshot: Snapshot[Draped]) -> None:
        found = read_draped(tmp_path)
        counts.append(len(found.frames))
        assert found.report == {}

    drape(SWINGING, tmp_path, run=Run(control=RunControl(look, seconds=0.0)))
    # later looks are made less often, because each takes long beside a step of so small a cloth
    assert counts[0] == 1 and len(read_draped(tmp_path).frames) == 3


def test_an_automatic_region_is_that_of_the_run(tmp_path):
    # no compression has to be found here: any error chooses triangles, and the budget holds one with its ring
    made = drape(replace(SWINGING, region=RegionSection(yarns="automatic", nodes=60)), tmp_path)
    found = read_draped(tmp_path).prepared.region
    assert np.array_equal(found.triangle_kind, made.prepared.region.triangle_kind)
    assert np.array_equal(found.vertex_alpha, made.prepared.region.vertex_alpha)


def test_a_folder_that_is_none_of_this_scene_is_refused(tmp_path):
    with pytest.raises(FileError, match=r"scene\.toml"):
        read_draped(tmp_path)
    drape(SWINGING, tmp_path)
    write_scene(tmp_path / "scene.toml", replace(SWINGING, cloth=ClothSection(rectangle=(3.0, 3.0), edge_length=2.0)))
    with pytest.raises(FileError, match="as in the scene beside them"):
        read_draped(tmp_path)
