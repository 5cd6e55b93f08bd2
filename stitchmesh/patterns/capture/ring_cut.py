# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The line on which stacked rings are cut open, so that a tube becomes the tile of a pattern.

The cut runs between stitches from the lowest to the highest ring. It meets each course line between two loops, and no
cable may cross it there. Where a yarn-over lies at the cut, the cut can pass on either side of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.patterns.capture.region_rows import RegionRow


@dataclass(frozen=True, eq=False)
class _Limits:
    """The limits before the faces of a ring, each shape (n,)."""

    bottoms: IntArray
    """Number of bottom sides of the ring before each limit."""
    tops: IntArray
    """Number of top sides of the ring before each limit."""
    low: IntArray
    """Place of each limit on the course line below, counted along the tops of the ring below."""


def cut_rings(fabric: StitchMesh, rings: list[RegionRow]) -> list[RegionRow]:
    """Return stacked rings that all start at one cut, as near to the faces of the lowest numbers as possible.

    Raises:
        ParameterError: decreases and cables leave no such cut.
    """
    limits = [_limits(fabric, ring, rings[number - 1] if number else None) for number, ring in enumerate(rings)]
    free = _free_limits(fabric, rings, limits)
    if not free[0].any():
        raise ParameterError(
            "region: decreases and cables leave no line on which its rings can be cut open; "
            "leave a wale out of each ring, or take fewer rows"
        )
    result: list[RegionRow] = []
    at = None
    for ring, limit, possible in zip(rings, limits, free, strict=True):
        here = np.flatnonzero(possible if at is None else possible & (limit.low == at))
        first = int(here[np.argmin(ring.faces[here])])
        result.append(ring.rolled(first, int(limit.bottoms[first]), int(limit.tops[first])))
        at = int(limit.tops[first]) % len(ring.tops)
    return result


def _limits(fabric: StitchMesh, ring: RegionRow, under: RegionRow | None) -> _Limits:
    bottoms, tops = (np.cumsum(count) - count for count in (fabric.n_bottom[ring.faces], fabric.n_top[ring.faces]))
    turn = 0 if under is None else int(np.argmax(under.tops == ring.below[0]))
    return _Limits(bottoms, tops, (bottoms + turn) % max(len(ring.below), 1))


def _free_limits(fabric: StitchMesh, rings: list[RegionRow], limits: list[_Limits]) -> list[NDArray[np.bool_]]:
    """Return, for each ring, whether a cut may begin below it at each limit and run on to the highest ring."""
    free: list[NDArray[np.bool_]] = []
    open_above = np.ones(len(rings[-1].tops), dtype=bool)
    for number in range(len(rings) - 1, -1, -1):
        ring, limit = rings[number], limits[number]
        line = rings[number - 1].tops if number else ring.below
        possible = open_above[limit.tops % len(ring.tops)] & ~_crossed(fabric, line)[limit.low]
        free.append(possible)
        open_above = np.zeros(len(line), dtype=bool)
        open_above[limit.low[possible]] = True
    return free[::-1]


def _crossed(fabric: StitchMesh, line: IntArray) -> NDArray[np.bool_]:
    """Whether a loop of a cable passes between each top side of a closed course line and its left neighbour."""
    crossed = np.zeros(len(line), dtype=bool)
    shift = np.where(line == BORDER, 0, fabric.cable_shift[line])
    for place in np.flatnonzero(shift > 0).tolist():
        crossed[np.arange(place + 1, place + int(shift[place]) + 1) % len(line)] = True
    return crossed
