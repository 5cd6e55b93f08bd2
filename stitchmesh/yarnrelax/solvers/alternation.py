# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How Newton steps alternate with iterations of the solver.

Far from rest, the limits of moves shorten Newton steps, and then the solver often lowers the energy faster than they
do. After each shortened step, the solver therefore iterates for as long as the step took, and goes on while it lowers
the energy at least as fast. Neither method can cost much more than twice what the better one would cost alone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL

STEP_COST = 50
"""Iterations that a Newton step counts as: it takes about their time in cells of some hundred control points."""


class Alternation:
    """The iterations that come before the next Newton step of each cell."""

    def __init__(self, cells: int) -> None:
        """Begin with a Newton step of each of ``cells`` cells."""
        self.descent = np.zeros(cells, dtype=np.int64)
        """Iterations of the solver before the next Newton step of each cell, shape (C,)."""
        self.newton_fall = np.zeros(cells)
        """Relative fall of the energy in the last shortened Newton step of each cell over ``STEP_COST``, shape (C,)."""

    def note_steps(self, shortened: NDArray[np.bool_], fall: NDArray[np.float64]) -> None:
        """Let the solver iterate after shortened steps of some cells.

        Args:
            shortened: whether each cell took a shortened step that was accepted, shape (C,).
            fall: relative fall of the energy in the steps, shape (C,).
        """
        self.descent[shortened] = STEP_COST
        self.newton_fall[shortened] = fall[shortened] / STEP_COST

    def note_iterations(self, good: NDArray[np.bool_], bad: NDArray[np.bool_], fall: NDArray[np.float64]) -> None:
        """Count an interval of the solver that was accepted in some cells and not in others.

        Args:
            good: whether each cell was iterated and accepted, shape (C,).
            bad: whether each cell was iterated and not accepted; Newton's method goes on with it, shape (C,).
            fall: relative fall of the energy in the interval, shape (C,).
        """
        interval = int(ASSESSMENT_INTERVAL)
        goes_on = (self.newton_fall > 0.0) & (fall > interval * self.newton_fall)
        left = np.maximum(self.descent - interval, np.where(goes_on, interval, 0))
        self.descent = np.where(bad, 0, np.where(good, left, self.descent))
