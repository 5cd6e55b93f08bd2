# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The change of the spacing of stitches by a motion of the control points of a piece.

The control points of a stitch form a group. If the yarns were not made from stitches, 12 successive control points form
one. Each group has its four nearest groups as neighbours. With the distances d between the middles of
neighbours, before and after a motion, the change is

    rms of (d' - d) / d

over all neighbours that are farther apart than ``NEAREST`` radii, because two groups at one place have no spacing. A
motion of the piece as a whole changes no distance. Neighbours are found in the given yarns, so that a resumed
relaxation has the same ones.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from stitchmesh.yarn import YarnSet

NEAREST = 2.0
"""Smallest distance of two groups that have a spacing, in mean yarn radii."""


class SpacingChange:
    """The groups of a piece, or of one cell, and their neighbours."""

    def __init__(self, yarns: YarnSet) -> None:
        """Group the control points of the yarns, and find the neighbours."""
        self.group, radius = _groups(yarns), float(yarns.radius.mean())
        self.count = np.bincount(self.group)
        middle = self.middles(yarns.points / radius)
        wanted = min(5, len(middle))  # a group is the nearest one to itself
        distance, near = cKDTree(middle).query(middle, k=wanted) if wanted > 1 else (np.zeros((1, 1)), np.zeros((1, 1)))
        apart = np.asarray(distance) > NEAREST
        self.pairs = np.column_stack([np.nonzero(apart)[0], np.asarray(near)[apart]]).astype(np.int64)
        """Pairs of groups that are neighbours, shape (K, 2)."""
        self.along = np.abs(self.pairs[:, 0] - self.pairs[:, 1]) == 1
        """Whether two neighbours follow each other, as along a yarn, shape (K,)."""

    @property
    def group_count(self) -> int:
        """The number of groups."""
        return len(self.count)

    def of(self, points: NDArray[np.float64], motion: NDArray[np.float64]) -> float:
        """Return the relative change of the distances of neighbours by a motion, both in mean radii, shape (N, 3)."""
        if len(self.pairs) == 0:
            return 0.0
        before = np.diff(self.middles(points)[self.pairs], axis=1)[:, 0]
        after = before + np.diff(self.middles(motion)[self.pairs], axis=1)[:, 0]
        length = np.linalg.norm(before, axis=1)
        change = (np.linalg.norm(after, axis=1) - length) / np.maximum(length, NEAREST)
        return float(np.sqrt(np.mean(change**2)))

    def mean_distances(self, middles: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the mean distance of neighbours along the yarns and across them, 1 if there are none, shape (2,)."""
        length = np.linalg.norm(np.diff(middles[self.pairs], axis=1)[:, 0], axis=1)
        kinds = (length[self.along], length[~self.along])
        return np.array([kind.mean() if len(kind) else 1.0 for kind in kinds])

    def middles(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the mean of the values of each group, shape (G, 3)."""
        sums = [np.bincount(self.group, values[:, axis]) for axis in range(3)]
        return np.stack(sums, axis=1) / self.count[:, None]


def _groups(yarns: YarnSet) -> NDArray[np.int64]:
    """Return the group of each control point, shape (N,)."""
    if (yarns.face >= 0).all():
        labels = yarns.face.astype(np.int64)
    else:
        yarn = np.repeat(np.arange(yarns.yarn_count), np.diff(yarns.start))
        labels = yarn * len(yarns.points) + (np.arange(len(yarns.points)) - yarns.start[yarn]) // 12
    return np.unique(labels, return_inverse=True)[1].astype(np.int64)
