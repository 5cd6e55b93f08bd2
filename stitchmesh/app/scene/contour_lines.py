# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Lines on a surface along which a function has the same value, at even distances of the value."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray


def contour_segments(points: FloatArray, triangles: IntArray, values: FloatArray, interval: float) -> FloatArray:
    """Return the pieces of the lines in single triangles, shape (n, 2, 3).

    Args:
        points: corners of the triangles [cm], shape (V, 3).
        triangles: corners of each triangle, shape (T, 3).
        values: value of the function at each corner, linear on each triangle, shape (V,).
        interval: difference of the values of neighbouring lines; each line has a multiple of it.
    """
    level = values[triangles] / interval + 1e-7  # With this shift hardly any vertex lies on a line.
    first = np.ceil(level.min(axis=1)).astype(np.int64)
    count = np.maximum(np.floor(level.max(axis=1)).astype(np.int64) - first + 1, 0)
    triangle = np.repeat(np.arange(len(triangles)), count)
    line = first[triangle] + np.arange(len(triangle)) - np.repeat(np.cumsum(count) - count, count)
    ends = [_crossings(points[triangles[triangle]], level[triangle], line, side) for side in range(3)]
    place = np.stack([point for point, _ in ends], axis=1)
    crossed = np.stack([cut for _, cut in ends], axis=1)
    whole = crossed.sum(axis=1) == 2
    return place[whole][crossed[whole]].reshape(-1, 2, 3)


def _crossings(corner: FloatArray, level: FloatArray, line: IntArray, side: int) -> tuple[FloatArray, IntArray]:
    """Return the point at which each line crosses a side of its triangle, shape (n, 3), and whether it does, (n,)."""
    start, end = level[:, side], level[:, (side + 1) % 3]
    cut = (start < line) != (end < line)
    share = np.where(cut, (line - start) / np.where(cut, end - start, 1.0), 0.0)[:, None]
    return corner[:, side] * (1.0 - share) + corner[:, (side + 1) % 3] * share, cut
