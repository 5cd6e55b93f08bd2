# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Positions of loops along the course lines of a tile whose rows have different numbers of loops.

Wales should be nearly upright, and the loops of a line should have nearly equal widths. The positions u of the loop
ends on all inner course lines minimise

    sum over wales (u_above - u_below)^2 + s sum over loops (u_right - u_left - width / loops)^2

while the ends of each line, the first line and the last line are fixed. The weight s is increased until no loop is
narrower than ``NARROWEST`` allows.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from stitchmesh.mesh import FloatArray

EVENNESS = 0.25
"""Initial weight s of equal loop widths, relative to upright wales."""
NARROWEST = 0.4
"""Smallest width of a loop, relative to the mean width of the loops of its line."""

Wale = tuple[int, int, int]
"""A wale edge: the course line of its lower end, and the places of its lower and upper ends on their course lines."""


def course_points(loops: Sequence[int], wales: Sequence[Wale]) -> list[FloatArray]:
    """Return the ends of the loops of each course line, in loops of the first line, each of shape (loops + 1,).

    Args:
        loops: number of loops of each course line from below; the first and the last must be equal.
        wales: the wale edges inside the tile.
    """
    evenness = EVENNESS
    while True:
        lines = _least_squares(loops, wales, evenness)
        if all(np.diff(line).min() >= NARROWEST * loops[0] / (len(line) - 1) for line in lines):
            return lines
        evenness *= 4.0


def _least_squares(loops: Sequence[int], wales: Sequence[Wale], evenness: float) -> list[FloatArray]:
    start = np.concatenate([[0], np.cumsum(np.array(loops) + 1)])
    width, last = float(loops[0]), len(loops) - 1
    value = np.concatenate([np.linspace(0.0, width, count + 1) for count in loops])
    free = np.ones(len(value), dtype=bool)
    free[: start[1]] = free[start[last] :] = False
    free[start[:-1]] = free[start[1:] - 1] = False
    matrix, right = np.zeros((len(value), len(value))), np.zeros(len(value))
    for line, low, high in wales:
        _add_spring(matrix, right, start[line] + low, start[line + 1] + high, 0.0, 1.0)
    for line, count in enumerate(loops):
        for place in range(count):
            _add_spring(matrix, right, start[line] + place, start[line] + place + 1, width / count, evenness)
    if free.any():
        known = right[free] - matrix[np.ix_(free, ~free)] @ value[~free]
        value[free] = np.linalg.solve(matrix[np.ix_(free, free)], known)
    return [value[low:high] for low, high in pairwise(start)]


def _add_spring(matrix: FloatArray, right: FloatArray, one: int, other: int, length: float, weight: float) -> None:
    """Add the gradient of the energy weight / 2 (other - one - length)^2 to a linear system."""
    matrix[one, one] += weight
    matrix[other, other] += weight
    matrix[one, other] -= weight
    matrix[other, one] -= weight
    right[one] -= weight * length
    right[other] += weight * length
