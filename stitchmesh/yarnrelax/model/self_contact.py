# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Segments of one yarn that do not collide because they are neighbours along the yarn.

Kaldor 2008 excludes only the next segment from collision. This is correct if a segment is as long as the yarn is thick:
two segments collide if the rest length between them is at least a diameter. If segments are shorter, all segments up to
that rest length are excluded, because a straight yarn would otherwise repel itself.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.yarn import YarnSet

UNENDING = 1 << 30
"""Cycle of the segments of a yarn that does not return to its first segment, because it is open or leaves the cell."""


def neighbour_reach(yarns: YarnSet) -> NDArray[np.int64]:
    """Return the number of following segments that do not collide with each segment, shape (S,).

    Raises:
        ParameterError: a closed yarn is more than a thousand times thicker than it is long.
    """
    reach = np.ones(len(yarns.rest_length), dtype=np.int64)
    diameter = 2.0 * yarns.radius
    shortest = np.minimum.reduceat(yarns.rest_length, yarns.segment_start[:-1])
    for yarn in np.flatnonzero(shortest < diameter):
        first, last = yarns.segment_start[yarn], yarns.segment_start[yarn + 1]
        length = float(yarns.rest_length[first:last].sum())
        if yarns.closed[yarn] and diameter[yarn] > 1_000 * length:
            found = f"yarn {yarn}: has a rest length of {length:.3g} cm and is {diameter[yarn]:.3g} cm thick"
            raise ParameterError(f"{found}; take thinner yarn or larger rest lengths")
        reach[first:last] = _reach(yarns.rest_length[first:last], diameter[yarn], closed=bool(yarns.closed[yarn]))
    return np.minimum(reach, UNENDING)


def _reach(lengths: NDArray[np.float64], diameter: float, *, closed: bool) -> NDArray[np.int64]:
    count = len(lengths)
    turns = int(np.ceil(diameter / lengths.sum())) + 1 if closed else 0
    ends = np.cumsum(np.tile(lengths, turns + 1))
    # the rest length between segments i and i + m + 1 is ends[i + m] - ends[i]; the factor allows for rounding
    wanted = ends[:count] + diameter * (1 - 1e-9)
    return np.maximum(np.searchsorted(ends, wanted) - np.arange(count), 1)
