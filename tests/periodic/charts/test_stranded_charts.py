# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Random stranded charts: their numbers, their outcomes, and that all come to rest or have a float that is too long."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from stitchmesh.quality import quality_named
from tests.fuzz import SEED
from tests.gallery import ROOT
from tests.periodic.charts import stranded_charts as charts


def test_a_chart_depends_on_its_number_alone_and_has_two_or_three_colours():
    kinds = set()
    for number in range(120):
        kind, chart = charts.random_chart(1, number)
        kinds.add(kind)
        again = charts.random_chart(1, number)
        assert np.array_equal(chart, again[1]) and again[0] == kind
        assert max(chart.shape) <= charts.LARGEST
        assert 2 <= len(np.unique(chart)) <= 3 and chart.min() >= 0 and chart.max() <= 2
        pattern = charts.pattern_of(chart)
        assert [[cell.yarn for cell in row.cells] for row in pattern.rows] == chart.tolist()
    assert kinds == set(charts.KINDS)
    assert charts.written(np.array([[0, 1], [2, 0]])) == "20/01"


def test_outcomes_are_at_rest_or_a_float_that_is_too_long(monkeypatch):
    drawn = [np.array([[0, 1], [1, 0]]), np.array([[1] + [0] * 8])]
    monkeypatch.setattr(charts, "random_chart", lambda _seed, number: ("even", drawn[number]))
    results = charts.batch(0, [0, 1], quality_named("draft"), "cpu")
    assert [results[0][cell]["outcome"] for cell in ("held", "free")] == ["at rest", "at rest"]
    assert [results[1][cell]["outcome"] for cell in ("held", "free")] == ["refused", "refused"]
    assert all(charts.is_allowed(results[number][cell]) for number in (0, 1) for cell in ("held", "free"))
    assert not charts.is_allowed({"outcome": "refused", "message": "yarn 3: too close"})
    assert not charts.is_allowed({"outcome": "not at rest", "message": None})
    *_, last = charts.table(results)
    assert last == ("all", "free", 2, 1, 1, 0, 0)


@pytest.mark.nightly
def test_charts_of_a_night_come_to_rest_or_have_a_float_that_is_too_long():
    options = ["--device", "cpu", "--count", "60", "--seed", SEED]
    command = [sys.executable, "-m", "tests.periodic.charts.stranded_charts", *options]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr[-2000:]
