# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``outline``: its files hold what the library gives, and bad input is one line and no file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.cli.main import main
from stitchmesh.io import read_stitches
from stitchmesh.periodic.natural_outline import natural_outline
from stitchmesh.render.plots.outline_picture import plot_outline
from tests.cli.calls import refused_without_files


def test_outline_writes_stitches_a_picture_and_the_figures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "out"
    words = ["outline", "garter", "--columns", "6", "--rows", "3", "-o", str(folder)]
    assert main(words) == 0
    expected = natural_outline("garter", columns=6, rows=3)
    written = read_stitches(folder / "stitches.h5")
    np.testing.assert_array_equal(written.vertices, expected.fabric.vertices)
    np.testing.assert_array_equal(written.stretch, expected.fabric.stretch)
    report = json.loads((folder / "report.json").read_text())
    assert report["width"] == expected.width and report["meshrelax"]["converged"]
    assert (folder / "outline.png").stat().st_size > 0
    assert "of plain knit" in capsys.readouterr().out
    assert main(["outline", str(folder / "stitches.h5"), "-o", str(tmp_path / "again")]) == 0


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["gartr"], "not in the library"),
        (["garter", "--columns", "0"], "columns: got 0"),
        (["garter", "--form", "tube", "--columns", "2"], "a round of 2"),
        (["missing.h5", "--form", "tube"], "only a pattern has it"),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(tmp_path: Path, capsys, words: list[str], text: str) -> None:
    assert text in refused_without_files(capsys, tmp_path, "outline", *words, "-o", tmp_path / "out")


def test_the_name_of_a_pattern_is_no_formula(tmp_path: Path) -> None:
    shape = natural_outline("garter", columns=3, rows=2)
    plot_outline(shape, tmp_path / "outline.png", r"$\unknown{$")
    assert (tmp_path / "outline.png").stat().st_size > 0
