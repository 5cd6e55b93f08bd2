# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands that apply patterns."""

from __future__ import annotations

import json

import numpy as np
import pytest

from stitchmesh.cli import main as cli
from stitchmesh.io import read_stitches, write_mesh, write_stitches
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import apply_pattern, read_pattern
from tests.cli.calls import refused
from tests.gallery import tube as coarse_tube
from tests.patterns.fabrics import differing, tube


@pytest.fixture
def fabric(tmp_path):
    path = tmp_path / "fabric.h5"
    write_stitches(path, tube(18, 6))
    return path


def test_a_pattern_is_applied_to_a_file(tmp_path, fabric, capsys):
    made = tmp_path / "made.h5"
    assert cli.main(["pattern", str(fabric), "rib2x2", "-o", str(made), "--remainder", "stretch"]) == 0
    expected = apply_pattern(read_stitches(fabric), read_pattern("rib2x2"), remainder="stretch")
    assert differing(read_stitches(made), expected) == []
    assert capsys.readouterr().out == "2 x 2 rib: 90 of 108 stitches are in the pattern\n"  # all but the cast-on row


def test_what_a_pattern_leaves_out_is_printed(tmp_path, fabric, capsys):
    assert cli.main(["pattern", str(fabric), "rib2x2", "-o", str(tmp_path / "made.h5")]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "2 x 2 rib: 80 of 108 stitches are in the pattern",
        "left out: 10 stitches (rows 1-5, wales 0-1): these loops are left over beside whole repeats of the pattern "
        "and keep their stitches",
    ]


def test_a_pattern_is_applied_around_a_face(tmp_path, fabric):
    made = tmp_path / "made.h5"
    assert cli.main(["pattern", str(fabric), "feather-and-fan", "-o", str(made), "--face", "40"]) == 0
    expected = apply_pattern(read_stitches(fabric), read_pattern("feather-and-fan"), face=40)
    assert differing(read_stitches(made), expected) == []


def test_knit_takes_a_pattern(tmp_path):
    mesh, folder = tmp_path / "tube.obj", tmp_path / "out"
    write_mesh(mesh, coarse_tube(8, 1, radius=2.0, height=3.0))
    words = ["knit", str(mesh), "-o", str(folder), "--stitch-width", "1", "--pattern", "rib1x1", "--no-picture"]
    assert cli.main([*words, "--quality", "draft", "--device", "cpu", "--max-iterations", "20"]) == 0
    stitches = read_stitches(folder / "stitches.h5").stitch
    report = json.loads((folder / "report.json").read_text())["patterns"]
    assert report["seconds"] > 0.0
    (report,) = report["laid"]
    assert report["name"] == "1 x 1 rib" and report["on"] is None
    assert report["faces"] == np.count_nonzero(stitches != Stitch.CAST_ON) > 0
    assert report["left_out"] == []


def test_bad_options_are_errors_before_the_computation(tmp_path, fabric, capsys):
    made = tmp_path / "made.h5"
    assert "did you mean rib3x3 or rib2x2" in refused(capsys, "pattern", fabric, "rib2x3", "-o", made)
    assert "remainder 'crop'" in refused(capsys, "pattern", fabric, "rib2x2", "-o", made, "--remainder", "crop")
    assert "face 999: does not exist" in refused(capsys, "pattern", fabric, "rib2x2", "-o", made, "--face", 999)
    knit = ["knit", tmp_path / "missing.obj", "-o", tmp_path / "out"]
    assert "did you mean rib3x3 or rib2x2" in refused(capsys, *knit, "--pattern", "rib2x3")
    assert "remainder 'crop'" in refused(capsys, *knit, "--pattern-remainder", "crop")
    assert not made.exists() and not (tmp_path / "out").exists()


@pytest.mark.parametrize("suffix", [".knit", ".png"])
def test_a_part_is_captured_as_a_pattern(tmp_path, fabric, capsys, suffix):
    ribbed, own = tmp_path / "ribbed.h5", tmp_path / f"own{suffix}"
    assert cli.main(["pattern", str(fabric), "rib3x3", "-o", str(ribbed)]) == 0
    capsys.readouterr()
    assert cli.main(["capture", str(ribbed), "--on", "rows 1-4", "-o", str(own)]) == 0
    assert capsys.readouterr().out == f"Wrote {own}: 6 loops x 1 rows, one repeat of 18 x 4.\n"
    assert len(read_pattern(own).rows) == 1 and read_pattern(own).width == 6
    assert cli.main(["capture", str(ribbed), "--on", "rows 1-4", "--whole", "-o", str(own)]) == 0
    assert (read_pattern(own).width, read_pattern(own).height) == (18, 4)


def test_a_part_that_is_no_pattern_is_refused_and_nothing_is_written(tmp_path, fabric, capsys):
    own = tmp_path / "own.knit"
    assert "face 0, 1, 2 (+15 more): is cast-on" in refused(capsys, "capture", fabric, "-o", own)
    assert not own.exists()
