# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The solver iterates as long after a shortened Newton step as the step took, and goes on while it is as fast."""

from __future__ import annotations

import numpy as np

from stitchmesh.yarnrelax.solvers.alternation import STEP_COST, Alternation
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL

ALL, NONE = np.ones(1, dtype=bool), np.zeros(1, dtype=bool)
INTERVAL = int(ASSESSMENT_INTERVAL)


def shortened_step(fall: float) -> Alternation:
    alternation = Alternation(1)
    alternation.note_steps(ALL, np.array([fall]))
    return alternation


def test_newton_steps_follow_one_another_as_long_as_they_are_whole() -> None:
    alternation = Alternation(1)
    alternation.note_steps(NONE, np.array([0.1]))
    assert alternation.descent == 0


def test_the_solver_iterates_as_long_as_a_shortened_step_took() -> None:
    alternation, intervals = shortened_step(0.1), 0
    while alternation.descent > 0:
        alternation.note_iterations(ALL, NONE, np.array([0.0]))
        intervals += 1
    assert (intervals - 1) * INTERVAL < STEP_COST <= intervals * INTERVAL


def test_the_solver_goes_on_while_it_lowers_the_energy_as_fast_as_the_step() -> None:
    alternation = shortened_step(1e-4 * STEP_COST)
    for _ in range(5):
        alternation.note_iterations(ALL, NONE, np.array([1.05e-4 * INTERVAL]))
        assert alternation.descent > 0
    alternation.note_iterations(ALL, NONE, np.array([0.95e-4 * INTERVAL]))
    assert alternation.descent == 0


def test_an_interval_that_is_not_accepted_ends_the_descent() -> None:
    alternation = shortened_step(1e-3)
    alternation.note_iterations(NONE, ALL, np.array([np.inf]))
    assert alternation.descent == 0


def test_cells_alternate_independently() -> None:
    alternation = Alternation(3)
    alternation.note_steps(np.array([True, False, True]), np.array([0.1, 0.2, 0.3]))
    assert alternation.descent.tolist() == [STEP_COST, 0, STEP_COST]
    alternation.note_iterations(np.array([True, False, False]), np.array([False, False, False]), np.zeros(3))
    assert alternation.descent.tolist() == [STEP_COST - INTERVAL, 0, STEP_COST]
    assert alternation.newton_fall.tolist() == [0.1 / STEP_COST, 0.0, 0.3 / STEP_COST]
