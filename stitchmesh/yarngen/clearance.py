# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Smallest distances between yarns, and between distant parts of one yarn."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet

SAMPLES_PER_SEGMENT = 4
"""Number of points of each segment between which distances are measured."""
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
    points = np.concatenate(
        [
            curve[: len(curve) // SAMPLES_PER_SEGMENT * SAMPLES_PER_SEGMENT]
            for curve in yarns.sampled(SAMPLES_PER_SEGMENT)
        ]
    )
    segment = np.repeat(np.arange(len(yarns.segment_yarn)), SAMPLES_PER_SEGMENT)
    pairs, image, distance = _pairs_within(yarns.lattice, points, within)
    touching = may_touch(yarns, segment[pairs[:, 0]], segment[pairs[:, 1]], image)
    return segment[pairs[touching]], distance[touching]


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
        pairs = cKDTree(points).query_pairs(within, output_type="ndarray")
        return pairs, np.zeros_like(pairs), np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    yarn_of_first = lattice.image_of(points)
    inside = points - lattice.shift(yarn_of_first)
    tree, low, high, found = cKDTree(inside), inside.min(axis=0) - within, inside.max(axis=0) + within, []
    for image in lattice.near_images(inside, within):
        if tuple(image) < (0, 0):  # the opposite image holds the same pairs
            continue
        shift = lattice.shift(image)
        if image.any():
            moved = inside + shift
            beside = np.flatnonzero(((moved >= low) & (moved <= high)).all(axis=1))
            near = tree.sparse_distance_matrix(cKDTree(moved[beside]), within, output_type="ndarray")
            pairs = np.stack([near["i"], beside[near["j"]]], axis=1)
        else:
            pairs = tree.query_pairs(within, output_type="ndarray")
        distance = np.linalg.norm(inside[pairs[:, 0]] - inside[pairs[:, 1]] - shift, axis=1)
        found.append((pairs, image + yarn_of_first[pairs[:, 0]] - yarn_of_first[pairs[:, 1]], distance))
    pairs, images, distances = (np.concatenate(column) for column in zip(*found, strict=True))
    return pairs, images, distances
