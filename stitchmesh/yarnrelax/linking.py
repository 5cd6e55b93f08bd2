# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The linking certificate: which yarns are linked, as exact integers.

The linking number of two closed curves is half the sum of the signs of their crossings in a projection, and cannot
change unless one passes through the other. Yarns are taken as polylines of SAMPLES points a segment and projected along
a fixed direction that no mesh axis shares; crossings are found in a plane grid, in time near linear in the points.

Open yarns are closed far away: from each end a straight line runs outwards, away from the middle of all yarns as seen
in the projection, and beyond everything an arc joins the two lines, above all yarns and above the lines of the yarns
that follow. The closing is no yarn, and others may move through it: the linking of an open yarn tells how it lies, but
only that of two closed yarns is a certificate, which no motion without pull-through can change.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet

SAMPLES = 4
"""Polyline points a segment; its chords stay within a few hundredths of a radius of the curve."""
CHUNK = 4_000_000
"""Pairs of edges looked at together, which bounds the memory to a few hundred MB."""
DIRECTION = np.array([0.2911, 0.1727, 0.9410])
"""Direction of the projection."""


@dataclass(frozen=True, eq=False)
class _Edges:
    """Directed edges of all yarns, seen along the projection: two coordinates and a height."""

    tail: FloatArray
    head: FloatArray
    yarn: IntArray


def linking_certificate(yarns: YarnSet) -> csr_array:
    """Linking numbers of all pairs of yarns, a symmetric integer matrix of shape (Y, Y); the diagonal is zero.

    Args:
        yarns: closed or open yarns, without a lattice.

    Raises:
        ParameterError: the yarns have a lattice.
    """
    if yarns.lattice is not None:
        raise ParameterError("linking certificate: got yarns with a lattice; expected a set without one")
    axes = _projection()
    middle = (yarns.points.min(axis=0) + yarns.points.max(axis=0)) / 2 @ axes.T
    edges, angles = _closed_polylines(yarns, axes, middle)
    over, under, sign = _crossings(_split(edges))
    size = (yarns.yarn_count, yarns.yarn_count)
    total = coo_array((sign, (over, under)), shape=size).tocsr() + _far_crossings(angles, yarns.yarn_count)
    total = total + total.T
    total.data //= 2  # closed curves cross an even number of times
    total.eliminate_zeros()
    return total


def changed_pairs(before: csr_array, after: csr_array) -> IntArray:
    """Pairs of yarns whose linking numbers differ, shape (n, 2), each pair once."""
    difference = (before - after).tocoo()
    mask = (difference.data != 0) & (difference.row < difference.col)
    return np.stack([difference.row[mask], difference.col[mask]], axis=1)


def _projection() -> FloatArray:
    """Rows: two axes of the picture plane and the direction towards the eye."""
    towards = DIRECTION / np.linalg.norm(DIRECTION)
    right = np.cross([0.0, 1.0, 0.0], towards)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(towards, right), towards])


def _closed_polylines(
    yarns: YarnSet, axes: FloatArray, middle: FloatArray
) -> tuple[_Edges, dict[int, tuple[float, float]]]:
    """All edges up to the far arcs, and between which angles the arc of each open yarn runs."""
    curves = [curve @ axes.T - middle for curve in yarns.sampled(SAMPLES)]
    far = 2.0 * max(np.linalg.norm(curve[:, :2], axis=1).max() for curve in curves)
    angles: dict[int, tuple[float, float]] = {}
    loops = []
    for yarn, curve in enumerate(curves):
        if yarns.closed[yarn]:
            loops.append(np.concatenate([curve, curve[:1]]))
            continue
        first, last = curve[0], curve[-1]
        loops.append(np.stack([_outside(first, far), *curve, _outside(last, far)]))
        angles[yarn] = (float(np.arctan2(last[1], last[0])), float(np.arctan2(first[1], first[0])))
    owner = np.repeat(np.arange(len(loops)), [len(loop) - 1 for loop in loops])
    edges = _Edges(np.concatenate([p[:-1] for p in loops]), np.concatenate([p[1:] for p in loops]), owner)
    return edges, angles


def _outside(end: FloatArray, far: float) -> FloatArray:
    """Where the line from the middle through an end leaves the circle that holds everything."""
    distance = np.hypot(end[0], end[1])
    return end * (far / distance) if distance > 0.0 else np.array([far, 0.0, 0.0])


