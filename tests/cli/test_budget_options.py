# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The options --within and --error: what they choose, how they end a run, and what is refused in one line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.budget import plan
from stitchmesh.budget.budget import Budget
from stitchmesh.cli import main as cli
from stitchmesh.cli.budget_options import OUT_OF_TIME
from stitchmesh.io import read_yarns
from stitchmesh.time_limit import TimeLimit
from tests.cli.calls import refused_without_files, run
from tests.counting_clock import CountingClock
from tests.nightly import at_night
from tests.periodic.free_cells import from_generated_yarns

PLAIN = ["--device", "cpu", "--no-picture"]
FREE = ["swatch", "stockinette", "--relax-cell"]


@pytest.fixture
def counted(monkeypatch) -> list[CountingClock]:
    """Let the time of budgets be counted in looks at a clock; return the clocks."""
    clocks: list[CountingClock] = []

    def make(seconds: float, *, reserved: float, began: float) -> TimeLimit:
        clocks.append(CountingClock())
        return TimeLimit(seconds, clocks[-1])

    monkeypatch.setattr(plan, "TimeLimit", make)
    return clocks


def share_of_looks(clocks: list[CountingClock], share: float, *words: object) -> str:
    """Run a command that nothing ends, and return a part of its time in looks at the clock."""
    run(*words, "--within", "10000h")
    return f"{round(share * clocks[-1].looks)}s"


def report_of(folder: Path) -> dict:
    return json.loads((folder / "report.json").read_text())


@pytest.mark.nightly
def test_an_error_tightens_the_rule_and_is_expected_to_be_kept(tmp_path):
    with from_generated_yarns():
        run(*FREE, "--error", "3%", *PLAIN, "-o", tmp_path)
    report = report_of(tmp_path)
    chosen = report["budget"]
    assert chosen["error"] == 0.03 and chosen["expected"]["error"] <= 0.03
    assert chosen["largest_change"] <= 0.015
    assert report["converged"] and report["remaining_change"]["spacing"] < 0.015


@pytest.mark.parametrize(
    ("more", "share"),
    [([], 0.5), *at_night((["--relax-cell", "--relaxation", "frictionless"], 0.9))],
    ids=["given size", "free size"],
)
def test_the_end_by_time_is_said_and_has_the_bits_of_the_end_by_iterations(tmp_path, counted, capsys, more, share):
    """A free repeat relaxes with several samplings, one after another; the end lies in one of the last."""
    words = ["swatch", "garter", "--quality", "standard", *more, *PLAIN]
    a, b = tmp_path / "a", tmp_path / "b"
    time = share_of_looks(counted, share, *words, "-o", tmp_path / "whole")
    assert cli.main([*words, "--within", time, "-o", str(a)]) == OUT_OF_TIME
    assert "Not good: the time was over after" in capsys.readouterr().out
    ended = report_of(a)
    assert ended["out_of_time"] and not ended["converged"] and ended["iterations"] > 0
    run(*words, "--max-iterations", ended["iterations"], "-o", b)
    again = report_of(b)
    assert (again["iterations"], again["residual"]) == (ended["iterations"], ended["residual"])
    one, other = (read_yarns(each / "cell.h5") for each in (a, b))
    np.testing.assert_array_equal(one.points, other.points)


@pytest.mark.nightly
def test_a_garment_that_its_time_ends_is_made_again_by_its_recipe(tmp_path, counted):
    mesh = tmp_path / "square.obj"
    mesh.write_text("v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nf 1 2 3 4\n")
    words = ["knit", str(mesh), "--stitch-width", "1", *PLAIN]
    time = share_of_looks(counted, 0.8, *words, "-o", tmp_path / "whole")
    assert cli.main([*words, "--within", time, "-o", str(tmp_path / "a")]) == OUT_OF_TIME
    ended = report_of(tmp_path / "a")
    assert ended["yarnrelax"]["out_of_time"] and ended["meshrelax"]["converged"]
    assert ended["yarnrelax"]["iterations"] > 0 and ended["quality"] == ended["budget"]["quality"]
    recipe = tmp_path / "a" / "garment.toml"
    assert cli.main(["knit", str(recipe), "--no-picture", "-o", str(tmp_path / "b")]) == 0
    again = report_of(tmp_path / "b")
    assert again["yarnrelax"]["iterations"] == ended["yarnrelax"]["iterations"]
    one, other = (read_yarns(tmp_path / name / "yarns.h5") for name in "ab")
    np.testing.assert_array_equal(one.points, other.points)


def test_yarns_are_relaxed_within_a_time(tmp_path, counted):
    run("swatch", "stockinette", "--quality", "draft", "--max-iterations", "5", *PLAIN, "-o", tmp_path)
    words = ["relax", str(tmp_path / "cell.h5"), "-o", str(tmp_path / "relaxed.h5"), "--report", str(tmp_path / "r"),
             "--quality", "draft", "--device", "cpu"]  # fmt: skip
    time = share_of_looks(counted, 0.5, *words)
    assert cli.main([*words, "--within", time]) == OUT_OF_TIME
    report = report_of(tmp_path / "r")
    assert report["out_of_time"] and f"{report['budget']['within']:g}s" == time


@pytest.mark.nightly
def test_a_stretch_curve_ends_with_the_last_state_at_rest(tmp_path, counted, capsys):
    words = ["stretch", "stockinette", "--course", "0:20%", "--steps", "7", "--quality", "draft", "--device", "cpu"]
    time = share_of_looks(counted, 0.9, *words, "-o", tmp_path / "whole")
    assert cli.main([*words, "--within", time, "-o", str(tmp_path)]) == OUT_OF_TIME
    assert "strains; allow more time" in capsys.readouterr().out
    assert 1 < len((tmp_path / "stretch.csv").read_text().splitlines()) < 8


def test_a_curve_without_one_state_is_refused(tmp_path, counted, capsys):
    words = ["stretch", "stockinette", "--course", "0:20%", "--steps", "3", "--quality", "draft", "--device", "cpu"]
    message = refused_without_files(capsys, tmp_path, *words, "--within", "5s", "-o", tmp_path / "no")
    assert "before one state was at rest" in message


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--within", "0s"], "within: got 0 s; expected a time above zero"),
        (["--within", "soon"], "within: got the text 'soon'; expected a time such as 60s"),
        (["--within", "0.2s"], "are needed for the files; give"),
        (["--error", "0"], "error: got 0; expected an error above zero"),
        (["--error", "1%", "--quality", "draft"], "leave one out"),
        (["--error", "1%", "--max-iterations", "5"], "leave one out"),
        (["--within", "60s", "--explore", "2"], "explore: got --within or --error beside it"),
    ],
)
def test_budgets_that_cannot_be_kept_are_refused_in_one_line(tmp_path, capsys, words, said):
    assert said in refused_without_files(capsys, tmp_path, *FREE, *words, *PLAIN, "-o", tmp_path / "no")


@pytest.mark.nightly
def test_the_library_takes_the_same_budgets():
    made = sm.swatch("stockinette", budget=Budget.of("1h", "3%"), relax_cell=True, device="cpu", progress=False)
    assert made.report["budget"]["expected"]["error"] <= 0.03
    kept = sm.swatch("stockinette", quality="draft", budget=Budget.of("1h"), device="cpu", progress=False)
    assert kept.report["budget"]["quality"] == "draft"
