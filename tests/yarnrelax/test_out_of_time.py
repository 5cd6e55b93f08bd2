# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxations that a limit on their time ends: the bits are those of a limit on the iterations."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.quality import PRESETS, Quality
from stitchmesh.reporting.verdict import relaxation_verdict
from stitchmesh.time_limit import TimeLimit, limited_to
from stitchmesh.yarnrelax import Relaxation, RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.newton_interval import STEP_COST
from stitchmesh.yarnrelax.relax import relax_partly
from stitchmesh.yarnrelax.together.relax_cells import relax_cells
from tests.counting_clock import CountingClock
from tests.yarnrelax.stockinette import periodic_patch, tube, woven_cell

DRAFT = PRESETS["draft"]


def limit(seconds: float) -> TimeLimit:
    return TimeLimit(seconds, CountingClock())


def cell(quality: Quality = DRAFT, **given: Any) -> Relaxation:
    """A relaxation that ends by Newton steps."""
    return relax_yarns(periodic_patch(2, 1), quality=quality, device="cpu", cell=RelaxCell(), **given)


def assert_same(one: Relaxation, other: Relaxation) -> None:
    np.testing.assert_array_equal(one.yarns.points, other.yarns.points)
    left_out = {"seconds", "out_of_time"}
    assert {k: v for k, v in one.report.items() if k not in left_out} == {
        k: v for k, v in other.report.items() if k not in left_out
    }


@pytest.fixture(scope="module")
def whole() -> tuple[Relaxation, int]:
    """The relaxation that ends by itself, and the time that is over at its last look at the clock."""
    clock = CountingClock()
    with limited_to(TimeLimit(1e9, clock)):
        relaxed = cell()
    assert relaxed.report["converged"]
    return relaxed, clock.looks  # the first look is the start; the check of linking reserves a second


@pytest.mark.parametrize("share", [0.01, 0.4, 1.0])
def test_the_end_by_time_has_the_bits_of_the_end_by_iterations(whole, share):
    """The looks lie between launches of L-BFGS, and before each Newton step, of which the last one is left out."""
    with limited_to(limit(max(int(share * whole[1]), 1))):
        ended = cell()
    again = cell(replace(DRAFT, max_iterations=max(ended.report["iterations"], 1)))
    assert ended.report["out_of_time"] and not ended.report["converged"] and not ended.report["stopped"]
    assert not again.report["out_of_time"]
    if ended.report["iterations"] > 0:
        assert_same(ended, again)
    assert relaxation_verdict(ended.report).findings[0].kind == "out of time"


def test_time_that_suffices_changes_no_bit(whole):
    assert not whole[0].report["out_of_time"]
    assert_same(whole[0], cell())


def test_the_time_is_read_before_each_newton_step(whole):
    """The last three steps begin with the last three looks."""
    counts = [entry["iteration"] for entry in whole[0].history]
    assert np.all(np.diff(counts[-4:]) == STEP_COST["cpu"])
    for number in (1, 2, 3):
        with limited_to(limit(whole[1] + 1 - number)):
            assert cell().report["iterations"] == counts[-1 - number]


def test_no_time_at_all_returns_the_start():
    yarns = tube(4, 6)
    with limited_to(limit(0.0)):
        ended = relax_yarns(yarns, quality="draft", device="cpu")
    assert ended.report["iterations"] == 0 and ended.report["out_of_time"]
    # the device holds the places in float32
    np.testing.assert_allclose(ended.yarns.points, yarns.points, atol=1e-6 * np.abs(yarns.points).max())


def test_steps_between_changes_of_size_are_not_cut_short():
    yarns, material = tube(4, 6), YarnMaterial.named()
    with limited_to(limit(0.0)):
        limited = relax_partly(yarns, material=material, quality=DRAFT, iterations=40, device="cpu")
    free = relax_partly(yarns, material=material, quality=DRAFT, iterations=40, device="cpu")
    np.testing.assert_array_equal(limited.points, free.points)


def test_all_cells_of_a_batch_end_with_the_time():
    cells = [periodic_patch(1, 1), woven_cell()]
    with limited_to(limit(3)):
        ended = relax_cells(cells, quality="draft", device="cpu")
    rested = relax_cells(cells, quality="draft", device="cpu")
    assert ended.report["converged"] == 0 and rested.report["converged"] == 2
    for given, one, other in zip(cells, ended.cells, rested.cells, strict=True):
        assert one.report["iterations"] < other.report["iterations"]
        assert len(one.yarns.points) == len(given.points) and np.isfinite(one.yarns.points).all()
