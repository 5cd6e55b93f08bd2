# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tables of the package, and the choices that they give."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from itertools import pairwise

import pytest

from stitchmesh.budget.budget import Budget
from stitchmesh.budget.plan import LEFT, MORE_ITERATIONS, SETTINGS, Choice, choose, tightened
from stitchmesh.budget.tables import BudgetScene, Expectation, MeasuredRelaxation, expectations, read_tables
from stitchmesh.errors import FileError
from stitchmesh.quality import PRESETS

SCENES = [
    BudgetScene(kind="free cell", stitches=2, name="Stockinette"),
    BudgetScene(kind="given cell", stitches=60),
    BudgetScene(kind="garment", stitches=5000),
]
TIMES = [0.1 * 2.0**k for k in range(20)]
ERRORS = [0.5 * 0.6**k for k in range(20)]


@pytest.mark.parametrize("table", read_tables(), ids=lambda table: table.device)
def test_the_tables_hold_what_a_choice_needs(table):
    assert table.device and table.version
    assert re.match(r"python benchmarks/(budget_tables.py|run.py budget-tables) ", table.command)
    assert table.date == "".join(table.date.split()) and len(table.date.split("-")) == 3
    assert len(table.pace) == 2 and min(table.pace) > 0.0
    for row in table.measurements:
        assert row.setting in SETTINGS
        assert row.stitches >= 1 and row.points >= row.stitches and row.iterations >= 0
        assert row.seconds > 0.0 and (row.error is None or row.error >= 0.0)
    assert {"free cell", "given cell", "garment"} <= {row.kind for row in table.measurements}
    keys = [(row.kind, row.scene, row.setting) for row in table.measurements]
    assert len(set(keys)) == len(keys)


@pytest.mark.parametrize("text", ["", "[{}]"])
def test_tables_that_are_damaged_are_refused(tmp_path, text):
    path = tmp_path / "tables.json"
    path.write_text(text)
    with pytest.raises(FileError, match="install the program again"):
        read_tables(path)


@pytest.mark.parametrize("scene", SCENES, ids=str)
@pytest.mark.parametrize("table", read_tables(), ids=lambda table: table.device)
def test_more_time_never_gives_a_larger_error(table, scene):
    options = expectations(table, scene)
    chosen = [choose(options, Budget(within=time), time).expected.error for time in TIMES]
    assert all(later <= earlier for earlier, later in pairwise(chosen))


@pytest.mark.parametrize("scene", SCENES, ids=str)
@pytest.mark.parametrize("table", read_tables(), ids=lambda table: table.device)
def test_a_smaller_error_is_never_cheaper(table, scene):
    options = expectations(table, scene)
    chosen = [choose(options, Budget(error=error), math.inf) for error in ERRORS]
    costs = [choice.expected.most_seconds for choice in chosen if not choice.doubt]
    assert costs == sorted(costs)
    doubts = [bool(choice.doubt) for choice in chosen]
    assert doubts == sorted(doubts)  # once an error cannot be had, a smaller one cannot either


@pytest.mark.parametrize("scene", SCENES, ids=str)
def test_a_slower_device_is_expected_to_need_as_much_longer(scene):
    table = read_tables()[0]
    for one, slower in zip(expectations(table, scene), expectations(table, scene, 3.0), strict=True):
        assert slower.setting == one.setting and slower.error == one.error
        assert slower.seconds == pytest.approx(3.0 * one.seconds, rel=1e-12)


CHEAP = Expectation(setting="draft", seconds=1.0, most_seconds=2.0, error=0.04)
MIDDLE = Expectation(setting="standard", seconds=4.0, most_seconds=8.0, error=0.008)
FINE = Expectation(setting="reference", seconds=50.0, most_seconds=100.0, error=0.0005)
OPTIONS = [CHEAP, MIDDLE, FINE]


@pytest.mark.parametrize(
    ("within", "error", "setting", "doubt"),
    [
        (1.0, None, "draft", "before rest"),
        (20.0, None, "standard", ""),
        (1000.0, None, "reference", ""),
        (None, 0.01, "standard", ""),
        (None, 1e-4, "reference", "no setting was measured with 0.01%"),
        (20.0, 0.01, "standard", ""),
        (20.0, 0.001, "standard", "0.1% cannot be had in the time: reference may need 100 s"),
    ],
)
def test_choices(within, error, setting, doubt):
    choice = choose(OPTIONS, Budget(within=within, error=error), math.inf if within is None else within)
    assert isinstance(choice, Choice) and choice.expected.setting == setting
    assert doubt in choice.doubt and bool(doubt) == bool(choice.doubt)


def measured(
    scene: str, setting: str = "draft", *, stitches: int = 100, seconds: float = 1.0, error: float | None = 0.01,
    converged: bool = True,
) -> MeasuredRelaxation:  # fmt: skip
    return MeasuredRelaxation(
        kind="garment", scene=scene, setting=setting, stitches=stitches, points=12 * stitches, iterations=100,
        seconds=seconds, error=error, converged=converged,
    )  # fmt: skip


def test_times_of_unknown_scenes_are_scaled_by_their_stitches():
    rows = (
        measured("a", error=0.02), measured("b", seconds=3.0, error=0.04),
        measured("c", stitches=400, seconds=8.0, error=None), measured("d", seconds=99.0, error=0.5, converged=False),
    )  # fmt: skip
    table = replace(read_tables()[0], measurements=rows)
    (found,) = expectations(table, BudgetScene(kind="garment", stitches=200))
    assert (found.seconds, found.most_seconds, found.error) == (4.0, 6.0, 0.04)
    (known,) = expectations(table, BudgetScene(kind="garment", stitches=100, name="a"))
    assert (known.seconds, known.most_seconds, known.error) == (1.0, 1.0, 0.02)
    (unrested,) = expectations(table, BudgetScene(kind="garment", stitches=200, name="d"))
    assert unrested == found
    assert expectations(table, BudgetScene(kind="free cell", stitches=1)) == []


def test_a_setting_that_was_at_rest_in_easy_scenes_only_is_left_out():
    rows = [measured(scene, "standard") for scene in "abcd"]
    rows += [measured(scene, converged=scene in "ab") for scene in "abcd"]
    table = replace(read_tables()[0], measurements=tuple(rows))
    unknown = expectations(table, BudgetScene(kind="garment", stitches=100))
    assert [one.setting for one in unknown] == ["standard"]
    known = expectations(table, BudgetScene(kind="garment", stitches=100, name="a"))
    assert {one.setting for one in known} == {"draft", "standard"}


def test_an_error_tightens_the_stopping_rule_and_never_loosens_it():
    for quality in PRESETS.values():
        assert tightened(quality, 0.5).largest_change == quality.largest_change
        assert tightened(quality, None) == replace(quality, max_iterations=MORE_ITERATIONS * quality.max_iterations)
    assert tightened(PRESETS["standard"], 0.002).largest_change == LEFT * 0.002
