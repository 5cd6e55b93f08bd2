# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rings that stretches of yarn form between crossings, and whether yarn passes through them.

A ring is empty if it bounds a surface that no yarn crosses. The surfaces that are tried are fans of triangles, from the
centre of the ring and from each of its points.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stitchmesh.linking.crossings_along_path import SampledPath, YarnCrossing
from stitchmesh.linking.yarn_polylines import EdgeEnds, YarnPolylines
from stitchmesh.mesh import FloatArray, IntArray

BOUND_OFFSET = 1e-6
"""Added to bounds that are round numbers, because lengths of regular yarns can be round numbers and must not lie
exactly at a bound."""
LONGEST_RING = 48.0 + BOUND_OFFSET
"""Longest ring that is considered [radii]: one and a half loops of ordinary tightness."""
ALWAYS_EMPTY = 4.0 + BOUND_OFFSET
"""Rings shorter than this are always empty [radii]: a ring around a yarn is at least pi times as long."""
EXEMPT_POINTS = 2
"""Number of sampled points of the same yarn on either side of a ring that may touch its surface."""
TESTED_FRACTIONS = (0.5, 0.25, 0.75)
"""Times at which a ring is tested, as fractions of the time between its two crossings. A ring that is empty at one of
these times can be opened then."""
FORBIDDEN, FREE = 1e6, 1e-6
"""Cost of a crossing that nothing cancels, and of an empty assignment, in yarn radii."""


@dataclass(frozen=True)
class Stretch:
    """A stretch of yarn between two edges, in one lattice image."""

    yarn: int
    """Number of the yarn."""
    first: int
    """Index along the yarn of the first point of the first edge."""
    last: int
    """Index along the yarn of the first point of the last edge."""
    image: tuple[int, int]
    """Lattice image of the stretch."""

    @property
    def between(self) -> IntArray:
        """Indices along the yarn of the points between the two edges, in order."""
        if self.last >= self.first:
            return np.arange(self.first + 1, self.last + 1)
        return np.arange(self.first, self.last, -1)


