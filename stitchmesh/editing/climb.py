# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Displacement of the vertices when rings become a spiral.

Every vertex moves along its wale by its fraction t of the ring,

    p' = p + t (up(p) - p),  t = place on its course line / vertices of the line,

so that the step from one row to the next is distributed over all stitches of the ring.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.editing.ring_rows import CutRings
from stitchmesh.mesh import BORDER, FloatArray, StitchMesh
from stitchmesh.mesh.border_lean import border_lean, vertex_step
from stitchmesh.mesh.courses import bottom_sides, top_sides

CROWDED_STEP = 0.5
"""Fraction of the wale by which the highest course line moves where there is little space: below other stitches, and
where wales run together."""


def climb(fabric: StitchMesh, turns: CutRings, *, up: bool) -> FloatArray:
    """Return the vertices, moved along their wales, and the new upper end of the seam [cm], shape (V + 1, 3).

    Args:
        fabric: a mesh of stitches whose rows are rings.
        turns: the rings, cut along the seam.
        up: True to make a spiral of rings, False to make rings of a spiral.
    """
    lines, count = _course_lines(fabric, turns), len(fabric.vertices)
    moved = np.concatenate([fabric.vertices, fabric.vertices[lines[-1][:1]]])
    for level, line in enumerate(lines):
        ring = turns.rings[min(level, len(turns.rings) - 1) if up else max(level - 1, 0)]
        step = _steps(fabric, ring, line)
        if level == len(turns.rings):
            step = np.where(_is_free(fabric, turns), _border_steps(fabric, line, step), CROWDED_STEP * step)
        fraction = np.arange(len(line))[:, None] / len(line)
        moved[line] += fraction * step if up else -fraction * step
    moved[count] += step[0]
    return moved


def _course_lines(fabric: StitchMesh, turns: CutRings) -> list[list[int]]:
    """Return the vertices of the course lines below, between and above the rings, from the seam to the right."""
    bottoms = [bottom_sides(fabric, ring) for ring in turns.rings]
    tops = [side + 1 for side in top_sides(fabric, turns.rings[-1])]  # the ends of the sides, on the left
    return [fabric.face_vertex[corners].tolist() for corners in (*bottoms, tops)]


def _is_free(fabric: StitchMesh, turns: CutRings) -> NDArray[np.bool_]:
    """Return whether no face lies above each vertex of the highest course line, shape (n, 1)."""
    border = fabric.twin[top_sides(fabric, turns.rings[-1])] == BORDER
    return (border & np.roll(border, 1))[:, None]


def _border_steps(fabric: StitchMesh, line: list[int], step: FloatArray) -> FloatArray:
    """Return the steps beyond a top border [cm], shape (n, 3).

    The steps follow the normal where wales run together, for example around a crown.
    """
    places = np.arange(len(line))
    leaning = border_lean(fabric.vertices[line], step, np.stack([places, np.roll(places, -1)]))
    fraction = CROWDED_STEP if leaning.any() else 1.0
    return fraction * vertex_step(step, leaning, fabric.vertex_normal[line])


def _steps(fabric: StitchMesh, ring: list[int], line: list[int]) -> FloatArray:
    """Return the upward wale vector of a ring at each vertex of an adjacent course line [cm], shape (n, 3).

    The vectors are interpolated between the wales.
    """
    low, high = fabric.face_vertex[fabric.face_start[:-1][ring]], fabric.face_vertex[fabric.left_wale[ring]]
    wales = fabric.vertices[high] - fabric.vertices[low]
    at = {int(vertex): number for ends in (low, high) for number, vertex in enumerate(ends)}
    known = [place for place, vertex in enumerate(line) if vertex in at]
    found = wales[[at[line[place]] for place in known]]
    return np.stack([np.interp(np.arange(len(line)), known, axis, period=len(line)) for axis in found.T], axis=1)
