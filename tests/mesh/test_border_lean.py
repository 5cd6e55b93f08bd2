# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The lean of rows beyond a border where wales converge."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh.border_lean import LEAN_RATE, NARROWING, border_lean, vertex_step

BASE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
SIDES = np.array([[0, 1], [1, 2]])
NORMAL = np.tile([0.0, 0.0, 1.0], (3, 1))


def towards(narrowed: float) -> np.ndarray:
    """Steps by which the first of two stitches becomes narrower by a fraction, and the second wider by the same."""
    return np.array([[narrowed, 1.0, 0.0], [0.0, 1.0, 0.0], [narrowed, 1.0, 0.0]])


@pytest.mark.parametrize("narrowed", [-0.5, 0.0, NARROWING])
def test_rows_that_narrow_by_at_most_the_limit_stay_in_the_plane_of_the_fabric(narrowed):
    step = towards(narrowed)[:2]
    leaning = border_lean(BASE[:2], step, SIDES[:, :1])
    assert leaning == pytest.approx([0.0, 0.0], abs=1e-12)  # The rounding error of 1 - 0.8 - 0.2, times LEAN_RATE = 6.
    assert vertex_step(step, leaning, NORMAL[:2]) == pytest.approx(step, abs=1e-12)


def test_both_ends_of_a_stitch_lean_in_proportion_to_the_narrowing_above_the_limit():
    leaning = border_lean(BASE, towards(0.7), SIDES)
    assert leaning == pytest.approx([LEAN_RATE * (0.7 - NARROWING)] * 2 + [0.0])


def test_steps_keep_their_length_and_lean_in_the_plane_of_step_and_normal():
    step = np.array([[0.0, 2.0, 0.0]])
    leaned = vertex_step(step, np.array([1.0]), NORMAL[:1])
    assert leaned == pytest.approx(np.array([[0.0, np.sqrt(2.0), np.sqrt(2.0)]]))  # The length is 2, at 45 degrees.
