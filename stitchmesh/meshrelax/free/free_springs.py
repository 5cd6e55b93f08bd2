# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The forces of a fabric without a surface, whose stitches have rest sizes of their own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.turns import turn_edges
from stitchmesh.meshrelax.bobbles import Bobbles
from stitchmesh.meshrelax.free.points import CornerPoints, corner_points
from stitchmesh.meshrelax.free.stitch_sizes import StitchSizes
from stitchmesh.meshrelax.sub_quads import (
    TURN_HEIGHT,
    Springs,
    edge_ends,
    quad_angles,
    sub_quad_corners,
    wale_strut_corners,
)


@dataclass(frozen=True, eq=False)
class FreeSprings:
    """The forces, their points, and the rest lengths of the edges."""

    springs: Springs
    """The forces, whose vertices are the points of ``corners``."""
    corners: CornerPoints
    """The points."""
    edge_rest: FloatArray
    """Rest length of each edge [cm], shape (E,)."""
    edge_points: IntArray
    """Points of both ends of each edge, shape (E, 2)."""


def free_springs(fabric: StitchMesh, sizes: StitchSizes, bobbles: Bobbles) -> FreeSprings:
    """Find the forces of a free fabric.

    A side that two stitches share has the mean of their rest lengths.

    Args:
        fabric: stitch mesh.
        sizes: rest width and height of each stitch [cm].
        bobbles: the bobbles of the fabric; each counts as one stitch.
    """
    raised = bobbles.is_raised(len(fabric.vertices))
    strut_corners = wale_strut_corners(fabric, raised)
    found = corner_points(fabric, strut_corners)
    edge_rest = _edge_rest(fabric, sizes)
    sides = fabric.edge_side
    edge_points = found.of_corner[np.stack([sides, fabric.side_next[sides]], axis=1)]
    kept = ~raised[edge_ends(fabric)].any(axis=1)
    corners = sub_quad_corners(fabric)
    flat = ~raised[fabric.face_vertex[corners]].any(axis=1)
    face = fabric.side_face[corners[flat, 0]]
    quads = np.concatenate([found.of_corner[corners[flat]], bobbles.corners])
    width, height = (np.append(size[face], np.full(bobbles.count, size.mean())) for size in (sizes.width, sizes.height))
    ends = [edge_points[kept], quads[:, [0, 2]], quads[:, [1, 3]]]
    diagonal = np.hypot(width, height)
    springs = Springs(
        stretch_ends=np.concatenate(ends),
        stretch_rest=np.concatenate([edge_rest[kept], diagonal, diagonal]),
        corners=quad_angles(quads),
        struts=found.struts,
        strut_rest=sizes.height[fabric.side_face[strut_corners[:, 1:3]]].mean(axis=1),
        quads=quads,
        quad_area=width * height,
        unit=float(np.sqrt(sizes.width.mean() * sizes.height.mean())),
    )
    return FreeSprings(springs, found, edge_rest, edge_points)


def _edge_rest(fabric: StitchMesh, sizes: StitchSizes) -> FloatArray:
    """Return the rest length of each edge [cm], shape (E,)."""
    of_side = np.where(fabric.is_wale, sizes.height[fabric.side_face], sizes.width[fabric.side_face])
    total = np.bincount(fabric.side_edge, of_side)
    rest: FloatArray = total / np.bincount(fabric.side_edge) * np.where(turn_edges(fabric), TURN_HEIGHT, 1.0)
    return rest
