# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Linking numbers of many pairs of closed polygons.

In a projection along any direction, the linking number of two closed curves is half the sum of the signs of their
crossings. Each pair is projected along the normal of its first polygon, tilted a little so that few corners coincide.
The corners are rounded to whole units. The units are so large that double precision represents products of two
coordinates exactly. Two edges cross if the ends of each edge lie on different sides of the other edge. Where a corner
lies on an edge, or edges touch, the second polygon counts as moved by (e, e^2, e^3), with e smaller than any number
(Edelsbrunner and Muecke 1990). Every result therefore belongs to two polygons in general position, whose projections
cross an even number of times.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.arrays import unit_vectors

CHUNK = 200_000
"""Number of pairs of edges that are processed at once; their arrays fit into the cache of the processor."""
UNITS = 2**24
"""Largest coordinate of a pair of polygons [units]. Products of two differences then stay below 2^51."""
TURN = np.array([0.0137, 0.0071])
"""Tilt of the direction of projection about the two axes of the plane of the first polygon [rad]."""


@dataclass(frozen=True, eq=False)
class Polygons:
    """Closed polygons, stored one after another."""

    points: FloatArray
    """Corner positions [cm], shape (n, 3)."""
    start: IntArray
    """Index of the first corner of each polygon in ``corner``, shape (P + 1,)."""
    corner: IntArray
    """Points through which each polygon passes, shape (start[-1],). The last point of a polygon is joined to its
    first."""

    @property
    def size(self) -> IntArray:
        """Number of corners of each polygon, shape (P,)."""
        return np.diff(self.start)

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper corner of the bounding box of each polygon [cm], shape (P, 3) each."""
        places = self.points[self.corner]
        return np.minimum.reduceat(places, self.start[:-1]), np.maximum.reduceat(places, self.start[:-1])

    def padded(self, which: IntArray, size: int) -> FloatArray:
        """Corners of the selected polygons [cm], shape (n, size, 3); the last corner is repeated where needed."""
        place = np.minimum(np.arange(size), self.size[which][:, None] - 1)
        return self.points[self.corner[self.start[which][:, None] + place]]


def linking_numbers(first: Polygons, second: Polygons, pairs: IntArray) -> FloatArray:
    """Linking numbers of pairs of polygons, as floating-point whole numbers, shape (n,).

    A linking number is half the sum of the signs of the crossings. Rounding to units moves the corners by up to a
    ten-millionth of the size of the pair.

    Args:
        first: closed polygons.
        second: closed polygons.
        pairs: number of a first polygon and number of a second polygon, shape (n, 2).
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
    """Half the sum of the signs of the crossings of each pair of polygons, shape (n,).

    Args:
        a: corners of the first polygons [cm], shape (n, i, 3).
        b: corners of the second polygons [cm], shape (n, j, 3).
    """
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
    """Coordinates of pairs of polygons, rounded to whole units."""
    largest = np.maximum(np.abs(a).max(axis=(1, 2)), np.abs(b).max(axis=(1, 2)))
    scale = UNITS / np.maximum(largest, 1e-300)[:, None, None]
    return np.rint(a * scale), np.rint(b * scale)


def _sides(a: FloatArray, u: FloatArray, b: FloatArray, later: float) -> np.ndarray:
    """Whether each corner of b lies to the left of each edge u from a in the projection, shape (n, i, j).

    ``later`` is 1 where b is the polygon that counts as moved, and -1 where a is.
    """
    x = u[:, :, None, 0] * (b[:, None, :, 1] - a[:, :, None, 1])
    y = u[:, :, None, 1] * (b[:, None, :, 0] - a[:, :, None, 0])
    on_line_left = np.where(u[..., 1] != 0.0, u[..., 1] * later < 0.0, u[..., 0] * later > 0.0)[:, :, None]
    return (x > y) | ((x == y) & on_line_left)


def _volume_signs(u: FloatArray, v: FloatArray, gap: FloatArray) -> FloatArray:
    """Signs of (u x v) . gap for whole numbers, shape (n,); where it is zero, as if gap were moved by (e, e^2, e^3)."""
    normal = np.cross(u, v)  # exact, because the products are whole numbers below 2^51
    volume = (normal * gap).sum(axis=1)
    # Bound of the rounding error of a sum of three products, over the sum of their absolute values.
    unsure = np.flatnonzero(np.abs(volume) <= 1e-15 * (np.abs(normal) * np.abs(gap)).sum(axis=1))
    whole = [values[unsure].astype(np.int64).astype(object) for values in (normal, gap)]
    signs = np.sign(volume)
    signs[unsure] = np.sign((whole[0] * whole[1]).sum(axis=1).astype(np.float64))
    for axis in range(3):
        signs = np.where(signs == 0.0, np.sign(normal[:, axis]), signs)
    return signs


def _frames(a: FloatArray) -> FloatArray:
    """Two axes of the plane of each polygon and the direction of projection, as columns, shape (n, 3, 3)."""
    spoke = a - a.mean(axis=1, keepdims=True)
    normal = np.cross(spoke, np.roll(spoke, -1, axis=1)).sum(axis=1)
    reach = spoke[np.arange(len(a)), np.linalg.norm(spoke, axis=2).argmax(axis=1)]
    across = unit_vectors(np.cross(normal, reach))
    along = unit_vectors(np.cross(across, normal))
    view = unit_vectors(unit_vectors(normal) + TURN[0] * across + TURN[1] * along)
    across = unit_vectors(np.cross(view, along))
    return np.stack([np.cross(across, view), across, view], axis=2)
