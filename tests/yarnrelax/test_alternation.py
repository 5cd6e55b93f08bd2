# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The solver iterates as long after a shortened Newton step as the step took, and goes on while it is as fast."""

from __future__ import annotations

import numpy as np

from stitchmesh.yarnrelax.newton_interval import ROUND, STEP_COST, Alternation
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL

ALL, NONE = np.ones(1, dtype=bool), np.zeros(1, dtype=bool)
INTERVAL, COST = int(ASSESSMENT_INTERVAL), STEP_COST["cpu"]


def shortened_step(fall: float) -> Alternation:
    alternation = Alternation(1)
    alternation.note_steps(ALL, ALL, np.array([fall]))
    return alternation


def test_the_solver_iterates_as_long_as_a_shortened_step_took() -> None:
    alternation, intervals = shortened_step(0.1), 0
    while alternation.descent > 0:
        alternation.note_iterations(ALL, NONE, np.array([0.0]))
        intervals += 1
    assert (intervals - 1) * INTERVAL < COST <= intervals * INTERVAL


def test_the_solver_goes_on_while_it_lowers_the_energy_as_fast_as_the_step() -> None:
    alternation = shortened_step(1e-4 * COST)
    for _ in range(5):
        alternation.note_iterations(ALL, NONE, np.array([1.05e-4 * INTERVAL]))
        assert alternation.descent > 0
    alternation.note_iterations(ALL, NONE, np.array([0.95e-4 * INTERVAL]))
    assert alternation.descent == 0


def test_cells_alternate_independently() -> None:
    alternation = Alternation(3)
    alternation.note_steps(np.ones(3, dtype=bool), np.array([True, False, True]), np.array([0.1, 0.2, 0.3]))
    assert alternation.descent.tolist() == [COST, 0, COST]
    alternation.note_iterations(np.array([True, False, False]), np.array([False, False, False]), np.zeros(3))
    assert alternation.descent.tolist() == [max(COST - INTERVAL, 0), 0, COST]
    assert alternation.newton_fall.tolist() == [0.1 / COST, 0.0, 0.3 / COST]


def test_cells_whose_step_is_due_stand_still_until_the_common_step() -> None:
    alternation, every = Alternation(2, "cuda"), np.ones(2, dtype=bool)
    first, none = np.array([True, False]), np.zeros(2, dtype=bool)
    for _ in range(ROUND["cuda"] - 1):
        assert alternation.begin_interval(every, first).tolist() == [False, True]
        assert not alternation.is_step_due.any()
        alternation.note_iterations(~first, none, np.zeros(2))
    assert alternation.begin_interval(every, first).all() and alternation.is_step_due.all()
    # If all cells would stand still, the step comes at once.
    assert alternation.begin_interval(every, every).all() and alternation.is_step_due.all()
