# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Subdivision of triangles by Loop's rules, as a matrix from the vertices of a mesh to the vertices of a finer mesh.

Each round divides a triangle into four. With n neighbours of a vertex v (Loop 1987)

    edge of two triangles:  3/8 of both ends, 1/8 of both opposite vertices
    vertex inside:          (1 - n b) v + b sum of its neighbours,  b = (5/8 - (3/8 + cos(2 pi / n) / 4)^2) / n
    edge on the border:     the middle;   vertex on the border: 3/4 v and 1/8 of both neighbours along the border

A vertex stays if more than two sides of the border meet at it, or if none of its triangles is subdivided. The matrix is
made once for a cloth and applied to each frame. The function of trimesh finds only positions, for each frame again, and
takes wrong neighbours where an inner edge joins two vertices of the border.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, eye_array

from stitchmesh.mesh import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Subdivision:
    """A finer mesh whose vertices are combinations of V vertices."""

    matrix: csr_array
    """Weights by Loop's rules, shape (W, V)."""
    linear: csr_array
    """Weights with which the finer vertices lie on the given triangles, shape (W, V)."""
    triangles: IntArray
    """Vertices of the finer triangles, in the order of their parents, shape (4^rounds T, 3)."""
    rounds: int
    """Number of rounds."""

    def children(self, triangle: IntArray, barycentric: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the finer triangle of each point, shape (n,), and its barycentric coordinates there, shape (n, 3).

        Args:
            triangle: number of the triangle of each point among the divided triangles, shape (n,).
            barycentric: barycentric coordinates, shape (n, 3).
        """
        number, weight = np.asarray(triangle, dtype=np.int64), np.asarray(barycentric, dtype=np.float64)
        for _ in range(self.rounds):
            corner = np.where(weight.max(axis=1) >= 0.5, weight.argmax(axis=1), 3)
            at_corner = 2.0 * weight - np.eye(4, 3)[corner]
            middle = 1.0 - 2.0 * weight[:, [2, 0, 1]]
            weight = np.where((corner == 3)[:, None], middle, at_corner)
            number = 4 * number + corner  # child 4 t + k has corner k of triangle t; child 4 t + 3 is in the middle
        return number, weight


def loop_subdivision(triangles: ArrayLike, vertex_count: int, rounds: int) -> Subdivision:
    """Divide triangles.

    Args:
        triangles: vertices of each triangle, shape (T, 3).
        vertex_count: number V of vertices; vertices without a triangle stay.
        rounds: number of rounds, at least 0.
    """
    matrix = linear = csr_array(eye_array(vertex_count, format="csr"))
    finer = np.asarray(triangles, dtype=np.int64).reshape(-1, 3)
    for _ in range(rounds):
        smooth, halved, finer = _round(finer, matrix.shape[0])
        matrix, linear = csr_array(smooth @ matrix), csr_array(halved @ linear)
    return Subdivision(matrix, linear, finer, rounds)


def _round(triangles: IntArray, count: int) -> tuple[csr_array, csr_array, IntArray]:
    """The weights of one round by Loop's rules and by halving, and the finer triangles."""
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, number, times = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True)
    number = number.reshape(-1)
    border = times == 1
    halved = _stacked(count, np.repeat(np.arange(len(edges)), 2), edges.ravel(), np.full(2 * len(edges), 0.5))
    opposite = np.roll(triangles, 1, axis=1).ravel()  # the vertex opposite to the side from each corner to the next
    ends = np.where(border, 0.5, 0.375)
    inner = np.flatnonzero(~border[number])
    rows = np.concatenate([np.repeat(np.arange(len(edges)), 2), number[inner]])
    columns = np.concatenate([edges.ravel(), opposite[inner]])
    of_edges = csr_array(
        (np.concatenate([np.repeat(ends, 2), np.full(len(inner), 0.125)]), (rows, columns)), shape=(len(edges), count)
    )
    smooth = _over(_vertex_weights(edges, border, count), of_edges)
    middle = count + number.reshape(-1, 3)
    a, b, c = triangles.T
    ab, bc, ca = middle.T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    finer = np.stack([np.stack(part, axis=1) for part in parts], axis=1).reshape(-1, 3)
    return smooth, halved, finer


def _vertex_weights(edges: IntArray, border: np.ndarray, count: int) -> csr_array:
    """Weights of the vertices that the mesh has already, shape (V, V)."""
    along = np.bincount(edges[border].ravel(), minlength=count)
    degree = np.bincount(edges.ravel(), minlength=count)
    of_ring = (0.625 - (0.375 + 0.25 * np.cos(2.0 * np.pi / np.maximum(degree, 1))) ** 2) / np.maximum(degree, 1)
    neighbour = np.where((along == 0) & (degree > 0), of_ring, 0.0)
    own = np.where(along == 2, 0.75, np.where(along == 0, 1.0 - neighbour * degree, 1.0))
    both = np.concatenate([edges, edges[:, ::-1]])
    on_border = np.concatenate([border, border])
    weight = np.where(on_border & (along[both[:, 0]] == 2), 0.125, neighbour[both[:, 0]])
    rows = np.concatenate([np.arange(count), both[:, 0]])
    columns = np.concatenate([np.arange(count), both[:, 1]])
    weights = csr_array((np.concatenate([own, weight]), (rows, columns)), shape=(count, count))
    weights.eliminate_zeros()
    return weights


def _stacked(count: int, rows: IntArray, columns: IntArray, values: FloatArray) -> csr_array:
    """The identity above a matrix."""
    below = csr_array((values, (rows, columns)), shape=(int(rows.max(initial=-1)) + 1, count))
    return _over(csr_array(eye_array(count, format="csr")), below)


def _over(above: csr_array, below: csr_array) -> csr_array:
    from scipy.sparse import vstack

    return csr_array(vstack([above, below], format="csr"))
