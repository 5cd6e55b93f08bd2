# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Intervals in which some cells take Newton steps: when the steps come, and what is done in them.

Far from rest, the limits of moves shorten Newton steps, and the solver then often lowers the energy faster than Newton
steps do. After each shortened step, the solver therefore iterates for as long as the step took, and continues while it
lowers the energy at least as fast. The two methods together thus cost hardly more than twice what the better one would
cost alone.

The sliding stitches of a large piece need many iterations to come to rest. Newton steps there are short or refused,
because their matrix is not the exact Hessian. The solver therefore also continues after these steps.

Several cells take their Newton steps together, in every ``ROUND``-th assessment interval. In the intervals between, a
cell iterates if it would also iterate alone, and stands still if its step is due. The way of a cell therefore does not
depend on the other cells of its batch.

In an interval the states of the cells are judged, and the cells move, move less, and follow their steps.
Factors cost several times as much as forces and energies. If the energy rises in a step, a part of the step is
therefore tried before other factors are found. The factors of a step serve for the next ones as long as they hold
(``newton_moves``).
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from stitchmesh.time_limit import check_time
from stitchmesh.yarnrelax.assessment import Assessments, RemainingChanges
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.newton import Newton
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL

STEP_COST = {"cpu": 15, "cuda": 50}
"""Number of iterations that a Newton step of cells, or of a small piece, counts as; it takes about their time."""
COST_OF_THOUSAND, LARGEST_COST = 50, 500
"""Number of iterations that a Newton step of a larger piece counts as, for each thousand control points, because its
factors take longer than an iteration of so many control points; and the largest number."""
ROUND = {"cpu": 1, "cuda": 5}
"""Number of assessment intervals from one Newton step of several cells to the next. On a GPU a step takes hardly longer
for many cells than for a few, and about as long as these intervals."""
TRIES = 3
"""A cell moves less along its step at most this many times, before another step is found."""
NEAR = 1e-3
"""Below this residual, each step has its own factors, unless states of rest are judged twice. Near rest the error of a
step is then a square, also along the softest motions, which no residual shows."""
KEPT = 0.25
"""By the factors of an earlier step, at most this part of the largest change may remain."""


