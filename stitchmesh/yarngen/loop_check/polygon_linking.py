# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Linking numbers of many pairs of closed polygons.

Seen along a direction, the linking number of two closed curves is half the sum of the signs of their crossings. Each
pair is seen along the normal of its first polygon, turned a little so that few corners hide one another. There each
corner is rounded to whole units, so few that double precision holds products of two coordinates exactly. Whether two
edges cross follows from on which side of each edge the other's corners lie. Where a corner lies on an edge, or edges
touch, the second polygon counts as moved by (e, e^2, e^3), with e smaller than anything (Edelsbrunner and Muecke 1990).
So every answer is that of two polygons in general position, which cross an even number of times.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray

CHUNK = 200_000
"""Pairs of edges taken at once; their arrays stay in the processor's cache."""
UNITS = 2**24
"""Largest coordinate of a pair of polygons [units]: products of two differences then stay below 2^51."""
ROUNDING = 1e-15
"""Bound of the rounding error of a sum of three products, over the sum of their sizes."""
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
    """Half the sum of the signs of crossings of each pair of polygons, whole numbers, shape (n,).

    They are those of polygons whose corners were moved by up to a ten-millionth of the size of the pair.

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
    a, b = _in_units((a - centre) @ frame, (b - centre) @ frame)
    u, v = np.roll(a, -1, axis=1) - a, np.roll(b, -1, axis=1) - b
    from_a, from_b = _sides(a, u, b, 1.0), _sides(b, v, a, -1.0)
    crosses = (from_a != np.roll(from_a, -1, axis=2)) & np.swapaxes(from_b != np.roll(from_b, -1, axis=2), 1, 2)
    pair, i, j = np.nonzero(crosses)
    signs = -_volume_signs(u[pair, i], v[pair, j], b[pair, j] - a[pair, i])
    return np.bincount(pair, weights=signs, minlength=len(a)) / 2.0


def _in_units(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Coordinates of pairs of polygons in whole units."""
    largest = np.maximum(np.abs(a).max(axis=(1, 2)), np.abs(b).max(axis=(1, 2)))
    scale = UNITS / np.maximum(largest, 1e-300)[:, None, None]
    return np.rint(a * scale), np.rint(b * scale)


def _sides(a: FloatArray, u: FloatArray, b: FloatArray, later: float) -> np.ndarray:
    """Whether each corner of b lies to the left of each edge u from a, seen from above, shape (n, i, j).

    ``later`` is 1 where b is the polygon that counts as moved, -1 where a is.
    """
    x = u[:, :, None, 0] * (b[:, None, :, 1] - a[:, :, None, 1])
    y = u[:, :, None, 1] * (b[:, None, :, 0] - a[:, :, None, 0])
    on_line_left = np.where(u[..., 1] != 0.0, u[..., 1] * later < 0.0, u[..., 0] * later > 0.0)[:, :, None]
    return (x > y) | ((x == y) & on_line_left)


def _volume_signs(u: FloatArray, v: FloatArray, gap: FloatArray) -> FloatArray:
    """Signs of (u x v) . gap for whole numbers, where it is zero as if the gap were moved by (e, e^2, e^3), (n,)."""
    normal = np.cross(u, v)  # exact
    volume = (normal * gap).sum(axis=1)
    unsure = np.flatnonzero(np.abs(volume) <= ROUNDING * (np.abs(normal) * np.abs(gap)).sum(axis=1))
    whole = [values[unsure].astype(np.int64).astype(object) for values in (normal, gap)]
    signs = np.sign(volume)
    signs[unsure] = np.sign((whole[0] * whole[1]).sum(axis=1).astype(np.float64))
    for axis in range(3):
        signs = np.where(signs == 0.0, np.sign(normal[:, axis]), signs)
    return signs


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
