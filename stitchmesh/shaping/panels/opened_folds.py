# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Room for the thickness of the fabric at sharp folds, where the panels of a pattern lie on each other.

Two layers of stitches, back to back or face to face, are moved apart along their normals until their distance is the
thickness of a knitted fabric. The motion is spread over the stitches beside them.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray, Mesh

THICKNESS = 0.8
"""Distance of two layers, in stitch widths: loops are six yarn radii thick, and a radius is an eighth of a width."""
OPPOSED = -0.3
"""Cosine of the angle of two normals below which their layers are opposed."""
ROUNDS = 4
"""Number of times that layers are moved apart; the normals change each time."""
SPREADING = 3
"""Number of stitches over which the motion is spread."""


def opened_folds(mesh: Mesh, width: float) -> FloatArray:
    """Return the vertices of a stitch mesh after opposed layers were moved apart [cm], shape (V, 3).

    Args:
        mesh: the stitches.
        width: width of a stitch [cm].
    """
    points, ends = mesh.vertices, np.stack([mesh.face_vertex, mesh.face_vertex[mesh.side_next]])
    for _ in range(ROUNDS):
        normals = _vertex_normals(mesh, points)
        motion = _motion(points, normals, THICKNESS * width)
        if not motion.any():
            break
        points = points + _spread(motion, ends)[:, None] * normals
    return points


def _vertex_normals(mesh: Mesh, points: FloatArray) -> FloatArray:
    """Unit normal at each vertex, shape (V, 3): the mean of those of its corners."""
    corner = mesh.face_vertex
    before = np.empty(mesh.side_count, dtype=np.int64)
    before[mesh.side_next] = np.arange(mesh.side_count)
    here = points[corner]
    area = np.cross(points[corner[mesh.side_next]] - here, points[corner[before]] - here)
    normal = np.stack([np.bincount(corner, area[:, axis], len(points)) for axis in range(3)], axis=1)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return np.divide(normal, length, out=np.zeros_like(normal), where=length > 0.0)


def _motion(points: FloatArray, normals: FloatArray, thickness: float) -> FloatArray:
    """Half of what is missing between each vertex and the nearest opposed one, along its normal [cm], shape (V,)."""
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(thickness, output_type="ndarray")
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    first, second = pairs.T
    opposed = np.einsum("ni,ni->n", normals[first], normals[second]) < OPPOSED
    first, second = first[opposed], second[opposed]
    height = np.einsum("ni,ni->n", points[first] - points[second], normals[first])
    # Layers that lie in one place are back to back: patterns are flat outside out.
    side = np.where(height > -0.1 * thickness, 1.0, -1.0)
    missing = 0.5 * (thickness - np.abs(height)).clip(0.0) * side
    order = np.argsort(np.abs(missing), kind="stable")
    motion = np.zeros(len(points))
    motion[first[order]] = missing[order]
    return motion


def _spread(motion: FloatArray, ends: IntArray) -> FloatArray:
    """Spread a motion over neighbouring vertices, shape (V,); no vertex moves less than it has to."""
    pairs = np.concatenate([ends, ends[::-1]], axis=1)
    count = np.bincount(pairs[0], minlength=len(motion))
    spread = motion
    for _ in range(SPREADING):
        mean = np.bincount(pairs[0], spread[pairs[1]], len(motion)) / np.maximum(count, 1)
        spread = np.where(np.abs(motion) > np.abs(mean), motion, mean)
    return spread