def _split(edges: _Edges) -> _Edges:
    """Cut edges that are much longer than the others into straight pieces, so that a grid of one size serves all."""
    span = edges.head - edges.tail
    length = np.hypot(span[:, 0], span[:, 1])
    pieces = np.maximum(np.ceil(length / (2.0 * np.median(length) + 1e-300)), 1).astype(np.int64)
    pieces = np.minimum(pieces, 100_000)
    owner = np.repeat(np.arange(len(pieces)), pieces)
    place = np.arange(len(owner)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    tail = edges.tail[owner] + span[owner] * (place / pieces[owner])[:, None]
    head = edges.tail[owner] + span[owner] * ((place + 1) / pieces[owner])[:, None]
    final = place + 1 == pieces[owner]
    head[final] = edges.head[owner[final]]
    return _Edges(tail, head, edges.yarn[owner])


def _crossings(edges: _Edges) -> tuple[IntArray, IntArray, IntArray]:
    """Upper yarn, lower yarn and sign of every crossing of two yarns."""
    found = [_cross(edges, first, second) for first, second in _near_pairs(edges)]
    if not found:
        nothing = np.zeros(0, dtype=np.int64)
        return nothing, nothing, nothing
    over, under, sign = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return over, under, sign


def _near_pairs(edges: _Edges) -> Iterator[tuple[IntArray, IntArray]]:
    """Pairs of edges of different yarns whose boxes overlap in the picture, in chunks, each pair once."""
    low = np.minimum(edges.tail[:, :2], edges.head[:, :2])
    high = np.maximum(edges.tail[:, :2], edges.head[:, :2])
    size = float((high - low).max())
    cell = np.floor((low - low.min(axis=0)) / (size if size > 0.0 else 1.0)).astype(np.int64)
    columns = int(cell[:, 0].max()) + 3
    key = (cell[:, 1] + 1) * columns + cell[:, 0] + 1
    order = np.argsort(key, kind="stable")
    key = key[order]
    # an edge starts in its cell and ends at most one farther, so half of the neighbouring cells suffice
    for offset in (0, 1, columns - 1, columns, columns + 1):
        start, stop = np.searchsorted(key, key + offset, "left"), np.searchsorted(key, key + offset, "right")
        if offset == 0:
            start = np.arange(len(key)) + 1
        for rows in _chunks(np.maximum(stop - start, 0)):
            first, second = _expand(rows, start, stop)
            first, second = order[first], order[second]
            keep = (edges.yarn[first] != edges.yarn[second]) & (low[first] <= high[second]).all(axis=1)
            keep &= (low[second] <= high[first]).all(axis=1)
            if keep.any():
                yield first[keep], second[keep]


def _chunks(counts: IntArray) -> Iterator[slice]:
    """Slices of rows that hold about ``CHUNK`` pairs each."""
    total = np.cumsum(counts)
    bounds = np.searchsorted(total, np.arange(CHUNK, total[-1] + CHUNK, CHUNK)) + 1
    begin = 0
    for end in np.unique(np.minimum(bounds, len(counts))):
        yield slice(begin, int(end))
        begin = int(end)


def _expand(rows: slice, start: IntArray, stop: IntArray) -> tuple[IntArray, IntArray]:
    """All pairs of a row and a number from its start up to its stop."""
    counts = np.maximum(stop[rows] - start[rows], 0)
    first = np.repeat(np.arange(rows.start, rows.stop), counts)
    place = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    return first, np.repeat(start[rows], counts) + place


def _cross(edges: _Edges, first: IntArray, second: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Upper yarn, lower yarn and sign where two edges cross."""
    a, b, c, d = edges.tail[first], edges.head[first], edges.tail[second], edges.head[second]
    side_c, side_d, side_a, side_b = _side(a, b, c), _side(a, b, d), _side(c, d, a), _side(c, d, b)
    # a point on a line counts to its right side, for both edges that share it
    hit = np.flatnonzero(((side_c > 0) != (side_d > 0)) & ((side_a > 0) != (side_b > 0)))
    along = (side_a / (side_a - side_b + (side_a == side_b)))[hit]
    across = (side_c / (side_c - side_d + (side_c == side_d)))[hit]
    height = a[hit, 2] + along * (b - a)[hit, 2] - c[hit, 2] - across * (d - c)[hit, 2]
    turn = np.where(side_d[hit] > 0, 1, -1)  # +1 where the second edge crosses the first from right to left
    above = height > 0
    one, two = edges.yarn[first[hit]], edges.yarn[second[hit]]
    return np.where(above, one, two), np.where(above, two, one), np.where(above, turn, -turn)


def _side(a: FloatArray, b: FloatArray, p: FloatArray) -> NDArray[np.float64]:
    """Positive where p lies left of the line from a to b in the picture."""
    return (b[:, 0] - a[:, 0]) * (p[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (p[:, 0] - a[:, 0])


def _far_crossings(angles: dict[int, tuple[float, float]], count: int) -> csr_array:
    """Signs where the arc of one open yarn passes above the two lines of a later one."""
    if len(angles) < 2:
        return coo_array((count, count), dtype=np.int64).tocsr()
    yarn = np.array(sorted(angles), dtype=np.int64)
    begin, end = np.array([angles[y] for y in yarn]).T
    low, high, way = np.minimum(begin, end), np.maximum(begin, end), np.where(end > begin, 1, -1)
    rows, columns, signs = [], [], []
    for place in range(len(yarn) - 1):
        later = slice(place + 1, None)
        # the arc turns counter-clockwise (way 1): a line that leaves outwards passes it from left to right
        leaves = (low[place] < begin[later]) & (begin[later] < high[place])
        returns = (low[place] < end[later]) & (end[later] < high[place])
        sign = way[place] * (returns.astype(np.int64) - leaves.astype(np.int64))
        other = np.flatnonzero(sign)
        rows.append(np.full(len(other), yarn[place]))
        columns.append(yarn[later][other])
        signs.append(sign[other])
    places = (np.concatenate(rows), np.concatenate(columns))
    return coo_array((np.concatenate(signs), places), shape=(count, count)).tocsr()
