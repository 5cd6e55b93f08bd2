# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The random stranded charts of the benchmark: their numbers, their outcomes, and how an interrupted run continues."""

from __future__ import annotations

import json
import logging

import numpy as np
import pytest

from benchmarks.measures.swatches import stranded_charts as benchmark
from benchmarks.table import show
from stitchmesh.quality import quality_named


def test_a_chart_depends_on_its_number_alone_and_has_two_or_three_colours():
    kinds = set()
    for number in range(120):
        kind, chart = benchmark.random_chart(1, number)
        kinds.add(kind)
        again = benchmark.random_chart(1, number)
        assert np.array_equal(chart, again[1]) and again[0] == kind
        assert max(chart.shape) <= benchmark.LARGEST
        assert 2 <= len(np.unique(chart)) <= 3 and chart.min() >= 0 and chart.max() <= 2
        pattern = benchmark.pattern_of(chart)
        assert [[cell.yarn for cell in row.cells] for row in pattern.rows] == chart.tolist()
    assert kinds == set(benchmark.KINDS)
    assert benchmark.written(np.array([[0, 1], [2, 0]])) == "20/01"


def test_outcomes_are_at_rest_or_a_float_that_is_too_long(monkeypatch):
    charts = [np.array([[0, 1], [1, 0]]), np.array([[1] + [0] * 8])]
    monkeypatch.setattr(benchmark, "random_chart", lambda _seed, number: ("even", charts[number]))
    results = benchmark.batch(0, [0, 1], quality_named("draft"), "cpu")
    assert [results["0"][cell]["outcome"] for cell in ("held", "free")] == ["at rest", "at rest"]
    assert [results["1"][cell]["outcome"] for cell in ("held", "free")] == ["refused", "refused"]
    assert all(benchmark.is_allowed(results[number][cell]) for number in "01" for cell in ("held", "free"))
    assert not benchmark.is_allowed({"outcome": "refused", "message": "yarn 3: too close"})
    assert not benchmark.is_allowed({"outcome": "not at rest", "message": None})
    *_, last = benchmark.table(results)
    assert last == ("all", "free", 2, 1, 1, 0, 0)


@pytest.fixture
def own_log_level():
    """Restore the level of the log, which a benchmark raises for its own process."""
    logger = logging.getLogger("stitchmesh")
    level = logger.level
    yield
    logger.setLevel(level)


@pytest.mark.nightly
@pytest.mark.usefixtures("own_log_level")
def test_an_interrupted_run_continues_and_ends_as_a_whole_run(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(benchmark, "LARGEST", 3)
    ends = []
    for name, counts in (("whole", [4]), ("continued", [2, 4])):
        for count in counts:
            given = benchmark.Options(count=count, device="cpu", batch=2, out=tmp_path / name)
            assert show(benchmark.stranded_charts(given)) == 0
        ends.append(json.loads((tmp_path / name).read_text()))
    assert ends[0] == ends[1]
    assert capsys.readouterr().err.count("2 of 2 charts") == 2  # the second run relaxes only what is missing
    with pytest.raises(SystemExit, match="holds results of"):
        show(benchmark.stranded_charts(benchmark.Options(seed=2, out=tmp_path / "whole")))
