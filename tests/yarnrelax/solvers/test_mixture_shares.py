# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Shares of the matrix of Gauss and Newton: in all of a cell, and only where a large piece has negative pivots."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.quality import PRESETS
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.newton import Newton
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.mixture_shares import REACH, MixtureShares
from tests.yarnrelax.stockinette import fabric_of, tube

KALDOR = YarnMaterial.named("kaldor-simulation")
DOUBLE = replace(PRESETS["draft"], precision="float64")


def tube_that_keeps_its_shape(rows: int, stitches: int) -> YarnSimulation:
    shape = KeepShape(fabric_of(rows, stitches, closed=True))
    return YarnSimulation.start(tube(rows, stitches), KALDOR, DOUBLE, device_named("cpu"), [shape])


def test_in_a_large_piece_shares_grow_near_negative_pivots_and_at_last_everywhere() -> None:
    simulation = tube_that_keeps_its_shape(9, 40)
    shares = MixtureShares(simulation.model, local=True)
    points = simulation.state.points.numpy()[: simulation.model.point_count].astype(np.float64)
    shares.grow_near(np.array([300, 301]), points)
    corner = np.asarray(simulation.model.yarns.segment_points)
    away = np.linalg.norm(points - points[100], axis=1)[corner].min(axis=1)
    np.testing.assert_array_equal(shares.of_segments, np.where(away < REACH, 1.0, 0.0))
    assert 0.0 < shares.part[0] < 0.2
    before = shares.part[0]
    while shares.least[0] < 1.0:
        shares.grow_near(np.array([300, 301]), points)
        assert shares.part[0] > before
        before = shares.part[0]
    shares.shrink(np.ones(1, dtype=bool))
    assert not shares.of_segments.any()


def test_the_step_of_a_large_piece_far_from_rest_descends_and_is_not_the_last_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("stitchmesh.yarnrelax.newton.LARGE", 100)  # so that a small one will do
    simulation, every = tube_that_keeps_its_shape(4, 10), np.ones(1, dtype=bool)
    newton = Newton(simulation)
    newton.find_steps(every, ~every, np.ones(1))
    steps = newton.steps
    assert steps.known[0] and steps.work[0] > 0.0 and not steps.exact[0]
    assert newton.remaining_changes(every, np.ones(1))[0] is None
    assert newton.move(every, np.ones(1)).all()  # so that the solver iterates before the next step
    assert not newton.shares.of_segments.any()  # which begins with the exact Hessian
