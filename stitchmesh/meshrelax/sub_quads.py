# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The vertices of the forces: sub-quads, springs and struts of a fabric (Yuksel et al. 2012, figure 15)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.turns import turn_edges
from stitchmesh.meshrelax.bobbles import NO_BOBBLES, Bobbles
from stitchmesh.meshrelax.rest_lengths import RestRectangle

TURN_HEIGHT = 0.2
"""Rest length of the end of a row at a turn within the fabric, over the rest length of a wale edge. The two rows meet
there in a point, near which their tip is placed after the relaxation. With 0.05 the relaxation does not converge."""


@dataclass(frozen=True)
class Springs:
    """Vertices and rest lengths of all forces of a fabric."""

    stretch_ends: IntArray
    """Ends of the springs, shape (S, 2): first along the edges, then along the diagonals of sub-quads."""
    stretch_rest: FloatArray
    """Rest length of each spring [cm], shape (S,)."""
    corners: IntArray
    """Each corner of each sub-quad, between its two neighbours: three vertices, shape (A, 3)."""
    struts: IntArray
    """Three consecutive vertices along a wale, shape (W, 3)."""
    strut_rest: FloatArray
    """Rest length of the wale edges of each strut [cm], shape (W,)."""
    quads: IntArray
    """Corners of each sub-quad, counter-clockwise from the lower left, shape (Q, 4)."""
    quad_area: FloatArray
    """Rest area of each sub-quad [cm^2], shape (Q,)."""
    unit: float
    """Size of a stitch [cm]."""
    area_force: bool = True
    """Whether sub-quads that are smaller than at rest resist a further loss of area (``area``)."""


def springs(
    fabric: StitchMesh, rest: RestRectangle, *, bobbles: Bobbles = NO_BOBBLES, area_force: bool = True
) -> Springs:
    """Find the vertices and rest lengths of all forces of a fabric, in which each bobble counts as one stitch."""
    raised = bobbles.is_raised(len(fabric.vertices))
    quads = fabric.face_vertex[sub_quad_corners(fabric)]
    quads = np.concatenate([quads[~raised[quads].any(axis=1)], bobbles.corners])
    diagonals = np.concatenate([quads[:, [0, 2]], quads[:, [1, 3]]])
    ends = edge_ends(fabric)
    on_surface = ~raised[ends].any(axis=1)
    height = np.where(turn_edges(fabric), TURN_HEIGHT, 1.0) * rest.wale
    edge_rest = np.where(fabric.is_wale[fabric.edge_side], height, rest.course)[on_surface]
    ends = ends[on_surface]
    lengths = np.concatenate([edge_rest, np.full(len(diagonals), rest.diagonal)])
    struts = fabric.face_vertex[wale_strut_corners(fabric, raised)[:, [0, 1, 3]]]
    return Springs(
        stretch_ends=np.concatenate([ends, diagonals]),
        stretch_rest=lengths,
        corners=quad_angles(quads),
        struts=struts,
        strut_rest=np.full(len(struts), rest.wale),
        quads=quads,
        quad_area=np.full(len(quads), rest.course * rest.wale),
        unit=rest.unit,
        area_force=area_force,
    )


def quad_angles(quads: IntArray) -> IntArray:
    """Return each corner of each sub-quad between its two neighbours, shape (4Q, 3)."""
    return np.concatenate([quads[:, [(corner - 1) % 4, corner, (corner + 1) % 4]] for corner in range(4)])


def edge_ends(fabric: StitchMesh) -> IntArray:
    """Return the two vertices of each edge, shape (E, 2)."""
    sides = fabric.edge_side
    return np.stack([fabric.face_vertex[sides], fabric.face_vertex[fabric.side_next[sides]]], axis=1)


def sub_quad_corners(fabric: StitchMesh) -> IntArray:
    """Return the lower left, lower right, upper right and upper left mesh corner of each sub-quad, shape (Q, 4).

    A face with b bottom and t top sides has max(b, t) sub-quads; on the narrower side of the face several of them may
    share one side. A face without a bottom or without a top side is a triangle and has no sub-quads.
    """
    bottom, top = fabric.n_bottom, fabric.n_top
    count = np.where(np.minimum(bottom, top) > 0, np.maximum(bottom, top), 0)
    face = np.repeat(np.arange(fabric.face_count), count)
    place = np.arange(len(face)) - np.repeat(np.cumsum(count) - count, count)
    lower = fabric.face_start[face] + place * bottom[face] // count[face]
    # The top sides run from right to left, so that their left end is the last corner of the face.
    upper = fabric.face_start[face + 1] - 1 - place * top[face] // count[face]
    return np.stack([lower, lower + 1, upper - 1, upper], axis=1)


def wale_strut_corners(fabric: StitchMesh, raised: NDArray[np.bool_] | None = None) -> IntArray:
    """Return the mesh corners at the ends of each pair of consecutive wale edges, shape (W, 4).

    The corners are the far end of the first edge, the ends of both edges at their common vertex, and the far end of the
    second edge. A wale continues through a vertex if exactly two wale edges meet there and they are not the two wale
    sides of one face, which meet at the end of a short row. There is no strut where wales begin, end or merge.

    Args:
        fabric: stitch mesh.
        raised: whether each vertex stands off the surface, shape (V,); its edges have no struts. None if all vertices
            lie on the surface.
    """
    sides = fabric.edge_side[fabric.is_wale[fabric.edge_side]]
    ends = np.stack([sides, fabric.side_next[sides]], axis=1)
    ends = ends if raised is None else ends[~raised[fabric.face_vertex[ends]].any(axis=1)]
    middle, far = ends.ravel(), ends[:, ::-1].ravel()
    vertex = fabric.face_vertex[middle]
    order = np.argsort(vertex, kind="stable")
    regular = np.bincount(vertex, minlength=len(fabric.vertices)) == 2
    regular[fabric.face_vertex[fabric.left_wale[fabric.n_top == 0]]] = False
    regular[fabric.face_vertex[fabric.right_wale[fabric.n_bottom == 0]]] = False
    kept = order[regular[vertex[order]]]
    one, other = kept[0::2], kept[1::2]
    return np.stack([far[one], middle[one], middle[other], far[other]], axis=1)
