# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Parallel lines at equal distances, clipped at the border of a panel.

Line k has the level (k + phase) d across its direction. The border sides that a line crosses, in order along the line,
are in turn where it enters the panel and where it leaves it. This holds for panels with bays, and with holes too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth


@dataclass(frozen=True, eq=False)
class ClippedLines:
    """Pieces of lines within a panel, ascending by line and along the line."""

    line: IntArray
    """Number of the line of each piece, shape (n,)."""
    ends: FloatArray
    """Where each piece begins and ends along its line [cm], shape (n, 2)."""
    border: IntArray
    """Side of the cloth that the line crosses at both ends, shape (n, 2)."""
    part: FloatArray
    """Where on this side, from 0 at its start to 1 at its end, shape (n, 2)."""

    def piece_at(self, line: IntArray, along: FloatArray) -> IntArray:
        """Return the piece that holds each point, -1 if there is none, shape (m,).

        Args:
            line: line of each point, shape (m,).
            along: place along the line [cm], shape (m,).
        """
        if not len(self.line):
            return np.full(len(line), -1)
        low, size = self.ends.min(), max(2.0 * np.ptp(self.ends), 1e-300)
        key = self.line + (self.ends[:, 0] - low) / size
        piece = np.searchsorted(key, line + np.clip((along - low) / size, 0.0, 0.75), side="right") - 1
        held = (
            (piece >= 0) & (self.line[piece] == line) & (along >= self.ends[piece, 0]) & (along <= self.ends[piece, 1])
        )
        return np.where(held, piece, -1)


def clipped_lines(cloth: Cloth, panel: int, axis: int, distance: float, phase: float = 0.5) -> ClippedLines:
    """Clip lines at the border of a panel.

    Args:
        cloth: the cloth.
        panel: number of the panel.
        axis: direction of the lines, 0 along x and 1 along y.
        distance: distance between two lines [cm].
        phase: level of line 0, in distances.
    """
    sides = cloth.border_sides[cloth.panel[cloth.border_sides // 3] == panel]
    start, end = cloth.side_rest[sides, 0], cloth.side_rest[sides, 1]
    levels = [np.ceil(points[:, 1 - axis] / distance - phase).astype(np.int64) for points in (start, end)]
    count = np.abs(levels[1] - levels[0])  # lines k with low < level <= high, so that a common corner counts once
    side = np.repeat(np.arange(len(sides)), count)
    line = np.minimum(*levels)[side] + np.arange(len(side)) - np.repeat(np.cumsum(count) - count, count)
    rise = (end - start)[side, 1 - axis]
    part = np.clip(((line + phase) * distance - start[side, 1 - axis]) / rise, 0.0, 1.0)
    along = start[side, axis] + part * (end - start)[side, axis]
    order = np.lexsort((along, line))
    pairs = order[: len(order) // 2 * 2].reshape(-1, 2)
    return ClippedLines(line[pairs[:, 0]], along[pairs], sides[side[pairs]], part[pairs])
