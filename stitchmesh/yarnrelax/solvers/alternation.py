# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How Newton steps alternate with iterations of the solver.

Far from rest, the limits of moves shorten Newton steps, and the solver then often lowers the energy faster than Newton
steps do. After each shortened step, the solver therefore iterates for as long as the step took, and continues while it
lowers the energy at least as fast. The two methods together thus cost hardly more than twice what the better one would
cost alone.

The sliding stitches of a large piece need many iterations to come to rest. Newton steps there are short or refused,
because their matrix is not the exact Hessian. The solver therefore also continues after these steps.

Several cells take their Newton steps together, in every ``ROUND``-th assessment interval. In the intervals between, a
cell iterates if it would also iterate alone. A cell whose last step was not shortened stands still, because iterations
lead away from the minimum that Newton steps are about to find.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL

STEP_COST = {"cpu": 15, "cuda": 50}
"""Number of iterations that a Newton step of cells, or of a small piece, counts as; it takes about their time."""
COST_OF_THOUSAND, LARGEST_COST = 50, 500
"""Number of iterations that a Newton step of a larger piece counts as, for each thousand control points, because its
factors take longer than an iteration of so many control points; and the largest number."""
ROUND = {"cpu": 1, "cuda": 5}
"""Number of assessment intervals from one Newton step of several cells to the next. On a GPU a step takes hardly longer
for many cells than for a few, and about as long as these intervals."""


class Alternation:
    """The iterations that come before the next Newton step of each cell."""

    def __init__(self, cells: int, device: str = "cpu", step_cost: int = STEP_COST["cpu"]) -> None:
        """Begin with a Newton step of each of ``cells`` cells on a device, ``cpu`` or ``cuda``."""
        self.step_cost = step_cost
        """Number of iterations that a Newton step counts as."""
        self.intervals, self.round = 0, 1 if cells == 1 else ROUND[device]
        """Number of assessment intervals that have begun, and number of intervals from one Newton step to the next."""
        self.follows = np.zeros(cells, dtype=bool)
        """Whether the next Newton step of each cell follows its last one without iterations, shape (C,)."""
        self.descent = np.zeros(cells, dtype=np.int64)
        """Iterations of the solver before the next Newton step of each cell, shape (C,)."""
        self.newton_fall = np.zeros(cells)
        """Relative fall of the energy in the last shortened Newton step of each cell over its cost, shape (C,)."""

    def begin_interval(self, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Begin an interval of some cells; return the cells that do not stand still in it, shape (C,).

        If all of them would stand still, their Newton steps come at once.
        """
        self.intervals += 1
        standing = chosen & self.follows & (self.intervals % self.round != 0)
        if (chosen & ~standing).any():
            return chosen & ~standing
        self.intervals += -self.intervals % self.round
        return chosen

    @property
    def is_step_due(self) -> NDArray[np.bool_]:
        """Whether each cell may take a Newton step in the present interval, shape (C,)."""
        return (self.descent == 0) & (self.intervals % self.round == 0)

    def note_steps(
        self, stepping: NDArray[np.bool_], shortened: NDArray[np.bool_], fall: NDArray[np.float64]
    ) -> None:  # fmt: skip
        """Let the solver iterate after shortened steps of some cells.

        Args:
            stepping: whether each cell took a step, shape (C,).
            shortened: whether each cell took a shortened step that was accepted, or another step after which the solver
                iterates, shape (C,).
            fall: relative fall of the energy in the steps, shape (C,).
        """
        self.follows = (self.follows | stepping) & ~shortened
        self.descent[shortened] = self.step_cost
        self.newton_fall[shortened] = fall[shortened] / self.step_cost

    def note_iterations(self, good: NDArray[np.bool_], bad: NDArray[np.bool_], fall: NDArray[np.float64]) -> None:
        """Count an interval of the solver that was accepted in some cells and not in others.

        Args:
            good: whether each cell was iterated and accepted, shape (C,).
            bad: whether each cell was iterated and not accepted, shape (C,); Newton's method continues with it.
            fall: relative fall of the energy in the interval, shape (C,).
        """
        interval = int(ASSESSMENT_INTERVAL)
        goes_on = (self.newton_fall > 0.0) & (fall > interval * self.newton_fall)
        left = np.maximum(self.descent - interval, np.where(goes_on, interval, 0))
        self.descent = np.where(bad, 0, np.where(good, left, self.descent))
        self.follows &= ~(good | bad)


def alternation_of(model: Model) -> Alternation:
    """Return the alternation for a model before its first Newton step."""
    device = "cuda" if model.device.is_cuda else "cpu"
    points = 0 if model.on_lattice else model.point_count
    cost = int(np.clip(points * COST_OF_THOUSAND // 1000, STEP_COST[device], LARGEST_COST))
    return Alternation(model.cell_count, device, cost)
