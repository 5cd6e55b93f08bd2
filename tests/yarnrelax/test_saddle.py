# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Unstable balances are found and left, in the same bits each time; minima are kept."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from stitchmesh.compute.asking import ask
from stitchmesh.lattice import Lattice
from stitchmesh.periodic.relaxation.prepared_swatch import prepare_swatch
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.collision.budget import STRAIN_UNIT
from stitchmesh.yarnrelax.saddle import GRID, MOVE, STRAIN, leave_saddle, moved, relax_to_minimum
from stitchmesh.yarnrelax.together.relax_together import leave_saddles_together


@cache
def prepared(pattern: str) -> tuple[YarnSet, dict[str, Any]]:
    """Return the whole repeat of a free swatch before it relaxes, and how it relaxes.

    With three contact samples, rounding alone does not take moss stitch out of its balance.
    """
    start = prepare_swatch(pattern, material=None, quality="draft", device="cpu", relax_cell=True, smallest=False)
    quality = replace(start.quality, contact_samples=3, tolerance=PRESETS["draft"].tolerance)
    return start.yarns, {
        "material": start.similar, "quality": quality, "device": "cpu", "cell": start.cell, "terms": start.terms,
    }  # fmt: skip


def test_a_minimum_is_kept() -> None:
    yarns, shared = prepared("stockinette")
    relaxed = relax_yarns(yarns, progress=False, **shared)
    assert leave_saddle(relaxed.yarns, **shared) is None
    np.testing.assert_array_equal(relax_to_minimum(yarns, progress=False, **shared).yarns.points, relaxed.yarns.points)


def test_moss_stitch_leaves_the_balance_in_which_it_stands_upright() -> None:
    yarns, shared = prepared("moss")
    balance = relax_yarns(yarns, progress=False, **shared)
    found = relax_to_minimum(yarns, progress=False, **shared)
    assert balance.report["converged"] and found.report["converged"]
    assert found.report["energy"] < 0.95 * balance.report["energy"]
    assert found.report["iterations"] > balance.report["iterations"]
    assert [entry["iteration"] for entry in found.history] == sorted(entry["iteration"] for entry in found.history)
    assert leave_saddle(found.yarns, **shared) is None


def test_equal_balances_are_left_in_equal_bits() -> None:
    yarns, shared = prepared("moss")
    balance = relax_yarns(yarns, progress=False, **shared).yarns
    first, second = (leave_saddle(balance, **shared) for _ in range(2))
    assert first is not None and second is not None
    np.testing.assert_array_equal(first.points, second.points)
    together = leave_saddles_together([ask(leave_saddle, yarns, **shared) for yarns in (balance, first, balance)])
    assert isinstance(together[0], YarnSet) and isinstance(together[2], YarnSet)
    # rounding may move a coordinate to the next place of the grid
    np.testing.assert_allclose(together[0].points, first.points, rtol=0, atol=1.01 * GRID * first.radius[0])
    np.testing.assert_allclose(together[2].points, first.points, rtol=0, atol=1.01 * GRID * first.radius[0])


def test_a_compressed_yarn_buckles() -> None:
    """A straight yarn that is longer than its period is in balance, and its energy falls when it bends (Euler)."""
    count, period = 16, 4.0
    x = np.arange(count) * period / count
    straight = np.stack([x, np.zeros(count), np.zeros(count)], axis=1)
    yarns = YarnSet(
        points=straight, start=np.array([0, count]), closed=np.array([True]), radius=np.array([0.1]),
        rest_length=np.full(count, 1.02 * period / count), row=np.zeros(count), face=np.full(count, -1),
        part=np.zeros(count), lattice=Lattice(np.array([[period, 0.0, 0.0], [0.0, 3.0, 0.0]])),
        lattice_step=np.array([[1, 0]]),
    )  # fmt: skip
    material = YarnMaterial.named()
    shared: dict[str, Any] = {"material": material, "quality": prepared("stockinette")[1]["quality"], "device": "cpu",
                              "cell": None}  # fmt: skip
    bent = leave_saddle(yarns, **shared)
    assert bent is not None
    assert np.ptp(bent.points[:, 1:], axis=0).max() > 0.0
    # a longer yarn than its period is unstable; a taut one is not
    taut = YarnSet(**{**vars_of(yarns), "rest_length": 0.98 * yarns.lengths})
    assert leave_saddle(taut, **shared) is None
    together = leave_saddles_together([ask(leave_saddle, each, **shared) for each in (taut, yarns)])
    assert together[0] is None and isinstance(together[1], YarnSet)


def vars_of(yarns: YarnSet) -> dict[str, Any]:
    names = ("points", "start", "closed", "radius", "row", "face", "part", "lattice", "lattice_step")
    return {name: getattr(yarns, name) for name in names}


@pytest.mark.parametrize("strain", [0.0, 100.0])
def test_moves_are_bounded(strain: float) -> None:
    yarns = prepared("stockinette")[0]
    assert yarns.lattice is not None
    move = np.random.default_rng(3).normal(size=(len(yarns.points) + 1, 3))
    move[-1] = [strain, 0.0, 0.0]
    found = moved(yarns, move, np.full(len(move), np.inf))
    assert found is not None and found.lattice is not None
    stretch = np.linalg.norm(found.lattice.periods[0]) / np.linalg.norm(yarns.lattice.periods[0]) - 1.0
    assert abs(stretch) <= STRAIN + GRID / float(STRAIN_UNIT)
    if strain == 0.0:
        steps = np.linalg.norm(found.points - yarns.points, axis=1) / yarns.radius.mean()
        assert steps.max() == pytest.approx(MOVE, abs=GRID)


def test_moves_stay_within_the_step_limit() -> None:
    """Yarns that are pressed together are closer to one another than a move is long where there is room."""
    yarns = prepared("stockinette")[0]
    move = np.random.default_rng(3).normal(size=(len(yarns.points) + 1, 3))
    allowed = np.full(len(move), np.inf)
    allowed[5] = 0.01
    found = moved(yarns, move, allowed)
    assert found is not None
    strain = found.lattice.periods @ np.linalg.pinv(yarns.lattice.periods)
    assert np.abs(strain - np.eye(2)).max() < 0.01  # the cell deforms with the move, and hardly
    still = yarns.points @ np.linalg.pinv(yarns.lattice.periods) @ found.lattice.periods
    plane = yarns.points @ np.linalg.pinv(yarns.lattice.periods) @ yarns.lattice.periods
    steps = np.linalg.norm(found.points - (still + yarns.points - plane), axis=1) / yarns.radius.mean()
    assert steps[5] <= 0.01 and 0.0 < steps.max() < MOVE
    allowed[5] = 0.0
    assert moved(yarns, move, allowed) is None


def test_a_cell_of_constant_size_keeps_its_size() -> None:
    yarns, shared = prepared("moss")
    balance = relax_yarns(yarns, progress=False, **shared).yarns
    down = leave_saddle(balance, **(shared | {"cell": RelaxCell(None, None, shear=False)}))
    assert balance.lattice is not None and (down is None or down.lattice is not None)
    if down is not None and down.lattice is not None:
        np.testing.assert_array_equal(down.lattice.periods, balance.lattice.periods)
