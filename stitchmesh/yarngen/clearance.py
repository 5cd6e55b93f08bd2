# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Smallest distances between yarns, and between distant parts of one yarn."""

from __future__ import annotations

import numpy as np

from stitchmesh.compute.threads import each_block
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet

SAMPLES_PER_SEGMENT = 4
"""Number of points of each segment between which distances are measured."""
BITS = 20
CELLS = 2**BITS - 2
"""Largest number of cells of a grid along an axis, so that the cells beside a cell have numbers of 64 bits too."""
POINTS_OF_BLOCK = 65536
"""Points for which pairs are searched at once."""
SAME_IMAGE = np.zeros(2, dtype=np.int64)
"""The lattice image of the cell itself."""


def smallest_distance(yarns: YarnSet, within: float) -> tuple[float, tuple[int, int]]:
    """Smallest distance [cm] between sample points of segments that may touch, and a control point of either segment.

    Args:
        yarns: the yarns; on a lattice, distances to all images are measured too.
        within: largest distance that is searched [cm].

    Returns:
        The distance [cm] and the numbers of two control points; infinity and 0 where no distance is at most ``within``.
    """
    segments, distance = _pairs_that_may_touch(yarns, within)
    if not len(segments):
        return np.inf, (0, 0)
    nearest = int(distance.argmin())
    one, other = yarns.segment_points[segments[nearest], 1].tolist()
    return float(distance[nearest]), (one, other)


def crowded_points(yarns: YarnSet, within: float) -> IntArray:
    """Return control points at all places where segments that may touch are closer than a distance [cm]."""
    segments, _ = _pairs_that_may_touch(yarns, within)
    return np.unique(yarns.segment_points[segments, 1])


def _pairs_that_may_touch(yarns: YarnSet, within: float) -> tuple[IntArray, FloatArray]:
    """Segments with sample points that are close, shape (n, 2), and the distances of the points [cm], shape (n,)."""
    pairs, image, distance = _pairs_within(yarns.lattice, yarns.samples(SAMPLES_PER_SEGMENT), within)
    segments = pairs // SAMPLES_PER_SEGMENT
    touching = may_touch(yarns, segments[:, 0], segments[:, 1], image)
    return segments[touching], distance[touching]


def may_touch(yarns: YarnSet, first: np.ndarray, second: np.ndarray, image: IntArray = SAME_IMAGE) -> np.ndarray:
    """Whether pairs of segments may touch: segments of different yarns, or segments far enough apart along one yarn.

    Args:
        yarns: the yarns.
        first: first segment of each pair, in the cell, shape (n,).
        second: second segment of each pair, shape (n,).
        image: lattice image of the second segment, seen from the first, shape (n, 2) or (2,).

    Returns:
        One truth value for each pair, shape (n,).
    """
    yarn = yarns.segment_yarn
    size, yarn_of_first, closed = np.diff(yarns.segment_start)[yarn[first]], yarn[first], yarns.closed[yarn[first]]
    step = np.zeros((yarns.yarn_count, 2), dtype=np.int64) if yarns.lattice_step is None else yarns.lattice_step
    is_excluded = np.zeros(len(first), dtype=bool)
    for turns in (-1, 0, 1):  # the second segment may also lie one turn further around a closed yarn
        same_place = (turns * step[yarn_of_first] == image).all(axis=1) & (closed | (turns == 0))
        # Segments of one yarn that are up to this many segments apart share control points and are not tested
        # against each other.
        is_excluded |= same_place & (np.abs(first - second - turns * size) <= 2)
    return (yarn[second] != yarn_of_first) | ~is_excluded


def _pairs_within(lattice: Lattice | None, points: FloatArray, within: float) -> tuple[IntArray, IntArray, FloatArray]:
    """Pairs of points that are near each other in some lattice image. Each pair is found once.

    Returns:
        The numbers of the two points, shape (n, 2), the lattice image of the second point, seen from the first, shape
        (n, 2), and their distance [cm], shape (n,).
    """
    if lattice is None:
        pairs, distance = near_pairs(points, within)
        return pairs, np.zeros_like(pairs), distance
    count, home = len(points), lattice.image_of(points)
    inside = points - lattice.shift(home)
    low, high = inside.min(axis=0) - within, inside.max(axis=0) + within
    copies, numbers, images = [inside], [np.arange(count)], [np.zeros_like(home)]
    for image in lattice.near_images(inside, within):
        if tuple(image) <= (0, 0):  # the opposite image holds the same pairs
            continue
        moved = inside + lattice.shift(image)
        beside = np.flatnonzero(((moved >= low) & (moved <= high)).all(axis=1))
        copies.append(moved[beside])
        numbers.append(beside)
        images.append(np.broadcast_to(image, (len(beside), 2)))
    pairs, distance = near_pairs(np.concatenate(copies), within)
    own = pairs[:, 0] < count
    pairs, distance = pairs[own], distance[own]
    number, image = np.concatenate(numbers)[pairs], np.concatenate(images)[pairs[:, 1]]
    return number, image + home[number[:, 0]] - home[number[:, 1]], distance


def near_pairs(points: FloatArray, within: float) -> tuple[IntArray, FloatArray]:
    """Pairs of points that are at most a distance apart. Each pair is found once.

    The points are sorted by cells of a grid, along x first. The cells beside a cell are five runs of the sorted points:
    the points after it up to the next cell, and three cells in each of four of the other rows beside its own; a point
    in any other cell beside it finds the pair itself.

    Args:
        points: the points [cm], shape (N, 3).
        within: largest distance of a pair [cm].

    Returns:
        The numbers of the two points, the smaller one first, shape (n, 2), and their distances [cm], shape (n,).
    """
    lowest = np.array([column.min() for column in points.T])
    extent = max(float(column.max()) - least for column, least in zip(points.T, lowest, strict=True))
    cell = ((points - lowest) / max(within, extent / CELLS)).astype(np.int64)
    row, layer = 2**BITS, 2 ** (2 * BITS)
    key = cell[:, 2] * layer + cell[:, 1] * row + cell[:, 0]
    order = np.argsort(key, kind="stable")
    key = key[order]

    def search(some: slice) -> tuple[IntArray, FloatArray]:
        """Find the pairs whose first point, in the order of the cells, is one of these."""
        own, number = key[some], np.arange(some.start, some.stop)
        runs = [(number + 1, own + 1)]
        for beside in (row, layer - row, layer, layer + row):
            runs.append((np.searchsorted(key, own + (beside - 1)), own + (beside + 1)))
        found = [_pairs_in_runs(number, first, last, key) for first, last in runs]
        pairs = order[np.concatenate(found)]
        distance = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
        return pairs[distance <= within], distance[distance <= within]

    blocks = each_block(search, len(points), POINTS_OF_BLOCK)
    pairs, distances = (np.concatenate(column) for column in zip(*blocks, strict=True))
    return np.sort(pairs, axis=1), distances


def _pairs_in_runs(number: IntArray, first: IntArray, last: IntArray, key: IntArray) -> IntArray:
    """Pairs of each point with all points of a run: from a place in the sorted points to the last one of a cell.

    Args:
        number: the points, as places in ``key``, shape (n,).
        first: the first place of each run, shape (n,).
        last: cell of the last points of each run, shape (n,).
        key: cells of all points, ascending, shape (N,).
    """
    is_filled = first < len(key)
    is_filled[is_filled] = key[first[is_filled]] <= last[is_filled]
    number, first = number[is_filled], first[is_filled]
    count = np.searchsorted(key, last[is_filled], side="right") - first
    place = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    return np.stack([np.repeat(number, count), np.repeat(first, count) + place], axis=1)
