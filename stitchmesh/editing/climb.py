# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How the vertices of rings climb when the rings become a spiral.

Every vertex climbs along its wale by its share of the way around,

    p' = p + t (up(p) - p),  t = place on its course line / vertices of the line,

so that no stitch takes the whole step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.editing.ring_rows import Turns
from stitchmesh.mesh import BORDER, FloatArray, StitchMesh
from stitchmesh.mesh.border_lean import border_lean, vertex_step
from stitchmesh.mesh.courses import bottom_sides, top_sides

CROWDED_STEP = 0.5
"""Part of its wale that the highest course line climbs where it is crowded: below stitches, and where wales run
together."""


def climb(fabric: StitchMesh, turns: Turns, *, up: bool) -> FloatArray:
    """Vertices moved along their wales, and after them the upper end of the seam [cm], shape (V + 1, 3).

    Args:
        fabric: stitch faces, as rings.
        turns: the rings, cut along the seam.
        up: whether they climb, or come down again.
    """
    lines, count = _course_lines(fabric, turns), len(fabric.vertices)
    moved = np.concatenate([fabric.vertices, fabric.vertices[lines[-1][:1]]])
    for level, line in enumerate(lines):
        ring = turns.rings[min(level, len(turns.rings) - 1) if up else max(level - 1, 0)]
        step = _steps(fabric, ring, line)
        if level == len(turns.rings):
            step = np.where(_is_free(fabric, turns), _standing(fabric, line, step), CROWDED_STEP * step)
        share = np.arange(len(line))[:, None] / len(line)
        moved[line] += share * step if up else -share * step
    moved[count] += step[0]
    return moved


def _course_lines(fabric: StitchMesh, turns: Turns) -> list[list[int]]:
    """Vertices of the course lines below, between and above the rings, from the seam to the right."""
    bottoms = [bottom_sides(fabric, ring) for ring in turns.rings]
    tops = [side + 1 for side in top_sides(fabric, turns.rings[-1])]  # their ends, which lie on the left
    return [fabric.face_vertex[corners].tolist() for corners in (*bottoms, tops)]


def _is_free(fabric: StitchMesh, turns: Turns) -> NDArray[np.bool_]:
    """Whether there is nothing above each vertex of the highest course line, shape (n, 1)."""
    border = fabric.twin[top_sides(fabric, turns.rings[-1])] == BORDER
    return (border & np.roll(border, 1))[:, None]


def _standing(fabric: StitchMesh, line: list[int], step: FloatArray) -> FloatArray:
    """Steps beyond a top border [cm]; where wales run together there, round a crown, they rise along the normal."""
    places = np.arange(len(line))
    leaning = border_lean(fabric.vertices[line], step, np.stack([places, np.roll(places, -1)]))
    part = CROWDED_STEP if leaning.any() else 1.0
    return part * vertex_step(step, leaning, fabric.vertex_normal[line])


def _steps(fabric: StitchMesh, ring: list[int], line: list[int]) -> FloatArray:
    """The wale of a ring at each vertex of a course line beside it, upwards [cm]; interpolated between wales."""
    low, head = fabric.face_vertex[fabric.face_start[:-1][ring]], fabric.face_vertex[fabric.left_wale[ring]]
    wales = fabric.vertices[head] - fabric.vertices[low]
    at = {int(vertex): number for ends in (low, head) for number, vertex in enumerate(ends)}
    known = [place for place, vertex in enumerate(line) if vertex in at]
    found = wales[[at[line[place]] for place in known]]
    return np.stack([np.interp(np.arange(len(line)), known, axis, period=len(line)) for axis in found.T], axis=1)
