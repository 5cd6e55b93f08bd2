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
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import spsolve

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
    if free.any():
        lines = np.array(wales, dtype=np.int64).reshape(-1, 3)
        left = np.concatenate([np.arange(low, high - 1) for low, high in pairwise(start)])
        one = np.concatenate([start[lines[:, 0]] + lines[:, 1], left])
        other = np.concatenate([start[lines[:, 0] + 1] + lines[:, 2], left + 1])
        length = np.concatenate([np.zeros(len(lines)), np.repeat(width / np.array(loops), loops)])
        weight = np.concatenate([np.ones(len(lines)), np.full(len(left), evenness)])
        spring = np.arange(len(one))
        signs = np.repeat([-1.0, 1.0], len(one))
        ends = np.concatenate([one, other])
        change = csr_array((signs, (np.tile(spring, 2), ends)), shape=(len(one), len(value)))
        pull = change.T @ diags_array(weight)
        known = pull @ (length - change[:, ~free] @ value[~free])
        value[free] = spsolve((pull @ change).tocsc()[free][:, free], known[free])
    return [value[low:high] for low, high in pairwise(start)]
