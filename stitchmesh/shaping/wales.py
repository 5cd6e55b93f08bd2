# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Courses on level lines: how many stitches, where, and how two courses are joined to a row of stitches.

The stitches of a course are equally wide. Between a course and the next, wale edges join vertices so that the sum of
their squared lengths is small and few stitches are increases or decreases. The choice is a shortest path through the
pairs of vertices (dynamic programming); increases and decreases cost more beside others of the same row and above
others of earlier rows, so that they spread out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray

SHAPING = 3.0
"""Cost of an increase or a decrease, in squared stitch widths."""
DOUBLE_SHAPING = 12.0
"""Cost of an increase or a decrease by two loops."""
APART = 5
"""If at least this number of stitches lies between two increases or decreases of a row, they cost no more."""
ABOVE = 4.0
"""Cost of an increase or a decrease directly above another one."""
MOVES = ((1, 1), (1, 2), (2, 1), (1, 3), (3, 1))
"""The numbers of loops below and above that a stitch of a row may have."""


@dataclass(frozen=True, eq=False)
class Wales:
    """The wale edges between two courses."""

    below: IntArray
    """Place of the lower end of each wale edge along the course below, ascending, shape (W,)."""
    above: IntArray
    """Place of its upper end along the course above, ascending, shape (W,)."""


def join_courses(below: FloatArray, above: FloatArray, width: float, penalty: FloatArray) -> Wales | None:
    """Choose the wale edges between two courses whose first and last vertices are joined.

    Args:
        below: vertices of the course below [cm], shape (m + 1, 3); for a round, the last one repeats the first.
        above: vertices of the course above [cm], shape (n + 1, 3).
        width: width of a stitch [cm].
        penalty: additional cost of an increase or a decrease at each vertex below, shape (m + 1,).

    Returns:
        The wale edges, from the first to the last vertices; None if the numbers of loops differ too much.
    """
    apart = np.sum((below[:, None, :] - above[None, :, :]) ** 2, axis=2) / width**2
    paths = _Paths(apart, penalty)
    return paths.best()


class _Paths:
    """Costs of the best paths from the first pair of vertices to each pair.

    The state of a path is the number of plain stitches since the last increase or decrease, up to ``APART``.
    """

    def __init__(self, apart: FloatArray, penalty: FloatArray) -> None:
        rows, columns = apart.shape
        self.shape = rows, columns
        self.cost = np.full((rows, APART + 1, columns), np.inf)
        self.move = np.full((rows, APART + 1, columns), -1, dtype=np.int8)
        self.state = np.zeros((rows, APART + 1, columns), dtype=np.int8)
        self.cost[0, APART, 0] = apart[0, 0]
        # Cost of an increase or a decrease directly beside another one.
        self.crowding = 4.0 * (APART - np.arange(APART + 1)) / APART
        for row in range(1, rows):
            self._plain(row)
            self._shaped(row, penalty)
            self.cost[row] += apart[row]

    def _plain(self, row: int) -> None:
        """Extend paths by a plain stitch."""
        before = self.cost[row - 1]
        self.cost[row, 1:, 1:] = before[:-1, :-1]
        self.state[row, 1:] = np.arange(APART)[:, None]
        last = before[APART, :-1]
        stays = last < self.cost[row, APART, 1:]
        self.cost[row, APART, 1:] = np.where(stays, last, self.cost[row, APART, 1:])
        self.state[row, APART, 1:] = np.where(stays, APART, APART - 1)
        self.move[row, 1:, 1:] = 0

    def _shaped(self, row: int, penalty: FloatArray) -> None:
        """Extend paths by an increase or a decrease, which leads to state 0."""
        best = np.full(self.shape[1], np.inf)
        for number, (loops, made) in enumerate(MOVES[1:], start=1):
            if row < loops or made >= self.shape[1] + 1:
                continue
            entered = self.cost[row - loops] + self.crowding[:, None]
            state = entered.argmin(axis=0)
            value = np.full(self.shape[1], np.inf)
            price = (SHAPING if max(loops, made) == 2 else DOUBLE_SHAPING) + penalty[row - loops : row + 1].mean()
            value[made:] = np.take_along_axis(entered, state[None], axis=0)[0, : self.shape[1] - made] + price
            better = value < best
            best = np.where(better, value, best)
            self.move[row, 0] = np.where(better, number, self.move[row, 0])
            shifted = np.zeros(self.shape[1], dtype=np.int8)
            shifted[made:] = state[: self.shape[1] - made]
            self.state[row, 0] = np.where(better, shifted, self.state[row, 0])
        self.cost[row, 0] = best

    def best(self) -> Wales | None:
        """Return the wale edges of the best path to the last pair."""
        row, column = self.shape[0] - 1, self.shape[1] - 1
        state = int(self.cost[row, :, column].argmin())
        if not np.isfinite(self.cost[row, state, column]):
            return None
        pairs = [(row, column)]
        while row > 0:
            loops, made = MOVES[self.move[row, state, column]]
            state = int(self.state[row, state, column])
            row, column = row - loops, column - made
            pairs.append((row, column))
        low, high = np.array(pairs[::-1]).T
        return Wales(low, high)
