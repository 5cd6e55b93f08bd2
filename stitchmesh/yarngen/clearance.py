# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How near yarns come to one another and to themselves."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.yarn import YarnSet

SAMPLES = 4
"""Points a segment at which distances are taken."""
NEIGHBOURS = 2
"""Segments of one yarn that share control points and do not collide, either way along it."""


def smallest_distance(yarns: YarnSet, within: float) -> tuple[float, int]:
    """Smallest distance [cm] between points of segments that may touch, and a control point there.

    Args:
        yarns: any yarns.
        within: distance to look [cm]; where nothing lies so near, the answer is infinity.
    """
    points = np.concatenate([curve[: len(curve) // SAMPLES * SAMPLES] for curve in yarns.sampled(SAMPLES)])
    segment = np.repeat(np.arange(len(yarns.segment_yarn)), SAMPLES)
    pairs = cKDTree(points).query_pairs(within, output_type="ndarray")
    pairs = pairs[may_touch(yarns, segment[pairs[:, 0]], segment[pairs[:, 1]])]
    if len(pairs) == 0:
        return np.inf, 0
    distance = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    nearest = int(distance.argmin())
    return float(distance[nearest]), int(yarns.segment_points[segment[pairs[nearest, 0]], 1])


def may_touch(yarns: YarnSet, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Whether segments are of two yarns, or far enough apart along one to collide."""
    yarn = yarns.segment_yarn
    size = np.diff(yarns.segment_start)[yarn[first]]
    apart = np.abs(first - second)
    around = np.where(yarns.closed[yarn[first]], np.minimum(apart, size - apart), apart)
    return (yarn[first] != yarn[second]) | (around > NEIGHBOURS)
