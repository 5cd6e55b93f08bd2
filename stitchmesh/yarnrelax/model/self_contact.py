# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which segments of one yarn do not collide because they follow each other.

The model exempts the next segment only (physics of Kaldor 2008), which is sound while a segment is as long as the yarn
is thick: two segments collide once the rest length between them is at least a diameter. Finer segments are exempt until
it is, or a straight yarn would push itself apart.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.yarn import YarnSet

UNENDING = 1 << 30
"""Cycle of the segments of a yarn that never returns to its first: an open one, or one that leaves the cell."""


def neighbour_reach(yarns: YarnSet) -> NDArray[np.int64]:
    """How many of the segments that follow each segment do not collide with it, shape (S,)."""
    reach = np.ones(len(yarns.rest_length), dtype=np.int64)
    diameter = 2.0 * yarns.radius
    shortest = np.minimum.reduceat(yarns.rest_length, yarns.segment_start[:-1])
    for yarn in np.flatnonzero(shortest < diameter):
        first, last = yarns.segment_start[yarn], yarns.segment_start[yarn + 1]
        reach[first:last] = _reach(yarns.rest_length[first:last], diameter[yarn], closed=bool(yarns.closed[yarn]))
    return np.minimum(reach, UNENDING)


def _reach(lengths: NDArray[np.float64], diameter: float, *, closed: bool) -> NDArray[np.int64]:
    count = len(lengths)
    turns = int(np.ceil(diameter / lengths.sum())) + 1 if closed else 0
    ends = np.cumsum(np.tile(lengths, turns + 1))
    # the rest length between segments i and i + m + 1 is ends[i + m] - ends[i]; the factor forgives rounding
    wanted = ends[:count] + diameter * (1 - 1e-9)
    return np.maximum(np.searchsorted(ends, wanted) - np.arange(count), 1)
