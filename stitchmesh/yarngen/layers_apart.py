# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Room between two layers of a fabric that lie closer than their loops are thick, such as a brim that is folded up.

A vertex has another layer beside it if a vertex to which no edge leads lies across from it, in the direction of its
normal. Both are moved apart along their normals by half of what their distance lacks. The moves are
smoothed over the fabric, so that they end gently where the layers part or join.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray, StitchMesh

if TYPE_CHECKING:
    from scipy.sparse import csr_array

THICKNESS_OVER_RADIUS = 5.0
"""Distance that layers get, over the yarn radius. Yarns of two flat layers start 1.5 radii apart at this distance and
0.5 at 3 radii; beside a fold, where the layers meet, a smaller distance leaves them too close."""
PARALLEL = 0.5
"""Cosine of the angle between the normals of two layers from which they lie beside each other."""
SMOOTHINGS = 2
"""How often a move is smoothed over the neighbours of its vertex."""
MOST_ROUNDS = 10
"""Number of looks for layers that are too close."""
ROUNDING = 1e-3
"""Part of the wanted distance that may lack."""


def layers_apart(fabric: StitchMesh, distance: float) -> StitchMesh:
    """Move the layers of a fabric apart where they are closer than a distance.

    Args:
        fabric: the stitches.
        distance: smallest distance of two layers [cm].

    Returns:
        The fabric; the same one if no two layers are closer.
    """
    ends = np.stack([fabric.face_vertex, fabric.face_vertex[fabric.side_next]])
    beside = _adjacency(ends, len(fabric.vertices))
    reach = 0.75 * float(np.median(fabric.side_length))
    moved = fabric
    for _ in range(MOST_ROUNDS):
        move = _moves(moved, beside, distance, reach)
        if move is None:
            break
        for _ in range(SMOOTHINGS):
            move = 0.5 * (move + (beside @ move) / np.maximum(beside.sum(axis=1), 1.0)[:, None])
        moved = replace(moved, vertices=moved.vertices + move)
    return moved


def _moves(fabric: StitchMesh, beside: csr_array, distance: float, reach: float) -> FloatArray | None:
    """Return how far each vertex moves [cm], shape (V, 3); None if no layers are too close.

    Args:
        fabric: the stitches.
        beside: a matrix that is 1 for the ends of an edge, shape (V, V).
        distance: smallest distance of two layers [cm].
        reach: how far from the normal of a vertex the vertex across may lie [cm].
    """
    from scipy.spatial import cKDTree

    points, normal = fabric.vertices, _vertex_normals(fabric)
    pairs = cKDTree(points).query_pairs(float(np.hypot(distance, reach)), output_type="ndarray")
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    one, other = pairs[np.asarray(beside[pairs[:, 0], pairs[:, 1]]).reshape(-1) == 0.0].T
    offset = points[other] - points[one]
    height = np.einsum("nk,nk->n", offset, normal[one])
    aside = np.sqrt(np.maximum(np.einsum("nk,nk->n", offset, offset) - height**2, 0.0))
    parallel = np.abs(np.einsum("nk,nk->n", normal[one], normal[other])) > PARALLEL
    close = parallel & (aside <= reach) & (np.abs(height) < (1.0 - ROUNDING) * distance)
    if not close.any():
        return None
    one, height, aside = one[close], height[close], aside[close]
    order = np.lexsort((aside, one))
    vertex, first = np.unique(one[order], return_index=True)
    across = height[order][first]
    move = np.zeros_like(points)
    away = -np.where(across < 0.0, -1.0, 1.0) * 0.5 * (distance - np.abs(across))
    move[vertex] = away[:, None] * normal[vertex]
    return move


def _adjacency(ends: IntArray, count: int) -> csr_array:
    """Return the matrix that is 1 for the two ends of each edge, shape (count, count)."""
    from scipy.sparse import coo_array

    rows, columns = np.concatenate([ends, ends[::-1]], axis=1)
    matrix = coo_array((np.ones(len(rows)), (rows, columns)), shape=(count, count)).tocsr()
    matrix.data[:] = 1.0
    return matrix


def _vertex_normals(fabric: StitchMesh) -> FloatArray:
    """Return the unit normal of each vertex, the mean of those of its faces, shape (V, 3)."""
    normal = np.zeros_like(fabric.vertices)
    np.add.at(normal, fabric.face_vertex, fabric.face_vector_area[fabric.side_face])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return normal / np.where(length > 0.0, length, 1.0)
