# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Room for whole tiles: a pattern of changing counts needs plain stitches under all of a tile.

Tiles stand on those of the repeat below where they can; between them, past a line of shaping say, new ones begin.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.courses import right_neighbours
from stitchmesh.patterns.pattern import Pattern
from stitchmesh.patterns.placement.columns import OUTSIDE, Remainder, is_tile, part
from stitchmesh.patterns.placement.placement import is_plain, plain_above


class TileFit:
    """Where in a fabric a repeat can begin."""

    def __init__(self, fabric: StitchMesh, pattern: Pattern, remainder: Remainder) -> None:
        """Look up as many rows from each face as the pattern has."""
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

    def settle(self, faces: IntArray, columns: IntArray, closed: bool) -> IntArray:
        """Columns of a course in which a repeat begins.

        Args:
            faces: of the course, left to right.
            columns: that the row below hands on.
            closed: whether the course is a ring.
        """
        count = len(faces)
        free = self._free[faces]
        joined = self._joined[faces] & free & np.roll(free, -1)
        joined[-1] &= closed
        kept = ~is_tile(columns) & (columns != OUTSIDE) & free
        kept |= self._standing(columns, joined)
        result = np.where(kept, columns, OUTSIDE)
        turn = _first_wall(kept | ~free, joined) if closed else 0
        order = np.roll(np.arange(count), -turn)
        for gap in _runs((free & ~kept)[order], joined[order]):
            result[order[gap]] = self._fill(len(gap))
        return result

    def _standing(self, columns: IntArray, joined: np.ndarray) -> np.ndarray:
        """Faces of whole tiles whose columns go on from the row below."""
        width, count = self._pattern.width, len(columns)
        steady = joined & is_tile(columns) & (np.roll(columns, -1) == columns + 1)
        steps = np.concatenate([[0], np.cumsum(np.concatenate([steady, steady]))])
        first = np.arange(count)
        whole = is_tile(columns) & (columns % width == 0) & (width <= count)
        reach = np.minimum(first + width - 1, 2 * count)
        whole &= steps[reach] - steps[first] == width - 1
        standing = np.zeros(count, dtype=bool)
        standing[(first[whole][:, None] + np.arange(width)) % count] = True
        return standing

    def _fill(self, count: int) -> IntArray:
        """Columns of new tiles in a gap."""
        width = self._pattern.width
        tiles = count // width
        if self._remainder == "stretch" and tiles:
            return part(tiles, width, count - tiles * width, closed=False)
        columns = np.full(count, OUTSIDE)
        before = (count - tiles * width) // 2
        columns[before : before + tiles * width] = np.arange(tiles * width)
        return columns


def _first_wall(taken: np.ndarray, joined: np.ndarray) -> int:
    """A place of a ring where no gap runs through; its first where one gap is all of it."""
    walls = np.flatnonzero(taken | ~np.roll(joined, 1))
    return int(walls[0]) if len(walls) else 0


def _runs(free: np.ndarray, joined: np.ndarray) -> list[IntArray]:
    """Places of free faces that stay beside one another."""
    places = np.flatnonzero(free)
    breaks = np.flatnonzero((np.diff(places) > 1) | ~joined[places[:-1]]) + 1
    return np.split(places, breaks) if len(places) else []
