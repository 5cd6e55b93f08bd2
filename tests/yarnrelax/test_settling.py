# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The estimate of the change that is left of a piece whose relaxation Newton's method does not end, or not yet."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from stitchmesh.compute.device import device_named
from stitchmesh.quality import PRESETS, SLIDE, Precision
from stitchmesh.run import Checkpoints, Run
from stitchmesh.yarnrelax import Relaxation, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.assessment import Assessment, RemainingChange
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.settling import SLOWEST, SPAN, Settling
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.yarnrelax.stockinette import fabric_of, tube

KALDOR = YarnMaterial.named("kaldor-simulation")
YARNS, FABRIC = tube(4, 10), fabric_of(4, 10, closed=True)
PLACES = YARNS.points / float(YARNS.radius.mean())
LAST = 20 * 2**8
CPU = device_named("cpu")


def noted(
    shape: Callable[[float], float], residual: float = 0.0, last: int = LAST
) -> tuple[Settling, RemainingChange | None]:
    """Marks of a piece that grows evenly: its size after n iterations is ``shape(n)`` times that of the start."""
    settling, found, iteration = Settling(YARNS, CPU), None, 20.0
    while round(iteration) <= last:
        now = round(iteration)
        found = settling.note(now, Assessment(residual, {"bend": shape(now)}), PLACES * shape(now))
        iteration *= SPAN
    return settling, found


def test_the_change_left_of_a_decay_by_a_power_is_found() -> None:
    power = 0.5
    # The changes over successive spans have the ratio SPAN^-power, so their sum is the whole change that is left,
    # 0.01 (20 / n)^power, but for the size of 1 to which each change is relative, and for whole iterations.
    _, found = noted(lambda n: 1.0 + 0.01 * (20.0 / n) ** power)
    left = 0.01 * (20.0 / LAST) ** power
    assert found is not None
    assert_allclose([found.spacing, found.energy], left, rtol=0.02)


def test_a_change_that_does_not_become_smaller_is_never_said_to_be_small() -> None:
    _, found = noted(lambda n: 1.0 + 0.01 * np.log2(n))
    assert found is not None
    assert found.spacing > 0.004 * SLOWEST / (1.0 - SLOWEST)  # 0.01 log2(SPAN) = 0.005 over a size of 1.1


def test_forces_that_are_left_bound_the_change_which_is_unknown_before_two_spans() -> None:
    assert noted(lambda n: 1.0, residual=0.003, last=30)[1] is None
    assert noted(lambda n: 1.0, residual=0.003, last=40)[1] == RemainingChange(SLIDE * 0.003, 0.0, 0.0)


def test_marks_survive_a_checkpoint_with_their_bits() -> None:
    settling, found = noted(lambda n: 1.0 + 0.1 / n, residual=1e-5)
    other = Settling(YARNS, CPU)
    other.resume(**settling.arrays())
    assert other.remaining_change() == found
    for mine, others in zip(settling.marks, other.marks, strict=True):
        assert_array_equal(mine.middles, others.middles)


@pytest.fixture
def few_points_are_large(monkeypatch: pytest.MonkeyPatch) -> None:
    """Treat the small tube of these tests as a large piece."""
    monkeypatch.setattr("stitchmesh.yarnrelax.newton.LARGE", 100)


def relaxed_garment(**options: Any) -> Relaxation:
    """A garment that comes to rest before Newton's method begins."""
    options = {"keep_shape": FABRIC, "quality": "draft", "device": "cpu"} | options
    return relax_yarns(YARNS, **options)


@pytest.mark.usefixtures("few_points_are_large")
@pytest.mark.parametrize(("precision", "tolerance", "settles"), [
    ("float64", 0.01, True), ("float64", 1e-4, False), ("float32", 1e-4, True)
])  # fmt: skip
def test_the_exact_step_alone_judges_a_large_piece_where_the_tolerance_asks_for_it(
    precision: Precision, tolerance: float, settles: bool
) -> None:
    """In double precision, whose digits suffice for it."""
    quality = replace(PRESETS["draft"], precision=precision)
    simulation = YarnSimulation.start(YARNS, KALDOR, quality, device_named("cpu"), [KeepShape(FABRIC)])
    loop = RelaxationLoop(simulation, tolerance, 4.0 * tolerance)
    assert loop.newton is not None and (loop.settling is not None) == settles


@pytest.mark.usefixtures("few_points_are_large")
def test_a_garment_comes_to_rest_with_an_estimate_and_a_resumed_one_with_the_same(tmp_path: Path) -> None:
    garment = relaxed_garment()
    left = garment.report["remaining_change"]
    assert garment.report["converged"]
    assert SLIDE * garment.report["residual"] <= left["spacing"] <= PRESETS["draft"].largest_change

    half = garment.report["iterations"] // 2
    short = replace(PRESETS["draft"], max_iterations=half)
    relaxed_garment(quality=short, run=Run(checkpoints=Checkpoints(tmp_path, every=20)))
    resumed = relaxed_garment(run=Run(resume=tmp_path / "checkpoint.smc"))
    assert_array_equal(resumed.yarns.points, garment.yarns.points)
    assert resumed.report["remaining_change"] == garment.report["remaining_change"]
