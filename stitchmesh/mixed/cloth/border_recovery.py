# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Recovery of border edges in a triangulation: edges that cross a wanted edge are flipped away (Sloan 1993).

A Delaunay triangulation of points on a border and inside it has nearly always all edges of the border. One can be
missing where the outline is narrower than its edges are long. An edge that crosses the wanted edge, and whose two
triangles form a convex quadrilateral, is replaced by the other diagonal. An edge whose quadrilateral is not convex
waits until its neighbours are flipped.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray

Edge = tuple[int, int]


def with_edges(points: FloatArray, triangles: IntArray, edges: IntArray) -> IntArray:
    """Return triangles of the same points that have all wanted edges, shape (T, 3), anticlockwise.

    Args:
        points: points in the plane, shape (n, 2).
        triangles: a triangulation of the points, anticlockwise, shape (T, 3).
        edges: edges that must be there, which do not cross one another, shape (m, 2).

    Raises:
        ParameterError: an edge cannot be recovered, because a point lies on it.
    """
    missing = _missing(triangles, edges, len(points))
    if not len(missing):
        return triangles
    flips = _Flips(points, triangles)
    for one, other in missing.tolist():
        flips.recover(one, other)
    return np.array(flips.triangles)


def _missing(triangles: IntArray, edges: IntArray, count: int) -> IntArray:
    """Wanted edges that are not sides of triangles, shape (k, 2)."""
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    there = np.isin(_key(edges, count), _key(sides, count))
    return edges[~there]


def _key(edges: IntArray, count: int) -> IntArray:
    return edges.min(axis=1) * count + edges.max(axis=1)


class _Flips:
    """A triangulation whose edges can be flipped."""

    def __init__(self, points: FloatArray, triangles: IntArray) -> None:
        self.points = points.tolist()
        self.triangles: list[list[int]] = triangles.tolist()
        self.of_side: dict[Edge, int] = {}
        for number in range(len(self.triangles)):
            self._enter(number)

    def recover(self, one: int, other: int) -> None:
        """Flip edges until the edge from ``one`` to ``other`` is there."""
        waiting = deque(self._crossing(one, other))
        patience = 10 * len(waiting) ** 2 + 10  # each round of the queue removes at least one crossing
        while waiting and patience:
            patience -= 1
            edge = waiting.popleft()
            made = self._flip(*edge)
            if made is None:
                waiting.append(edge)
            elif self._cross(one, other, *made):
                waiting.append(made)
        if (one, other) not in self.of_side and (other, one) not in self.of_side:
            raise ParameterError(
                f"panel: border edge {one}-{other}: cannot become a side of triangles, because the outline is too "
                "narrow there; take a smaller edge length"
            )

    def _crossing(self, one: int, other: int) -> list[Edge]:
        """Edges that cross the segment between two points, in the order of their numbers."""
        return sorted(edge for edge in self.of_side if edge[0] < edge[1] and self._cross(one, other, *edge))

    def _cross(self, a: int, b: int, c: int, d: int) -> bool:
        if len({a, b, c, d}) < 4:
            return False
        return self._turn(a, b, c) * self._turn(a, b, d) < 0.0 and self._turn(c, d, a) * self._turn(c, d, b) < 0.0

    def _turn(self, a: int, b: int, c: int) -> float:
        (ax, ay), (bx, by), (cx, cy) = self.points[a], self.points[b], self.points[c]
        return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)

    def _flip(self, a: int, b: int) -> Edge | None:
        """Replace an edge by the other diagonal of its quadrilateral, and return it; None if that is not convex."""
        left, right = self.of_side[a, b], self.of_side[b, a]
        c, d = self._third(left, a, b), self._third(right, a, b)
        if self._turn(d, b, c) <= 0.0 or self._turn(c, a, d) <= 0.0:
            return None
        for number in (left, right):
            for side in _sides(self.triangles[number]):
                del self.of_side[side]
        self.triangles[left], self.triangles[right] = [d, b, c], [c, a, d]
        self._enter(left)
        self._enter(right)
        return min(c, d), max(c, d)

    def _third(self, triangle: int, a: int, b: int) -> int:
        return next(vertex for vertex in self.triangles[triangle] if vertex not in (a, b))

    def _enter(self, number: int) -> None:
        for side in _sides(self.triangles[number]):
            self.of_side[side] = number


def _sides(triangle: list[int]) -> list[Edge]:
    a, b, c = triangle
    return [(a, b), (b, c), (c, a)]
