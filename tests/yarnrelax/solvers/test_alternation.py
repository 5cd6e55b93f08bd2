# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The solver iterates as long after a shortened Newton step as the step took, and goes on while it is as fast."""

from __future__ import annotations

import numpy as np

from stitchmesh.yarnrelax.solvers.alternation import Alternation

ALL, NONE = np.ones(1, dtype=bool), np.zeros(1, dtype=bool)


def shortened_step(products: int, fall: float) -> Alternation:
    alternation = Alternation(1)
    alternation.note_steps(ALL, np.array([products]), np.array([fall]))
    return alternation


def test_newton_steps_follow_one_another_as_long_as_they_are_whole() -> None:
    alternation = Alternation(1)
    alternation.note_steps(NONE, np.array([50]), np.array([0.1]))
    assert alternation.descent == 0


def test_the_solver_iterates_as_long_as_a_shortened_step_took() -> None:
    alternation, intervals = shortened_step(50, 0.1), 0
    while alternation.descent > 0:
        alternation.note_iterations(ALL, NONE, np.array([0.0]))
        intervals += 1
    assert intervals == 3  # of 20 iterations, for 50 products


def test_the_solver_goes_on_while_it_lowers_the_energy_as_fast_as_the_step() -> None:
    alternation = shortened_step(10, 1e-3)  # 1e-4 for each product
    for _ in range(5):
        alternation.note_iterations(ALL, NONE, np.array([21e-4]))  # of 20 iterations
        assert alternation.descent > 0
    alternation.note_iterations(ALL, NONE, np.array([19e-4]))
    assert alternation.descent == 0


def test_an_interval_that_is_not_accepted_ends_the_descent() -> None:
    alternation = shortened_step(200, 1e-3)
    alternation.note_iterations(NONE, ALL, np.array([np.inf]))
    assert alternation.descent == 0


def test_cells_alternate_independently() -> None:
    alternation = Alternation(3)
    alternation.note_steps(np.array([True, False, True]), np.array([40, 70, 90]), np.array([0.1, 0.2, 0.3]))
    assert alternation.descent.tolist() == [40, 0, 90]
    alternation.note_iterations(np.array([True, False, False]), np.array([False, False, False]), np.zeros(3))
    assert alternation.descent.tolist() == [20, 0, 90]
    np.testing.assert_allclose(alternation.newton_fall[[0, 2]], [0.1 / 40, 0.3 / 90], rtol=1e-15)
