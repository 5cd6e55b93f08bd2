# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stitch faces of one panel: a face of the labeled mesh.

Vertices and edges on the panel's sides are shared with its neighbours, those inside are its own. A stitch face is
listed by its corners and by the numbers of its edges; faces with the same edge number are neighbours, whatever
their vertices.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.mean_value import mean_value_weights
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.tessellate.courses import stitch_widths


@dataclass
class StitchFaces:
    """Stitch faces while they are listed."""

    corners: list[list[int]] = field(default_factory=list)
    edges: list[list[int]] = field(default_factory=list)
    n_bottom: list[int] = field(default_factory=list)
    n_top: list[int] = field(default_factory=list)
    stitch: list[Stitch] = field(default_factory=list)
    row: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class Panel:
    """A panel with the vertices on its courses and the edges around it.

    ``levels[j]`` are the vertices below course j, left to right; ``bottom`` and ``top`` the edges of the first and
    last level, ``left`` and ``right`` the wale edges, upwards.
    """

    levels: list[IntArray]
    bottom: IntArray
    top: IntArray
    left: IntArray
    right: IntArray
    first_row: int
    marked: str


def add_stitches(panel: Panel, faces: StitchFaces, next_edge: int) -> int:
    """List the panel's stitch faces; returns the next free edge number."""
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
    panel: Panel, course: int, below: IntArray, above: IntArray, faces: StitchFaces, next_edge: int
) -> int:
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
    """Loops of each stitch on a side of a course: its widths on the wide side, one each on the narrow one."""
    if loops == 0:
        return np.zeros(len(widths), dtype=np.int64)
    return widths if loops == widths.sum() else np.ones(len(widths), dtype=np.int64)


def stitch_for(n_bottom: int, n_top: int, left_half: bool) -> Stitch:
    """The plain stitch of a face with these sides; increases and decreases lean to the panel's middle."""
    by_sides = {
        (1, 1): Stitch.KNIT,
        (1, 2): Stitch.KY if left_half else Stitch.YK,
        (1, 3): Stitch.KYK,
        (2, 1): Stitch.D21K if left_half else Stitch.D12K,
        (3, 1): Stitch.D213K,
    }
    if n_top == 0:
        return Stitch.DRAW_THROUGH
    return Stitch.CAST_ON if n_bottom == 0 else by_sides[n_bottom, n_top]


def inner_points(corners: FloatArray, bottom: IntArray, top: IntArray, loops: IntArray) -> list[FloatArray]:
    """Points inside a panel on each course line, by mean value coordinates.

    Args:
        corners: the panel's corners [cm] from the lower left, shape (n, 3).
        bottom: stitches along each bottom side, left to right.
        top: stitches along each top side, left to right.
        loops: loops below each course and above the last.

    Returns:
        For each inner course line its points [cm] without the two on the wale sides.
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
    """Corners of the panel laid flat in the unit square; a side without loops shrinks to a point."""
    low = _marks(bottom)
    high = _marks(top)[::-1]
    return np.concatenate([
        np.stack([low, np.zeros(len(low))], axis=1),
        np.stack([high, np.ones(len(high))], axis=1),
    ])  # fmt: skip


def _marks(counts: IntArray) -> FloatArray:
    if len(counts) == 0:
        return np.array([0.5])
    return np.concatenate([[0.0], np.cumsum(counts) / counts.sum()])
