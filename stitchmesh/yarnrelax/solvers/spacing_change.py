# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The change of the spacing of stitches by a motion of the control points of a piece.

The control points of a stitch form a group. If the yarns were not made from stitches, 12 successive control points form
one. Each group has its four nearest groups as neighbours. With the distances d between the middles of
neighbours, before and after a motion, the change is

    rms of (d' - d) / d

over all neighbours that are farther apart than ``NEAREST`` radii, because two groups at one place have no spacing. A
motion of the piece as a whole changes no distance. Neighbours are found in the given yarns, so that a resumed
relaxation has the same ones. The means over the control points of groups are made on the device, where the points are.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import Vec3
from stitchmesh.compute.threads import each_block, thread_count
from stitchmesh.yarn import YarnSet

NEAREST = 2.0
"""Smallest distance of two groups that have a spacing, in mean yarn radii."""
PAIRS_OF_BLOCK = 65536
"""Pairs of groups whose distances are measured at once."""


@kernel
def find_middles(
    # model
    group_start: wp.array[wp.int32],
    member: wp.array[wp.int32],
    # state in
    points: wp.array[Vec3],
    # state out
    middle: wp.array[wp.vec3d],
) -> None:
    """The mean of the points of each group, summed in their order."""
    group = wp.tid()
    first, end = group_start[group], group_start[group + 1]
    total = wp.vec3d()
    for k in range(first, end):
        point = points[member[k]]
        total += wp.vec3d(wp.float64(point[0]), wp.float64(point[1]), wp.float64(point[2]))
    middle[group] = total / wp.float64(end - first)


class SpacingChange:
    """The groups of a piece, or of one cell, and their neighbours."""

    def __init__(self, yarns: YarnSet, device: wp.Device) -> None:
        """Group the control points of the yarns, and find the neighbours."""
        self.device, radius = device, float(yarns.radius.mean())
        group = _groups(yarns)
        count = np.bincount(group)
        start = np.concatenate([[0], np.cumsum(count)])
        self._start, self._member = (
            wp.array(numbers.astype(np.int32), dtype=wp.int32, device=device)
            for numbers in (start, np.argsort(group, kind="stable"))
        )
        """Where the members of each group start, shape (G + 1,); and the control points of all groups, shape (N,)."""
        self.group_count = len(count)
        """The number of groups."""
        middle = self.middles(yarns.points / radius)
        wanted = min(5, len(middle))  # a group is the nearest one to itself
        distance, near = np.zeros((1, 1)), np.zeros((1, 1))
        if wanted > 1:
            distance, near = cKDTree(middle).query(middle, k=wanted, workers=thread_count())
        apart = np.asarray(distance) > NEAREST
        self.pairs = np.column_stack([np.nonzero(apart)[0], np.asarray(near)[apart]]).astype(np.int64)
        """Pairs of groups that are neighbours, shape (K, 2)."""
        follows = np.abs(self.pairs[:, 0] - self.pairs[:, 1]) == 1
        self._along, self._across = np.flatnonzero(follows), np.flatnonzero(~follows)
        """The pairs of which one follows the other, as along a yarn, and the other pairs."""

    def of(self, points: NDArray[np.float64] | wp.array[Any], motion: NDArray[np.float64]) -> float:
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
        length = np.empty(len(self.pairs))

        def measure(some: slice) -> None:
            one, other = self.pairs[some].T
            length[some] = np.linalg.norm(middles[other] - middles[one], axis=1)

        each_block(measure, len(length), PAIRS_OF_BLOCK)
        kinds = (length[self._along], length[self._across])
        return np.array([kind.mean() if len(kind) else 1.0 for kind in kinds])

    def middles(self, values: NDArray[np.float64] | wp.array[Any]) -> NDArray[np.float64]:
        """Return the mean of the values of each group, shape (G, 3).

        Args:
            values: vectors of the control points, shape (N, 3), or (N,) on the device; further ones are not read.
        """
        if isinstance(values, np.ndarray):
            values = wp.array(values, dtype=wp.vec3d, device=self.device)
        middle = wp.empty(self.group_count, dtype=wp.vec3d, device=self.device)
        launch(find_middles, self.group_count, [self._start, self._member, values], [middle], self.device)
        return np.array(middle.numpy())


def _groups(yarns: YarnSet) -> NDArray[np.int64]:
    """Return the group of each control point, shape (N,)."""
    if (yarns.face >= 0).all():
        made = np.bincount(yarns.face) > 0
        return (np.cumsum(made) - 1)[yarns.face]
    yarn = yarns.point_yarn
    labels = yarn * len(yarns.points) + (np.arange(len(yarns.points)) - yarns.start[yarn]) // 12
    return np.unique(labels, return_inverse=True)[1].astype(np.int64)
