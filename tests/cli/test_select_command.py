# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command that lists and draws parts of a fabric, and patterns on selections."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from stitchmesh.io import read_stitches, write_stitches
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.selection import select
from tests.cli.calls import refused_without_files, run
from tests.editing.fabrics import around


@pytest.fixture(scope="module")
def tube(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("fabric") / "tube.h5"
    write_stitches(path, around(12, 6))
    return path


def test_without_a_selection_the_names_are_listed(tube, capsys):
    run("select", tube)
    lines = capsys.readouterr().out.splitlines()
    assert [line.partition(":")[0] for line in lines] == ["hem", "neck", "front", "back", "left", "right", "body"]
    assert lines[0] == "hem: 12 of 72 stitches, in rows 0 to 0"


def test_the_faces_of_selections_are_written(tube, tmp_path, capsys):
    out = tmp_path / "faces.txt"
    run("select", tube, "hem 2", "neck 1", "-o", out)
    fabric = read_stitches(tube)
    assert [int(line) for line in out.read_text().split()] == select(fabric, "hem 2 or neck").tolist()
    np.testing.assert_array_equal(select(fabric, f'file "{out}"'), select(fabric, "hem 2 or neck"))


@pytest.mark.nightly
def test_a_picture_of_selections_has_their_colours(tube, tmp_path):
    run("select", tube, "hem 3", "neck 2", "-o", tmp_path / "picture.png")
    pixels = np.asarray(Image.open(tmp_path / "picture.png").convert("RGB")).astype(int).reshape(-1, 3)
    red, blue = pixels[:, 0] - pixels[:, 2] > 60, pixels[:, 2] - pixels[:, 0] > 60
    assert red.mean() > 0.02 and blue.mean() > 0.02


@pytest.mark.parametrize(
    ("words", "message"),
    [(["hemm"], "'hemm' is unknown; did you mean 'hem'?"), (["stitch p"], "is empty"), (["cuffs 3"], "no such border")],
)
def test_a_selection_that_names_nothing_is_refused_and_nothing_is_written(tube, tmp_path, capsys, words, message):
    assert message in refused_without_files(capsys, tmp_path, "select", tube, *words, "-o", tmp_path / "faces.txt")


def test_a_pattern_lies_on_its_selection(tube, tmp_path):
    out = tmp_path / "rib.h5"
    run("pattern", tube, "rib1x1", "--on", "hem 3", "-o", out)
    made = read_stitches(out)
    assert set(made.row[made.stitch == Stitch.PURL]) == {1, 2}


def test_a_pattern_wider_than_its_region_is_refused_and_nothing_is_written(tube, tmp_path, capsys):
    words = ["pattern", tube, "cable-work", "--on", "front panel 4", "-o", tmp_path / "out.h5"]
    message = refused_without_files(capsys, tmp_path, *words)
    assert "12 columns are more than any first row of the region has" in message
