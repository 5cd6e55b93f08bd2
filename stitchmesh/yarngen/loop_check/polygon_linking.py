# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Linking numbers of many pairs of closed polygons.

Seen along a direction, the linking number of two closed curves is half the sum of the signs of their crossings. Each
pair is seen along the normal of its first polygon, turned a little so that no corners hide one another. Whether two
edges cross follows from on which side of each edge the other's corners lie; as the side of a corner is computed once
for both edges that meet there, no crossing is lost or counted twice.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray

CHUNK = 200_000
"""Pairs of edges taken at once; their arrays stay in the processor's cache."""
TURN = np.array([0.0137, 0.0071])
"""Turn of the direction of view, in radians about the two axes of the first polygon's plane."""


@dataclass(frozen=True, eq=False)
class Polygons:
    """Closed polygons in compressed rows."""

    points: FloatArray
    """Corner positions [cm], shape (n, 3)."""
    start: IntArray
    """Where each polygon's corners start, shape (P + 1,)."""
    corner: IntArray
    """Positions that each polygon runs through, the last one joined to the first, shape (start[-1],)."""

    @property
    def size(self) -> IntArray:
        """Number of corners of each polygon, shape (P,)."""
        return np.diff(self.start)

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper ends of each polygon's box [cm], shape (P, 3) each."""
        places = self.points[self.corner]
        return np.minimum.reduceat(places, self.start[:-1]), np.maximum.reduceat(places, self.start[:-1])

    def padded(self, which: IntArray, size: int) -> FloatArray:
        """Corners of some polygons [cm], the last one repeated where there are fewer, shape (n, size, 3)."""
        place = np.minimum(np.arange(size), self.size[which][:, None] - 1)
        return self.points[self.corner[self.start[which][:, None] + place]]


def linking_numbers(first: Polygons, second: Polygons, pairs: IntArray) -> FloatArray:
    """Half the sum of the signs of crossings of each pair of polygons, shape (n,).

    A whole number unless two polygons touch to within rounding.

    Args:
        first: closed polygons.
        second: closed polygons.
        pairs: one of the first and one of the second, shape (n, 2).
    """
    sizes = np.stack([first.size[pairs[:, 0]], second.size[pairs[:, 1]]], axis=1)
    order = np.lexsort(sizes.T)
    result, done = np.zeros(len(pairs)), 0
    while done < len(order):
        count = max(1, CHUNK // int(sizes[order[done]].prod()))
        some = order[done : done + count]
        done += count
        longest = sizes[some].max(axis=0)
        a, b = first.padded(pairs[some, 0], longest[0]), second.padded(pairs[some, 1], longest[1])
        result[some] = _half_sums(a, b)
    return result


def _half_sums(a: FloatArray, b: FloatArray) -> FloatArray:
    """Half the sum of crossing signs of polygons a, shape (n, i, 3), and b, (n, j, 3), pair by pair, shape (n,)."""
    frame = _frames(a)
    centre = a.mean(axis=1, keepdims=True)
    a, b = ((polygon - centre) @ frame for polygon in (a, b))
    next_a, next_b = np.roll(a, -1, axis=1), np.roll(b, -1, axis=1)
    u, v = next_a - a, next_b - b
    from_a, from_b = _sides(a, u, b), _sides(b, v, a)
    crosses = (from_a != np.roll(from_a, -1, axis=2)) & np.swapaxes(from_b != np.roll(from_b, -1, axis=2), 1, 2)
    pair, i, j = np.nonzero(crosses)
    met = _boxes_meet(a[pair, i], next_a[pair, i], b[pair, j], next_b[pair, j])
    pair, i, j = pair[met], i[met], j[met]
    p, q, du, dv = a[pair, i], b[pair, j], u[pair, i], v[pair, j]
    across = du[:, 0] * dv[:, 1] - du[:, 1] * dv[:, 0]
    gap = q - p
    s = (gap[:, 0] * dv[:, 1] - gap[:, 1] * dv[:, 0]) / across
    t = (gap[:, 0] * du[:, 1] - gap[:, 1] * du[:, 0]) / across
    above = p[:, 2] + s * du[:, 2] - q[:, 2] - t * dv[:, 2]
    signs = np.sign(across) * np.sign(above)
    return np.bincount(pair, weights=signs, minlength=len(a)) / 2.0


def _boxes_meet(p: FloatArray, p_end: FloatArray, q: FloatArray, q_end: FloatArray) -> np.ndarray:
    """Whether the boxes of edges from p and of edges from q meet, seen from above, shape (n,).

    Edges that cross have boxes that meet. Of edges on one line, apart from one another, rounding decides on which side
    the corners lie; it is their boxes that tell.
    """
    low = np.maximum(np.minimum(p, p_end), np.minimum(q, q_end))
    high = np.minimum(np.maximum(p, p_end), np.maximum(q, q_end))
    return np.logical_and.reduce(low[:, :2] <= high[:, :2], axis=1)


def _sides(a: FloatArray, u: FloatArray, b: FloatArray) -> np.ndarray:
    """Whether each corner of b lies to the left of each edge u from a, seen from above, shape (n, i, j)."""
    x = u[:, :, None, 0] * (b[:, None, :, 1] - a[:, :, None, 1])
    y = u[:, :, None, 1] * (b[:, None, :, 0] - a[:, :, None, 0])
    return x > y


def _frames(a: FloatArray) -> FloatArray:
    """Axes of each polygon's plane and the direction of view as columns, shape (n, 3, 3)."""
    spoke = a - a.mean(axis=1, keepdims=True)
    normal = np.cross(spoke, np.roll(spoke, -1, axis=1)).sum(axis=1)
    reach = spoke[np.arange(len(a)), np.linalg.norm(spoke, axis=2).argmax(axis=1)]
    across = _unit(np.cross(normal, reach))
    along = _unit(np.cross(across, normal))
    view = _unit(_unit(normal) + TURN[0] * across + TURN[1] * along)
    across = _unit(np.cross(view, along))
    return np.stack([np.cross(across, view), across, view], axis=2)


def _unit(vectors: FloatArray) -> FloatArray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)
