# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How near yarns come to one another and to themselves."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet

SAMPLES = 4
"""Points a segment at which distances are taken."""
NEIGHBOURS = 2
"""Segments of one yarn that share control points and do not collide, either way along it."""
HERE = np.zeros(2, dtype=np.int64)
"""The image of the cell itself."""


def smallest_distance(yarns: YarnSet, within: float) -> tuple[float, int]:
    """Smallest distance [cm] between points of segments that may touch, and a control point there.

    Args:
        yarns: any yarns; on a lattice all their images count.
        within: distance to look [cm]; where nothing lies so near, the answer is infinity.
    """
    points = np.concatenate([curve[: len(curve) // SAMPLES * SAMPLES] for curve in yarns.sampled(SAMPLES)])
    segment = np.repeat(np.arange(len(yarns.segment_yarn)), SAMPLES)
    pairs, image, distance = _near_pairs(yarns.lattice, points, within)
    apart = may_touch(yarns, segment[pairs[:, 0]], segment[pairs[:, 1]], image)
    if not apart.any():
        return np.inf, 0
    nearest = int(np.where(apart, distance, np.inf).argmin())
    return float(distance[nearest]), int(yarns.segment_points[segment[pairs[nearest, 0]], 1])


def may_touch(yarns: YarnSet, first: np.ndarray, second: np.ndarray, image: IntArray = HERE) -> np.ndarray:
    """Whether segments are of two yarns, or far enough apart along one to collide.

    Args:
        yarns: any yarns.
        first: segments in the cell, shape (n,).
        second: segments, shape (n,).
        image: lattice image in which each second one lies, seen from the first, shape (n, 2); its own if not given.
    """
    yarn = yarns.segment_yarn
    size, own, closed = np.diff(yarns.segment_start)[yarn[first]], yarn[first], yarns.closed[yarn[first]]
    step = np.zeros((yarns.yarn_count, 2), dtype=np.int64) if yarns.lattice_step is None else yarns.lattice_step
    beside = np.zeros(len(first), dtype=bool)
    for turn in (-1, 0, 1):  # once more around a closed yarn
        reached = (turn * step[own] == image).all(axis=1) & (closed | (turn == 0))
        beside |= reached & (np.abs(first - second - turn * size) <= NEIGHBOURS)
    return (yarn[second] != own) | ~beside


def _near_pairs(lattice: Lattice | None, points: FloatArray, within: float) -> tuple[IntArray, IntArray, FloatArray]:
    """Pairs of points that lie near one another in some image, each once.

    Returns:
        Their numbers, shape (n, 2), the image in which the second one lies, shape (n, 2), and their distance [cm].
    """
    if lattice is None:
        pairs = cKDTree(points).query_pairs(within, output_type="ndarray")
        return pairs, np.zeros_like(pairs), np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    own = lattice.image_of(points)
    inside = points - lattice.shift(own)
    tree, found = cKDTree(inside), []
    for image in lattice.near_images(inside, within):
        if tuple(image) >= (0, 0):  # of two opposite images one will do
            moved = cKDTree(inside + lattice.shift(image))
            near = tree.sparse_distance_matrix(moved, within, output_type="ndarray")
            near = near[near["i"] < near["j"]] if not image.any() else near
            pairs = np.stack([near["i"], near["j"]], axis=1)
            found.append((pairs, image + own[pairs[:, 0]] - own[pairs[:, 1]], near["v"]))
    pairs, images, distances = (np.concatenate(column) for column in zip(*found, strict=True))
    return pairs, images, distances
