# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether yarn has passed through yarn since it was generated (a pull-through).

The generated yarns are deformed continuously into their present positions (``deformation_path``). Every crossing of
yarn through yarn on that path is found (``crossings_along_path``), and crossings that cancel each other are removed
(``cancelling_crossings``). Yarn that slides, turns or curls leaves no crossings. A pull-through leaves a crossing on
every path. The shape of a fabric does not determine the path on which it was deformed. Several paths are therefore
tried, with more or less smooth rotations. A crossing that remains in the same place on all paths is a pull-through.

Some crossings on a deformation path cancel each other. Two crossings of opposite sign between the same two stretches of
yarn can cancel: the first one makes a bight, and the second one takes it back. The two stretches between the two
crossings form a closed ring. If no other yarn passes through this ring, nothing holds the bight, and the yarns could
have slid to the same positions without crossing. One crossing alone cancels where a yarn crosses itself and its curl is
such an empty ring: the curl opens, and closes again on the other side (Reidemeister's first move).

A ring is empty if it bounds a surface that no yarn crosses. The surfaces that are tried are fans of triangles, from the
centre of the ring and from each of its points. All crossings are paired at once, so that the total length of all rings
is smallest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import min_weight_full_bipartite_matching

from stitchmesh.errors import YarnError
from stitchmesh.lattice import Lattice
from stitchmesh.linking.crossings_along_path import SampledPath, YarnCrossing
from stitchmesh.linking.deformation_path import DeformationPath
from stitchmesh.linking.yarn_polylines import SAMPLES_PER_POINT, EdgeEnds, YarnPolylines
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet

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
PATH_SETTINGS = ((5, 64), (0, 32), (5, 32), (20, 32), (0, 16), (100, 64))
"""Deformation paths that are tried: the number of smoothing steps of the rotations, and the number of control points
from which each rotation is computed."""


@dataclass(frozen=True)
class _Stretch:
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


def uncancelled(path: SampledPath) -> list[YarnCrossing]:
    """The crossings of a path that no other crossings cancel, in the order of time."""
    crossings = path.crossings
    if not crossings:
        return []
    rings = _Rings(path)
    right, left = ([k for k, crossing in enumerate(crossings) if crossing.sign == sign] for sign in (1, -1))
    curl_costs = [rings.curl_cost(crossing) for crossing in crossings]
    pairs = {
        (row, column): rings.pair_cost(crossings[right[row]], crossings[left[column]])
        for row, column in near_crossings(
            path.polylines, [crossings[k] for k in right], [crossings[k] for k in left], LONGEST_RING * rings.radius
        )
    }
    pairs = {which: cost for which, cost in pairs.items() if cost < FORBIDDEN}
    remaining = _unmatched(pairs, [curl_costs[k] for k in right], [curl_costs[k] for k in left])
    return [crossings[k] for k in sorted([right[k] for k in remaining[0]] + [left[k] for k in remaining[1]])]


def near_crossings(
    polylines: YarnPolylines, one: list[YarnCrossing], two: list[YarnCrossing], reach: float
) -> list[tuple[int, int]]:
    """Pairs of crossings that are near each other along their yarns.

    Args:
        polylines: the polylines of the yarns.
        one: the first crossings.
        two: the second crossings.
        reach: largest sum of the distances along both yarns [cm].

    Returns:
        Pairs of an index into ``one`` and an index into ``two``.
    """
    others = np.array([(crossing.first, crossing.second) for crossing in two], dtype=np.int64).reshape(-1, 2)
    pairs = []
    for number, crossing in enumerate(one):
        same = _distances_along_yarn(polylines, crossing.first, others[:, 0]) + _distances_along_yarn(
            polylines, crossing.second, others[:, 1]
        )
        crosswise = _distances_along_yarn(polylines, crossing.first, others[:, 1]) + _distances_along_yarn(
            polylines, crossing.second, others[:, 0]
        )
        pairs += [(number, int(k)) for k in np.flatnonzero(np.minimum(same, crosswise) < reach)]
    return pairs


def _distances_along_yarn(polylines: YarnPolylines, point: int, others: IntArray) -> FloatArray:
    """Length of yarn from a point to other points, the shorter way around a closed yarn [cm], shape (n,).

    It is infinite for points of other yarns.
    """
    distances = np.abs(polylines.arc_length[others] - polylines.arc_length[point])
    yarn = int(polylines.yarn[point])
    if polylines.yarns.closed[yarn]:
        begin, end = polylines.arc_length[polylines.start[yarn : yarn + 2]]
        distances = np.minimum(distances, end - begin - distances)
    return np.where(polylines.yarn[others] == yarn, distances, np.inf)


def _unmatched(
    pairs: dict[tuple[int, int], float], right: list[float], left: list[float]
) -> tuple[list[int], list[int]]:
    """Crossings that remain in the assignment of least cost.

    Each crossing is assigned to a crossing of the other sign or to itself. It remains if it is assigned to itself at
    the cost ``FORBIDDEN``.

    Args:
        pairs: cost of each pair of a right and a left crossing.
        right: cost of each right crossing alone.
        left: cost of each left crossing alone.

    Returns:
        The numbers of the remaining right crossings and of the remaining left crossings.
    """
    p, m = len(right), len(left)
    entries = [(row, column, cost) for (row, column), cost in pairs.items()]
    entries += [(p + column, m + row, FREE) for row, column in pairs]
    entries += [(row, m + row, cost) for row, cost in enumerate(right)]
    entries += [(p + column, column, cost) for column, cost in enumerate(left)]
    rows, columns, costs = np.array(entries).T
    # Largest random number that is added to a cost [radii]. Among equally long rings it selects the same one in
    # every run.
    costs += np.random.default_rng(0).uniform(0.0, 1e-6, len(costs))
    graph = coo_array((costs, (rows.astype(np.int32), columns.astype(np.int32))), shape=(p + m, m + p)).tocsr()
    row, column = min_weight_full_bipartite_matching(graph)
    remaining_right = [int(k) for k, n in zip(row, column, strict=True) if k < p and n >= m and right[k] >= FORBIDDEN]
    remaining_left = [int(n) for k, n in zip(row, column, strict=True) if k >= p and n < m and left[n] >= FORBIDDEN]
    return remaining_right, remaining_left


class _Rings:
    """Rings of yarn on a path and their cost: the length of an empty ring, ``FORBIDDEN`` for other rings."""

    def __init__(self, path: SampledPath) -> None:
        self.path, self.polylines = path, path.polylines
        self.radius = path.radius
        self.edge_at = np.full(self.polylines.start[-1], -1)
        self.edge_at[self.polylines.edges] = np.arange(len(self.polylines.edges))

    def curl_cost(self, one: YarnCrossing) -> float:
        """Cost of the curl of a yarn that crosses itself; ``FORBIDDEN`` for a crossing of two yarns."""
        yarn = int(self.polylines.yarn[one.first])
        first = self._place(one.first)
        if yarn != self.polylines.yarn[one.second]:
            return FORBIDDEN
        costs = [
            self._cost([one.time], [_Stretch(yarn, first, self._place(one.second) + turns * self._size(yarn), (0, 0))])
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

    def _rings_of(self, one: YarnCrossing, first: int, second: int, image: tuple[int, int]) -> list[list[_Stretch]]:
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
                first_stretch = _Stretch(yarns[0], begin[0], places[0], (0, 0))
                rings.append([first_stretch, _Stretch(yarns[1], places[1], begin[1], one.image)])
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

    def _cost(self, times: list[float], ring: list[_Stretch]) -> float:
        """Length of a ring [radii] if it is empty at one of the times, else ``FORBIDDEN``."""
        length = sum(self.polylines.distance(part.yarn, part.first, part.last) for part in ring) / self.radius
        if length >= LONGEST_RING or (length >= ALWAYS_EMPTY and not any(self._is_empty(time, ring) for time in times)):
            return FORBIDDEN
        return max(length, FREE)

    def _is_empty(self, time: float, ring: list[_Stretch]) -> bool:
        """Whether no yarn passes through a ring at the given time."""
        ends, lattice = self.path.at(time)
        corners = np.concatenate([self._positions(ends, lattice, part) for part in ring])
        if len(corners) < 3:
            return True
        first, second = self._edges_near(ends, lattice, corners, ring)
        return any(not _meets_fan(apex, corners, first, second) for apex in (corners.mean(axis=0), *corners))

    def _positions(self, ends: EdgeEnds, lattice: Lattice | None, part: _Stretch) -> FloatArray:
        """Sampled points of a stretch [cm], shape (n, 3)."""
        points, images = self.polylines.wrapped(part.yarn, part.between)
        positions: FloatArray = ends.first[self.edge_at[points]]
        return positions if lattice is None else positions + lattice.shift(images + part.image)

    def _edges_near(
        self, ends: EdgeEnds, lattice: Lattice | None, corners: FloatArray, ring: list[_Stretch]
    ) -> tuple[FloatArray, FloatArray]:
        """Ends of the edges near a ring that do not belong to the ring [cm], shape (n, 3) each."""
        middle = corners.mean(axis=0)
        reach = np.linalg.norm(corners - middle, axis=1).max() + np.linalg.norm(ends.second - ends.first, axis=1).max()
        images = [(0, 0)]
        if lattice is not None:
            images = [(a, b) for a, b in lattice.near_images(np.concatenate([ends.first, corners]), reach).tolist()]
        found = []
        for image in images:
            shift = np.zeros(3) if lattice is None else lattice.shift(image)
            near_edges = np.flatnonzero(((ends.first + shift - middle) ** 2).sum(axis=1) < reach**2)
            near_edges = np.setdiff1d(near_edges, [edge for part in ring for edge in self._own_edges(part, image)])
            found.append((ends.first[near_edges] + shift, ends.second[near_edges] + shift))
        return np.concatenate([first for first, _ in found]), np.concatenate([second for _, second in found])

    def _own_edges(self, part: _Stretch, image: tuple[int, int]) -> IntArray:
        """Edges of a stretch and beside it that lie in the given lattice image."""
        low, high = sorted((part.first, part.last))
        places = np.arange(low - EXEMPT_POINTS, high + EXEMPT_POINTS + 1)
        if not self.polylines.yarns.closed[part.yarn]:
            places = places[(places >= 0) & (places < self._size(part.yarn))]
        points, images = self.polylines.wrapped(part.yarn, places)
        edges = self.edge_at[points[(images + part.image == image).all(axis=1)]]
        return edges[edges >= 0]


def _meets_fan(apex: FloatArray, corners: FloatArray, first: FloatArray, second: FloatArray) -> bool:
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


def pulled_through(generated: YarnSet, yarns: YarnSet) -> list[YarnCrossing]:
    """Crossings of yarn through yarn that remain on every deformation path.

    Args:
        generated: the yarns as generated.
        yarns: the same yarns at their present positions.

    Returns:
        The remaining crossings on the last path, by sampled points of ``YarnPolylines``; empty if there are none.
    """
    # Yarns that moved less than this, over the yarn radius, count as unmoved.
    if np.abs(generated.points - yarns.points).max() < 1e-3 * yarns.radius.min():
        return []
    polylines, reach = YarnPolylines(generated), LONGEST_RING * float(yarns.radius.mean())
    remaining: list[YarnCrossing] | None = None
    for smoothing_steps, neighbour_count in PATH_SETTINGS:
        found = uncancelled(SampledPath.along(DeformationPath(generated, yarns, smoothing_steps, neighbour_count)))
        if remaining is not None:
            found = [remaining[k] for k in sorted({k for k, _ in near_crossings(polylines, remaining, found, reach)})]
        remaining = found
        if not remaining:
            break
    return remaining or []


def check_pulled_through(generated: YarnSet, yarns: YarnSet) -> None:
    """Check that no yarn has passed through yarn.

    Args:
        generated: the yarns as generated.
        yarns: the same yarns at their present positions.

    Raises:
        YarnError: a yarn has passed through another one; the message names the faces of both.
    """
    found = pulled_through(generated, yarns)
    if found:
        faces = [int(yarns.face[point // SAMPLES_PER_POINT]) for point in (found[0].first, found[0].second)]
        raise YarnError(
            f"face {faces[0]}: its yarn passed through that of face {faces[1]} since it was generated ({len(found)} "
            "such crossings); expected none, relax the generated yarns again"
        )
