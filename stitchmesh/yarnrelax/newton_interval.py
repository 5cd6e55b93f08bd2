# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The work of some cells in an interval of Newton's method: judge their states, move, move less, follow the step.

Factors cost several times as much as forces and energies. If the energy rises in a step, a part of the step is
therefore tried before other factors are found. The factors of a step serve for the next ones as long as they hold
(``newton_moves``).
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from stitchmesh.time_limit import check_time
from stitchmesh.yarnrelax.assessment import Assessments, RemainingChange
from stitchmesh.yarnrelax.newton import Newton
from stitchmesh.yarnrelax.simulation import YarnSimulation

TRIES = 3
"""A cell moves less along its step at most this many times, before another step is found."""
NEAR = 1e-3
"""Below this residual, each step has its own factors, unless states of rest are judged twice. Near rest the error of a
step is then a square, also along the softest motions, which no residual shows."""
KEPT = 0.25
"""By the factors of an earlier step, at most this part of the largest change may remain."""


class Ending(Protocol):
    """A relaxation that Newton's method ends (``relaxation_loop``)."""

    simulation: YarnSimulation
    newton: Newton | None
    tolerance: float
    largest_change: float
    last: Assessments
    lists_age: int
    step_scale: NDArray[np.float64]
    stalled: NDArray[np.bool_]
    remaining: list[RemainingChange | None]

    @property
    def at_rest(self) -> NDArray[np.bool_]:
        """Whether each cell is at rest, shape (C,)."""
        ...

    def search_contacts(self) -> None:
        """Make new candidate lists."""

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
    if loop.lists_age:
        loop.search_contacts()
    newton.find_steps(cells, loop.last.residual < loop.tolerance, loop.last.size)
    for cell in np.flatnonzero(cells).tolist():
        loop.remaining[cell] = newton.remaining_change(cell, float(loop.last.size[cell]))
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
        rise = found.energy - loop.last.energy
        for cell in np.flatnonzero(rising).tolist():
            newton.moves.begin_less(cell, float(rise[cell]))
        newton.moves.displace(rising)
        loop.search_contacts()
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
        for cell in np.flatnonzero(cells & balanced & newton.made_whole_steps() & newton.judges_twice).tolist():
            left = newton.remaining_change(cell, float(loop.last.size[cell]))
            loop.remaining[cell] = left if left is not None and left.spacing < KEPT * loop.largest_change else None
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
                loop.search_contacts()
            cells = good
    newton.forget_steps()


def _move(loop: Ending, newton: Newton, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Move some cells along their steps; return which steps were shortened, shape (C,)."""
    if not cells.any():
        return np.zeros_like(cells)
    shortened = newton.move(cells, loop.step_scale)
    for cell in np.flatnonzero(cells).tolist():
        loop.remaining[cell] = None
    loop.search_contacts()
    return shortened
