# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Search for whole tiles of plain stitches, which a pattern with increases and decreases needs.

Tiles lie above the tiles of the repeat below if possible. In the gaps between them, for example beside a line of
shaping, new tiles begin.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.courses import right_neighbours
from stitchmesh.patterns.pattern import Pattern
from stitchmesh.patterns.placement.columns import OUTSIDE, Remainder, is_tile, spread_tiles
from stitchmesh.patterns.placement.placement import is_plain, plain_above


class TileFit:
    """The places of a fabric at which a repeat of a pattern can begin."""

    def __init__(self, fabric: StitchMesh, pattern: Pattern, remainder: Remainder) -> None:
        """Follow each wale upwards from each face for as many rows as the pattern has."""
        self._pattern, self._remainder = pattern, remainder
        right, above = right_neighbours(fabric), plain_above(fabric)
        here = np.where(is_plain(fabric), np.arange(fabric.face_count), BORDER)
        beside = np.where(here == BORDER, BORDER, right)
        self._free = np.ones(fabric.face_count, dtype=bool)
        self._joined = np.ones(fabric.face_count, dtype=bool)
        for _ in range(pattern.height):
            self._free &= here != BORDER
            self._joined &= (beside != BORDER) & (right[here] == beside)
            here, beside = (np.where(faces == BORDER, BORDER, above[faces]) for faces in (here, beside))

    def fit(self, faces: IntArray, columns: IntArray, closed: bool) -> IntArray:
        """Return the columns of a course in which a repeat begins.

        Args:
            faces: faces of the course, left to right.
            columns: columns that the row below passes on to these faces.
            closed: whether the course is a ring.
        """
        count = len(faces)
        free = self._free[faces]
        joined = self._joined[faces] & free & np.roll(free, -1)
        joined[-1] &= closed
        kept = ~is_tile(columns) & (columns != OUTSIDE) & free
        kept |= self._continued_tiles(columns, joined)
        result = np.where(kept, columns, OUTSIDE)
        turn = _gap_free_start(kept | ~free, joined) if closed else 0
        order = np.roll(np.arange(count), -turn)
        for gap in _runs((free & ~kept)[order], joined[order]):
            result[order[gap]] = self._fill(len(gap))
        return result

    def _continued_tiles(self, columns: IntArray, joined: np.ndarray) -> np.ndarray:
        """Whether each face belongs to a whole tile whose columns continue from the row below."""
        width, count = self._pattern.width, len(columns)
        consecutive = joined & is_tile(columns) & (np.roll(columns, -1) == columns + 1)
        steps = np.concatenate([[0], np.cumsum(np.concatenate([consecutive, consecutive]))])
        first = np.arange(count)
        whole = is_tile(columns) & (columns % width == 0) & (width <= count)
        reach = np.minimum(first + width - 1, 2 * count)
        whole &= steps[reach] - steps[first] == width - 1
        continued = np.zeros(count, dtype=bool)
        continued[(first[whole][:, None] + np.arange(width)) % count] = True
        return continued

    def _fill(self, count: int) -> IntArray:
        """Return the columns of new tiles in a gap of ``count`` faces."""
        width = self._pattern.width
        tiles = count // width
        if self._remainder == "stretch" and tiles:
            return spread_tiles(tiles, width, count - tiles * width, closed=False)
        columns = np.full(count, OUTSIDE)
        before = (count - tiles * width) // 2
        columns[before : before + tiles * width] = np.arange(tiles * width)
        return columns


def _gap_free_start(taken: np.ndarray, joined: np.ndarray) -> int:
    """Return a place of a ring that no gap crosses, or the first place if one gap is the whole ring."""
    limits = np.flatnonzero(taken | ~np.roll(joined, 1))
    return int(limits[0]) if len(limits) else 0


def _runs(free: np.ndarray, joined: np.ndarray) -> list[IntArray]:
    """Return the runs of free faces that stay adjacent for the height of a tile."""
    places = np.flatnonzero(free)
    breaks = np.flatnonzero((np.diff(places) > 1) | ~joined[places[:-1]]) + 1
    return np.split(places, breaks) if len(places) else []