class Alternation:
    """The iterations that come before the next Newton step of each cell."""

    def __init__(self, cells: int, device: str = "cpu", step_cost: int = STEP_COST["cpu"]) -> None:
        """Begin with a Newton step of each of ``cells`` cells on a device, ``cpu`` or ``cuda``."""
        self.step_cost = step_cost
        """Number of iterations that a Newton step counts as."""
        self.intervals, self.round = 0, 1 if cells == 1 else ROUND[device]
        """Number of assessment intervals that have begun, and number of intervals from one Newton step to the next."""
        self.descent = np.zeros(cells, dtype=np.int64)
        """Iterations of the solver before the next Newton step of each cell, shape (C,)."""
        self.newton_fall = np.zeros(cells)
        """Relative fall of the energy in the last shortened Newton step of each cell over its cost, shape (C,)."""

    def begin_interval(self, chosen: NDArray[np.bool_], ending: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Begin an interval of some cells; return the cells that do not stand still in it, shape (C,).

        If all of them would stand still, their Newton steps come at once.

        Args:
            chosen: the cells, shape (C,).
            ending: whether each cell takes Newton steps, shape (C,).
        """
        self.intervals += 1
        standing = chosen & ending & (self.descent == 0) & (self.intervals % self.round != 0)
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


def alternation_of(model: Model) -> Alternation:
    """Return the alternation for a model before its first Newton step."""
    device = "cuda" if model.device.is_cuda else "cpu"
    points = 0 if model.on_lattice else model.point_count
    cost = int(np.clip(points * COST_OF_THOUSAND // 1000, STEP_COST[device], LARGEST_COST))
    return Alternation(model.cell_count, device, cost)


class Ending(Protocol):
    """A relaxation that Newton's method ends (``relaxation_loop``)."""

    simulation: YarnSimulation
    newton: Newton | None
    tolerance: float
    largest_change: float
    last: Assessments
    lists_age: NDArray[np.int64]
    step_scale: NDArray[np.float64]
    stalled: NDArray[np.bool_]
    remaining: RemainingChanges

    @property
    def at_rest(self) -> NDArray[np.bool_]:
        """Whether each cell is at rest, shape (C,)."""
        ...

    def search_contacts(self, *, cells: NDArray[np.bool_]) -> None:
        """Make new candidate lists of some cells, shape (C,)."""

    def is_acceptable(self, now: Assessments, allowed: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether the energy of each cell has not risen too far, shape (C,)."""
        ...

    def note(self, cells: NDArray[np.bool_], now: Assessments) -> None:
        """Record the accepted assessments of some cells."""

    def accept(self, cells: NDArray[np.bool_]) -> None:
        """Accept the current states of some cells."""


def judge_and_move(loop: Ending, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Judge the states of some cells, and move the cells that are not at rest along their Newton steps.

    Returns:
        Whether the step of each cell was shortened, shape (C,).
    """
    newton = loop.newton
    if newton is None or not cells.any():
        return np.zeros(len(cells), dtype=bool)
    check_time()
    if (old := cells & (loop.lists_age > 0)).any():
        loop.search_contacts(cells=old)
    newton.find_steps(cells, loop.last.residual < loop.tolerance, loop.last.size)
    loop.remaining = loop.remaining.replaced(cells, newton.remaining_changes(cells, loop.last.size))
    loop.stalled |= newton.count_idle(cells, loop.at_rest)
    return _move(loop, newton, cells & ~(loop.at_rest | loop.stalled))


def move_less(
    loop: Ending, cells: NDArray[np.bool_], found: Assessments, allowed: NDArray[np.float64]
) -> Assessments:  # fmt: skip
    """Let cells whose energy does not fall enough in their moves move less along their steps.

    Args:
        loop: the relaxation.
        cells: the cells, shape (C,).
        found: the assessments at the ends of the moves.
        allowed: rise of the energy of each cell that is accepted [erg], shape (C,).

    Returns:
        The assessments at the ends of the last moves.
    """
    newton = loop.newton
    for _ in range(TRIES if newton is not None else 0):
        assert newton is not None
        moved = cells & ~(loop.at_rest | loop.stalled | newton.leaving)
        rising = moved & ~loop.is_acceptable(found, allowed - newton.moves.enough(moved))
        if not rising.any():
            break
        loop.simulation.restore(rising)
        newton.moves.begin_less(rising, found.energy - loop.last.energy)
        newton.moves.displace(rising)
        loop.search_contacts(cells=rising)
        found = found.replaced(rising, loop.simulation.assess_cells(rising))
    return found


def follow_steps(loop: Ending, cells: NDArray[np.bool_], energy: NDArray[np.float64]) -> None:
    """Take further steps of some cells by the factors of their last ones as long as these hold, and judge by them.

    If a term lags, a balanced state is at rest if, by the factors of a whole exact step, only little change remains. It
    is then renewed and judged again.

    Args:
        loop: the relaxation, which has accepted the ends of the last steps.
        cells: the cells, shape (C,).
        energy: energies of the cells before the last steps [erg], shape (C,).
    """
    newton = loop.newton
    assert newton is not None
    cells = cells & ~loop.at_rest
    while cells.any():
        newton.find_steps_by_kept_factors(cells)
        balanced = loop.last.residual < loop.tolerance
        if newton.judges_twice:
            judged = cells & balanced & newton.moves.last.are_whole
            left = newton.remaining_changes(judged, loop.last.size)
            left = left.forgotten(left.spacing >= KEPT * loop.largest_change)
            loop.remaining = loop.remaining.replaced(judged, left)
        cells = newton.factors_hold(cells, energy - loop.last.energy) & ~loop.at_rest
        if not newton.judges_twice:
            cells &= loop.last.residual > NEAR
        energy = loop.last.energy
        _move(loop, newton, cells)
        if cells.any():
            found = loop.simulation.assess_cells(cells)
            good = cells & loop.is_acceptable(found, newton.allowed_rise(loop.last.size))
            loop.note(good, found)
            loop.accept(good)
            if (cells & ~good).any():
                loop.simulation.restore(cells & ~good)
                loop.search_contacts(cells=cells & ~good)
            cells = good
    newton.forget_steps()


def _move(loop: Ending, newton: Newton, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Move some cells along their steps; return which steps were shortened, shape (C,)."""
    if not cells.any():
        return np.zeros_like(cells)
    shortened = newton.move(cells, loop.step_scale)
    loop.remaining = loop.remaining.forgotten(cells)
    loop.search_contacts(cells=cells)
    return shortened
