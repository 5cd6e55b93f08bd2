# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stitch faces of one panel, that is, of one face of the labeled mesh.

Vertices and edges on the sides of a panel are shared with its neighbours; vertices and edges inside belong to the panel
alone. A stitch face is described by its corners and by the numbers of its edges. Faces with a common edge number are
neighbours, independently of their vertices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.mean_value import mean_value_weights
from stitchmesh.tessellate.courses import stitch_widths
from stitchmesh.tessellate.stitch_faces import RowBoundary, StitchFaces


@dataclass(frozen=True)
class DividedPanel:
    """A panel with the vertices of its course lines and the edges on its sides."""

    levels: list[IntArray]
    """Vertices on each course line from left to right; ``levels[j]`` is below course j."""
    bottom: IntArray
    """Edges on the first course line, from left to right."""
    top: IntArray
    """Edges on the last course line, from left to right."""
    left: IntArray
    """Edges on the left wale side, upwards."""
    right: IntArray
    """Edges on the right wale side, upwards."""
    first_row: int
    """Stitch row of the first course."""
    marked: str
    """Wale side at which all increases and decreases are placed, ``"left"`` or ``"right"``; ``""`` for both."""


def add_stitches(panel: DividedPanel, faces: StitchFaces, next_edge: int) -> int:
    """Add the stitch faces of a panel to ``faces``, and return the next free edge number."""
    courses = len(panel.levels) - 1
    below = panel.bottom
    for course in range(courses):
        loops_above = len(panel.levels[course + 1]) - 1
        above = panel.top if course == courses - 1 else np.arange(next_edge, next_edge + loops_above)
        next_edge += 0 if course == courses - 1 else loops_above
        next_edge = _add_course(panel, course, below, above, faces, next_edge)
        below = above
    return next_edge


def _add_course(
    panel: DividedPanel, course: int, below: IntArray, above: IntArray, faces: StitchFaces, next_edge: int
) -> int:
    """Add the stitch faces of one course, and return the next free edge number."""
    narrow = min(len(below), len(above)) or max(len(below), len(above))
    wide = max(len(below), len(above))
    widths = stitch_widths(narrow, wide, course, panel.marked)
    loops_below = _shares(len(below), widths)
    loops_above = _shares(len(above), widths)
    inner = np.arange(next_edge, next_edge + narrow - 1)
    wales = np.concatenate([[panel.left[course]], inner, [panel.right[course]]])
    below_ends, above_ends = (np.concatenate([[0], np.cumsum(loops)]) for loops in (loops_below, loops_above))
    faces.add_row(
        RowBoundary(panel.levels[course], below, below_ends),
        RowBoundary(panel.levels[course + 1], above, above_ends),
        wales, 2 * np.arange(narrow) < narrow, panel.first_row + course,
    )  # fmt: skip
    return next_edge + narrow - 1


def _shares(loops: int, widths: IntArray) -> IntArray:
    """Number of loops of each stitch on one side of a course: ``widths`` on the wide side, 1 on the narrow side."""
    if loops == 0:
        return np.zeros(len(widths), dtype=np.int64)
    return widths if loops == widths.sum() else np.ones(len(widths), dtype=np.int64)


def inner_points(corners: FloatArray, bottom: IntArray, top: IntArray, loops: IntArray) -> list[FloatArray]:
    """Return the inner points of the course lines of a panel, by mean value coordinates.

    Args:
        corners: corners of the panel [cm] from the lower left, shape (n, 3).
        bottom: number of stitches along each bottom side, from left to right.
        top: number of stitches along each top side, from left to right.
        loops: number of loops below each course and above the last course.

    Returns:
        For each inner course line, its points [cm] without the two points on the wale sides.
    """
    template = _template(bottom, top)
    base, width = float(len(bottom) > 0), float(len(top) > 0)
    inner = loops[1:-1] - 1
    level = np.repeat(np.arange(1, len(loops) - 1), inner)
    place = np.arange(len(level)) - np.repeat(np.cumsum(inner) - inner, inner)
    u, v = (place + 1) / loops[level], level / (len(loops) - 1)
    x = 0.5 + (u - 0.5) * (base + (width - base) * v)
    points = mean_value_weights(template, np.stack([x, v], axis=1)) @ corners
    return np.split(points, np.cumsum(inner)[:-1]) if len(inner) else []


def _template(bottom: IntArray, top: IntArray) -> FloatArray:
    """Corners of the template of a panel in the unit square, shape (n, 2); an empty bottom or top becomes a point."""
    low = _marks(bottom)
    high = _marks(top)[::-1]
    return np.concatenate([
        np.stack([low, np.zeros(len(low))], axis=1),
        np.stack([high, np.ones(len(high))], axis=1),
    ])  # fmt: skip


def _marks(counts: IntArray) -> FloatArray:
    """Positions in [0, 1] of the ends of consecutive sides, in proportion to their counts."""
    if len(counts) == 0:
        return np.array([0.5])
    return np.concatenate([[0.0], np.cumsum(counts) / counts.sum()])
