# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stitch faces of one panel, that is, of one face of the labeled mesh.

Vertices and edges on the sides of a panel are shared with its neighbours; vertices and edges inside belong to the panel
alone. A stitch face is described by its corners and by the numbers of its edges. Faces with a common edge number are
neighbours, independently of their vertices.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.mean_value import mean_value_weights
from stitchmesh.mesh.shaping_stitches import shaping_stitch
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.tessellate.courses import MOST_LOOPS, stitch_widths


@dataclass
class StitchFaces:
    """Stitch faces that have been made so far."""

    corners: list[list[int]] = field(default_factory=list)
    """Vertices of each face, counter-clockwise from the lower left."""
    edges: list[list[int]] = field(default_factory=list)
    """Edges of each face, in the order of its sides."""
    n_bottom: list[int] = field(default_factory=list)
    """Number of bottom sides of each face."""
    n_top: list[int] = field(default_factory=list)
    """Number of top sides of each face."""
    stitch: list[Stitch] = field(default_factory=list)
    """Stitch of each face."""
    row: list[int] = field(default_factory=list)
    """Row of each face."""


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
    low, high = panel.levels[course], panel.levels[course + 1]
    b = t = 0
    for index in range(narrow):
        nb, nt = int(loops_below[index]), int(loops_above[index])
        corners = list(low[b : b + nb + 1]) + list(high[t : t + nt + 1][::-1])
        edges = [*below[b : b + nb], wales[index + 1], *above[t : t + nt][::-1], wales[index]]
        faces.corners.append([int(v) for v in corners])
        faces.edges.append([int(e) for e in edges])
        faces.n_bottom.append(nb)
        faces.n_top.append(nt)
        faces.stitch.append(stitch_for(nb, nt, 2 * index < narrow))
        faces.row.append(panel.first_row + course)
        b, t = b + nb, t + nt
    return next_edge + narrow - 1


def _shares(loops: int, widths: IntArray) -> IntArray:
    """Number of loops of each stitch on one side of a course: ``widths`` on the wide side, 1 on the narrow side."""
    if loops == 0:
        return np.zeros(len(widths), dtype=np.int64)
    return widths if loops == widths.sum() else np.ones(len(widths), dtype=np.int64)


def stitch_for(n_bottom: int, n_top: int, left_half: bool) -> Stitch:
    """Return the stitch of a face by its numbers of sides; increases and decreases lean towards the panel's middle.

    Args:
        n_bottom: number of bottom sides.
        n_top: number of top sides.
        left_half: whether the face is in the left half of its course.
    """
    if n_top == 0:
        return Stitch.DRAW_THROUGH
    if n_bottom == 0:
        return Stitch.CAST_ON
    triple = max(n_bottom, n_top) == MOST_LOOPS
    return shaping_stitch(n_bottom, n_top, keeps="middle" if triple else "left" if left_half else "right")


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
    points = []
    for level in range(1, len(loops) - 1):
        v = level / (len(loops) - 1)
        u = np.arange(1, loops[level]) / loops[level]
        x = 0.5 + (u - 0.5) * (base + (width - base) * v)
        flat = np.stack([x, np.full_like(x, v)], axis=1)
        points.append(mean_value_weights(template, flat) @ corners if len(flat) else np.zeros((0, 3)))
    return points


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
