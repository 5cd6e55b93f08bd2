# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The bind-off row: a face above every top side on the border, so that the last loops are held.

Like the cable faces of Yuksel et al. 2012 it exists only while yarn is generated (section 4.3).
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.stitch import Stitch

BIND_OFF_HEIGHT = 0.8
"""Height of a bind-off face over the mean height of the stitches below it; the drawn yarn needs no more."""


def with_bind_off(fabric: StitchMesh) -> StitchMesh:
    """The stitch mesh with one more row above each border that has top sides; the given faces keep their numbers."""
    sides = np.flatnonzero((fabric.side_role == 2) & (fabric.twin == BORDER))
    if len(sides) == 0:
        return fabric
    right, left = fabric.face_vertex[sides], fabric.face_vertex[fabric.side_next[sides]]
    border_vertices, place = np.unique(np.concatenate([right, left]), return_inverse=True)
    raised = len(fabric.vertices) + place.reshape(2, -1)
    quads = np.stack([left, right, raised[0], raised[1]], axis=1)
    first = fabric.side_count + 4 * np.arange(len(sides))
    twin = np.concatenate([fabric.twin, np.full(4 * len(sides), BORDER)])
    twin[sides], twin[first] = first, sides
    _join_neighbours(twin, first, left, right)
    count = len(sides)
    return StitchMesh(
        vertices=np.concatenate([fabric.vertices, _raised(fabric, border_vertices)]),
        face_start=np.concatenate([fabric.face_start, fabric.face_start[-1] + 4 * np.arange(1, count + 1)]),
        face_vertex=np.concatenate([fabric.face_vertex, quads.ravel()]),
        twin=twin,
        n_bottom=np.concatenate([fabric.n_bottom, np.ones(count, dtype=np.int64)]),
        n_top=np.concatenate([fabric.n_top, np.ones(count, dtype=np.int64)]),
        stitch=np.concatenate([fabric.stitch, np.full(count, Stitch.BIND_OFF)]),
        row=np.concatenate([fabric.row, fabric.row.max() + 1 + fabric.row[fabric.side_face[sides]]]),
    )


def _join_neighbours(twin: IntArray, first: IntArray, left: IntArray, right: IntArray) -> None:
    """The right wale side of a bind-off face meets the left wale side of the one that starts where it ends."""
    by_left = {int(vertex): int(side) for vertex, side in zip(left, first, strict=True)}
    for vertex, side in zip(right, first, strict=True):
        neighbour = by_left.get(int(vertex))
        if neighbour is not None:
            twin[side + 1], twin[neighbour + 3] = neighbour + 3, side + 1


def _raised(fabric: StitchMesh, vertices: IntArray) -> FloatArray:
    """Border vertices moved on along the wales that end there [cm]."""
    ends = np.where(fabric.side_role == 1, fabric.side_next, np.arange(fabric.side_count))
    starts = np.where(fabric.side_role == 1, np.arange(fabric.side_count), fabric.side_next)
    wales = np.flatnonzero(fabric.is_wale)
    up = fabric.corner_position[ends[wales]] - fabric.corner_position[starts[wales]]
    total, count = np.zeros_like(fabric.vertices), np.zeros(len(fabric.vertices))
    np.add.at(total, fabric.face_vertex[ends[wales]], up)
    np.add.at(count, fabric.face_vertex[ends[wales]], 1.0)
    return fabric.vertices[vertices] + BIND_OFF_HEIGHT * total[vertices] / count[vertices, None]
