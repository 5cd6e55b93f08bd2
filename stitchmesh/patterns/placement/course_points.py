# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the loops of a tile of changing counts lie along its course lines.

Wales should lean little and loops be of one width. Over the ends u of the loops of all inner course lines,

    sum over wales (u_above - u_below)^2 + s sum over loops (u_right - u_left - width / loops)^2  ->  min

with the ends of each line, and the first and last line, held. The weight s grows until no loop is narrow.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from stitchmesh.mesh import FloatArray

EVENNESS = 0.25
"""Weight s of even loops at first, against upright wales."""
NARROWEST = 0.4
"""Width of the narrowest loop over the mean of its line."""

Wale = tuple[int, int, int]
"""A line and the places of the ends of a wale edge: on that line, and on the one above."""


def course_points(loops: Sequence[int], wales: Sequence[Wale]) -> list[FloatArray]:
    """Ends of the loops of each course line, from 0 to the number of loops of the first, each shape (loops + 1,).

    Args:
        loops: of each course line from below; the first and the last agree.
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
    """The gradient of weight / 2 (other - one - length)^2."""
    matrix[one, one] += weight
    matrix[other, other] += weight
    matrix[one, other] -= weight
    matrix[other, one] -= weight
    right[one] -= weight * length
    right[other] += weight * length