@dataclass(frozen=True, eq=False)
class Rings:
    """Rings of yarn on a path and their cost: the length of an empty ring, ``FORBIDDEN`` for other rings."""

    path: SampledPath
    """The path."""

    @property
    def polylines(self) -> YarnPolylines:
        """The polylines of the yarns."""
        return self.path.polylines

    @cached_property
    def edge_at(self) -> IntArray:
        """The edge that starts at each sampled point, or -1, shape (n,)."""
        edges = np.full(self.polylines.start[-1], -1)
        edges[self.polylines.edges] = np.arange(len(self.polylines.edges))
        return edges

    def curl_cost(self, one: YarnCrossing) -> float:
        """Cost of the curl of a yarn that crosses itself; ``FORBIDDEN`` for a crossing of two yarns."""
        yarn = int(self.polylines.yarn[one.first])
        first = self._place(one.first)
        if yarn != self.polylines.yarn[one.second]:
            return FORBIDDEN
        costs = [
            self._cost([one.time], [Stretch(yarn, first, self._place(one.second) + turns * self._size(yarn), (0, 0))])
            for turns in self._turns(yarn, one.image, first - self._place(one.second))
        ]
        return min(costs, default=FORBIDDEN)

    def pair_cost(self, right: YarnCrossing, left: YarnCrossing) -> float:
        """Cost of the ring between two crossings of opposite sign."""
        opposite_image = (-left.image[0], -left.image[1])
        partners = [(left.first, left.second, left.image), (left.second, left.first, opposite_image)]
        times = [right.time + part * (left.time - right.time) for part in TESTED_FRACTIONS]
        return min(
            (self._cost(times, ring) for partner in partners for ring in self._rings_of(right, *partner)),
            default=FORBIDDEN,
        )

    def _rings_of(self, one: YarnCrossing, first: int, second: int, image: tuple[int, int]) -> list[list[Stretch]]:
        """Rings from a crossing to another one, whatever the lattice images.

        Args:
            one: the first crossing.
            first: sampled point of the edge of the other crossing that belongs to the first yarn.
            second: sampled point of the edge of the other crossing that belongs to the second yarn.
            image: lattice image of the second edge of the other crossing, seen from its first edge.
        """
        yarns = [int(self.polylines.yarn[point]) for point in (one.first, one.second)]
        if yarns != [int(self.polylines.yarn[point]) for point in (first, second)]:
            return []
        begin = [self._place(one.first), self._place(one.second)]
        end = [self._place(first), self._place(second)]
        rings = []
        for turns in self._near_turns(yarns[0], begin[0] - end[0]):
            moved = turns * self.polylines.step[yarns[0]] + image - one.image
            for more in self._turns(yarns[1], moved, begin[1] - end[1]):
                places = [end[0] + turns * self._size(yarns[0]), end[1] + more * self._size(yarns[1])]
                first_stretch = Stretch(yarns[0], begin[0], places[0], (0, 0))
                rings.append([first_stretch, Stretch(yarns[1], places[1], begin[1], one.image)])
        return rings

    def _turns(self, yarn: int, image: IntArray | tuple[int, int], offset: int) -> list[int]:
        """Turns along a yarn that lead into a lattice image.

        For a yarn without a lattice step, these are the turns that come near the given offset.
        """
        step = self.polylines.step[yarn]
        if not step.any():
            return self._near_turns(yarn, offset) if not np.any(image) else []
        turns = int(round(float(np.dot(image, step) / np.dot(step, step))))
        return [turns] if np.array_equal(turns * step, image) else []

    def _near_turns(self, yarn: int, offset: int) -> list[int]:
        """Turns along a yarn that come near an offset, given in sampled points."""
        if not self.polylines.yarns.closed[yarn]:
            return [0]
        nearest = round(offset / self._size(yarn))
        return [nearest - 1, nearest, nearest + 1]

    def _place(self, point: int) -> int:
        """Index of a sampled point along its yarn."""
        return point - int(self.polylines.start[self.polylines.yarn[point]])

    def _size(self, yarn: int) -> int:
        """Number of sampled points of a yarn."""
        return int(self.polylines.start[yarn + 1] - self.polylines.start[yarn])

    def _cost(self, times: list[float], ring: list[Stretch]) -> float:
        """Length of a ring [radii] if it is empty at one of the times, else ``FORBIDDEN``."""
        length = sum(self.polylines.distance(part.yarn, part.first, part.last) for part in ring) / self.path.radius
        if length >= LONGEST_RING or (length >= ALWAYS_EMPTY and not any(self._is_empty(time, ring) for time in times)):
            return FORBIDDEN
        return max(length, FREE)

    def _is_empty(self, time: float, ring: list[Stretch]) -> bool:
        """Whether no yarn passes through a ring at the given time."""
        ends = self.path.at(time)
        corners = np.concatenate([self._positions(ends, part) for part in ring])
        if len(corners) < 3:
            return True
        first, second = self._edges_near(ends, corners, ring)
        return any(not meets_fan(apex, corners, first, second) for apex in (corners.mean(axis=0), *corners))

    def _positions(self, ends: EdgeEnds, part: Stretch) -> FloatArray:
        """Sampled points of a stretch [cm], shape (n, 3)."""
        points, images = self.polylines.wrapped(part.yarn, part.between)
        positions: FloatArray = ends.first[self.edge_at[points]] + ends.shift(images + part.image)
        return positions

    def _edges_near(
        self, ends: EdgeEnds, corners: FloatArray, ring: list[Stretch]
    ) -> tuple[FloatArray, FloatArray]:
        """Ends of the edges near a ring that do not belong to the ring [cm], shape (n, 3) each."""
        middle = corners.mean(axis=0)
        reach = np.linalg.norm(corners - middle, axis=1).max() + np.linalg.norm(ends.second - ends.first, axis=1).max()
        images = [(0, 0)]
        if ends.lattice is not None:
            places = np.concatenate([ends.first, corners])
            images = [(a, b) for a, b in ends.lattice.near_images(places, reach).tolist()]
        found = []
        for image in images:
            shift = ends.shift(image)
            near_edges = np.flatnonzero(((ends.first + shift - middle) ** 2).sum(axis=1) < reach**2)
            near_edges = np.setdiff1d(near_edges, [edge for part in ring for edge in self._own_edges(part, image)])
            found.append((ends.first[near_edges] + shift, ends.second[near_edges] + shift))
        return np.concatenate([first for first, _ in found]), np.concatenate([second for _, second in found])

    def _own_edges(self, part: Stretch, image: tuple[int, int]) -> IntArray:
        """Edges of a stretch and beside it that lie in the given lattice image."""
        low, high = sorted((part.first, part.last))
        places = np.arange(low - EXEMPT_POINTS, high + EXEMPT_POINTS + 1)
        if not self.polylines.yarns.closed[part.yarn]:
            places = places[(places >= 0) & (places < self._size(part.yarn))]
        points, images = self.polylines.wrapped(part.yarn, places)
        edges = self.edge_at[points[(images + part.image == image).all(axis=1)]]
        return edges[edges >= 0]


def meets_fan(apex: FloatArray, corners: FloatArray, first: FloatArray, second: FloatArray) -> bool:
    """Whether any edge passes through a triangle of an apex and two successive corners.

    Two triangles meet at each spoke. The side on which an edge passes a spoke is computed once for both of them. The
    sides on which the points of two successive edges lie are computed by the same operations. Rounding therefore opens
    no gap between triangles or between edges.

    Args:
        apex: apex of the fan [cm], shape (3,).
        corners: corners of the fan [cm], shape (n, 3).
        first: first ends of the edges [cm], shape (m, 3).
        second: second ends of the edges [cm], shape (m, 3).
    """
    spokes, begin, end = corners - apex, first - apex, second - apex
    normal = np.cross(spokes, np.roll(spokes, -1, axis=0))
    low, high = (_products(normal, side) for side in (begin, end))
    spoke_side = _products(spokes, np.cross(begin, end))
    next_side = np.roll(spoke_side, -1, axis=0)
    rim_side = high - low + next_side - spoke_side
    inside = ((spoke_side > 0.0) != (next_side > 0.0)) & ((spoke_side > 0.0) == (rim_side > 0.0))
    return bool((inside & ((low > 0.0) != (high > 0.0))).any())


def _products(one: FloatArray, two: FloatArray) -> FloatArray:
    """Scalar products of all pairs, shapes (n, 3) and (m, 3) to (n, m).

    Each product uses the same sequence of operations, whatever its position in the array.
    """
    products: FloatArray = sum(np.multiply.outer(a, b) for a, b in zip(one.T, two.T, strict=True))
    return products
