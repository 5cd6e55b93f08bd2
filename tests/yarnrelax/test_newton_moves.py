# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Moves along Newton steps: within their limits, less where the energy rises, and whether their factors serve again."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.yarnrelax.model.cell_entries import CellEntries
from stitchmesh.yarnrelax.newton_moves import AS_SAID, CONTRACTION, LESS, Moves, deformations, shortened_motions
from stitchmesh.yarnrelax.solvers.newton_system import NewtonSteps

MOTION, WORK = np.array([[3.0, 4.0, 0.0], [0.0, 0.5, 0.0]]), 2.0
EVERY = np.ones(1, dtype=bool)


def cell_of(points: int) -> CellEntries:
    """The entries of one cell that does not relax."""
    own = np.arange(points)
    return CellEntries(np.zeros(1, dtype=np.int64), own, np.zeros(1, dtype=np.int64), 0 * own, own >= 0)


def steps(length: float, work: float) -> NewtonSteps:
    return NewtonSteps(length * MOTION, np.array([work]), EVERY, EVERY, ~EVERY)


def move(part: float) -> Moves:
    return Moves(steps(1.0, WORK), part * MOTION, np.array([part]))


@pytest.mark.parametrize("curvature", [2.5, 6.0, 14.0])
def test_where_the_energy_is_a_parabola_the_next_move_ends_at_its_minimum(curvature: float) -> None:
    """E(t) = -w t + c t^2 / 2 along the step has its minimum at w / c."""
    first = move(0.9)
    rise = -WORK * first.part + 0.5 * curvature * first.part**2
    second = first.less(cell_of(2), rise)
    assert second.part == pytest.approx(np.clip(WORK / curvature, *(first.part[0] * np.array(LESS))), rel=1e-12)
    np.testing.assert_allclose(second.motion, second.part * MOTION, rtol=1e-12)


def test_factors_serve_again_where_they_converge_or_where_only_the_limit_ended_the_move() -> None:
    def leads_on(last: Moves, length: float, fall: float) -> bool:
        return bool(last.lead_on(cell_of(2), steps(length, 1.0), np.array([fall]))[0])

    whole, part = move(1.0), move(0.5)
    assert leads_on(whole, 0.9 * CONTRACTION, fall=0.0)
    assert not leads_on(whole, 1.1 * CONTRACTION, fall=WORK)
    # the model falls by w p (1 - p / 2) in a part p of the step
    said = WORK * 0.5 * 0.75
    assert leads_on(part, 1.0, fall=1.1 * AS_SAID * said)
    assert not leads_on(part, 1.0, fall=0.9 * AS_SAID * said)


def test_a_motion_is_shortened_by_one_factor_and_points_with_little_room_by_themselves() -> None:
    motion = np.array([[3.0, 4.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0], [0.1, 0.0, 0.0]])
    limit, shortest, own = np.array([1.0, 1.0, 0.01, 1.0]), np.array([0.5]), cell_of(4)
    found, factor = shortened_motions(motion, limit, shortest, own)
    assert factor == pytest.approx(0.2, rel=1e-15)  # 5 over 1; the third counts with a limit of 0.5
    np.testing.assert_allclose(found[[0, 1, 3]], 0.2 * motion[[0, 1, 3]], rtol=1e-12)
    np.testing.assert_allclose(found[2], [0.0, 0.0, 0.01], rtol=1e-12)
    whole, factor = shortened_motions(0.1 * motion, np.ones(4), shortest, own)
    assert factor == 1.0 and np.array_equal(whole, 0.1 * motion)
    assert not shortened_motions(0.0 * motion, limit, shortest, own)[0].any()


def test_places_deform_with_the_strains_of_their_cell() -> None:
    """X' = (1 + a) x + c y and y' = (1 + b) y, for courses along x; a turn of the frame turns the deformation."""
    frame, strain = np.eye(3)[:2], np.array([0.1, -0.2, 0.3])
    (matrix,) = deformations(frame[None], strain[None])
    np.testing.assert_allclose(np.array([2.0, 3.0, 5.0]) @ matrix, [3.1, 2.4, 5.0], rtol=1e-15)
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    both = deformations(np.stack([frame, frame @ turn]), np.stack([strain, strain]))
    np.testing.assert_allclose(both[1], turn.T @ both[0] @ turn, atol=1e-14)  # rounding
