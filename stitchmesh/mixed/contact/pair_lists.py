# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Lists of the contact points that may touch each contact point, by a hash grid.

The lists are made for a motion: at places X with displacements d, a pair is listed if

    |X_i - X_j| - |d_i - d_j| < (1 + margin) (r_i + r_j),       r the radii

The term |d_i - d_j| finds a layer that falls on another one, without listing the neighbours within each layer. The
lists contain all pairs that touch as long as no point is farther from X + t d than the margin times its radius, for one
t in [0, 1] that is the same for all points (``cover``). This then also holds along the straight line between two such
states.

Neighbours at rest are not listed. Lists are ascending, and a pair that does not touch adds nothing, so forces do not
depend on when the lists were made.

Contact points that are neighbours in the cloth at rest do not collide. Two points of one panel are neighbours if their
distance at rest is below ``ARC`` times the sum of their radii; the search compares this distance where it lists pairs.
Two points on different sides of a seam are neighbours if a path over the seam is shorter,

    |X_i - A| + |B - X_j| < ARC (r_i + r_j),       A = B a place of the seam, in the panels of i and j

These pairs across seams are found once, at the beginning.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from scipy.spatial import cKDTree

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import Scalar, Vec2, Vec3
from stitchmesh.compute.reduction import maximum, ordered_sum
from stitchmesh.errors import SolverError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.contact.contact_points import ContactPoints, SeamLinks
from stitchmesh.mixed.contact.point_map import PointMap
from stitchmesh.simulation.pair_lists import FIRST_CAPACITY, allocate_lists, insert_sorted

ARC = 2.0
"""Largest distance of neighbours over their distance of contact. A fold of cloth as sharp as its thickness allows has
layers one thickness apart, joined by an arc of pi / 2 thicknesses; the rest is a reserve for compressed cloth."""
LONGEST_SWEEP = 16.0
"""Longest displacement for which lists are made, over the distance within which points at rest are listed."""
GRID = 128
"""Cells along each axis of the hash grid. The grid is periodic, so it does not limit the size of the cloth."""
MOST_ENTRIES = 2**30
"""Largest number of entries of all lists; they take 4 GB."""


ARC_LENGTH = wp.constant(ARC)
"""Reach of neighbours at rest over the sum of the radii."""


@dataclass(frozen=True, eq=False)
class SeamNeighbours:
    """Neighbours across seams of each contact point, as compressed rows."""

    start: IntArray
    """Where the row of each point begins; shape (M + 1,)."""
    point: IntArray
    """Neighbours, ascending in each row."""


def seam_neighbours(points: ContactPoints, links: SeamLinks) -> SeamNeighbours:
    """The pairs of points that a path over a seam joins.

    Args:
        points: the contact points.
        links: the places where panels meet.
    """
    reach = 2.0 * ARC * float(points.layer_radius.max(initial=0.0))
    pairs = [np.zeros((0, 2), dtype=np.int64)]
    near = [_near(points, links.panel[:, side], links.rest[:, side], reach) for side in (0, 1)]
    for link, (here, there) in enumerate(zip(*near, strict=True)):
        if here and there:
            pairs.append(_joined(points, links.rest[link], here, there))
    both = np.concatenate(pairs)
    both = np.unique(np.concatenate([both, both[:, ::-1]]), axis=0)
    both = both[both[:, 0] != both[:, 1]]
    return SeamNeighbours(np.searchsorted(both[:, 0], np.arange(len(points) + 1)), both[:, 1])


def _near(points: ContactPoints, panel: IntArray, place: FloatArray, reach: float) -> list[list[int]]:
    """Points within reach of each place."""
    far = 4.0 * (np.abs(points.rest).max(initial=0.0) + np.abs(place).max(initial=0.0) + reach)
    tree = cKDTree(np.column_stack([points.rest, far * points.panel]))
    found: list[list[int]] = tree.query_ball_point(np.column_stack([place, far * panel]), reach).tolist()
    return found


def _joined(points: ContactPoints, rest: FloatArray, here: list[int], there: list[int]) -> IntArray:
    """Pairs whose path over one link is short enough, shape (n, 2)."""
    one, other = np.array(here), np.array(there)
    path = np.linalg.norm(points.rest[one] - rest[0], axis=1)[:, None]
    path = path + np.linalg.norm(points.rest[other] - rest[1], axis=1)[None, :]
    i, j = np.nonzero(path < ARC * (points.layer_radius[one][:, None] + points.layer_radius[other][None, :]))
    return np.stack([one[i], other[j]], axis=1)


@wp.func
def rest_neighbours(
    panel: wp.array[wp.int32], rest: wp.array[Vec2], start: wp.array[wp.int32], other: wp.array[wp.int32],
    i: int, j: int, reach: Scalar
) -> bool:  # fmt: skip
    """Whether two points are nearer than a reach in the cloth at rest."""
    if panel[i] == panel[j]:
        apart = rest[i] - rest[j]
        if wp.dot(apart, apart) < reach * reach:
            return True
    for k in range(start[i], start[i + 1]):
        if other[k] == j:
            return True
    return False


@kernel
def list_pairs(
    # model
    radius: wp.array[Scalar],
    panel: wp.array[wp.int32],
    rest: wp.array[Vec2],
    seam_start: wp.array[wp.int32],
    seam_point: wp.array[wp.int32],
    margin: Scalar,
    search_radius: Scalar,
    # state in
    grid: wp.uint64,
    place: wp.array[Vec3],
    move: wp.array[Vec3],
    # state out
    count: wp.array[wp.int32],
    lists: wp.array2d[wp.int32],
) -> None:
    """The points that may touch each point, in ascending order."""
    i = wp.tid()
    found = int(0)
    for j in wp.hash_grid_query(grid, place[i], search_radius):
        apart = wp.length(place[i] - place[j]) - wp.length(move[i] - move[j])
        reach = radius[i] + radius[j]
        if i != j and apart < reach * margin:
            if not rest_neighbours(panel, rest, seam_start, seam_point, i, j, reach * type(reach)(ARC_LENGTH)):
                insert_sorted(lists, i, found, j)
                found += 1
    count[i] = found


@kernel
def relative_sizes(
    # state in
    vectors: wp.array[Vec3],
    # state out
    size: wp.array[Scalar],
) -> None:
    """Distance of each vector from the first one."""
    i = wp.tid()
    size[i] = wp.length(vectors[i] - vectors[0])


@kernel
def motion_parts(
    # state in
    listed: wp.array[Vec3],
    sweep: wp.array[Vec3],
    place: wp.array[Vec3],
    move: wp.array[Vec3],
    # state out
    along: wp.array[Scalar],
    square: wp.array[Scalar],
) -> None:
    """Products of the displacement that the lists are for, with the displacement since they were made and itself."""
    i = wp.tid()
    along[i] = wp.dot(place[i] + move[i] - listed[i], sweep[i])
    square[i] = wp.dot(sweep[i], sweep[i])


@kernel
def drifts(
    # model
    part: Scalar,
    radius: wp.array[Scalar],
    # state in
    listed: wp.array[Vec3],
    sweep: wp.array[Vec3],
    place: wp.array[Vec3],
    move: wp.array[Vec3],
    # state out
    drift: wp.array[Scalar],
) -> None:
    """Distance of each point, after a move, from a part of the motion that the lists are for, over its radius."""
    i = wp.tid()
    drift[i] = wp.length(place[i] + move[i] - listed[i] - sweep[i] * part) / radius[i]


@kernel
def scale_vectors(
    # model
    factor: Scalar,
    # state in
    vectors: wp.array[Vec3],
    # state out
    scaled: wp.array[Vec3],
) -> None:
    """Vectors times a number."""
    i = wp.tid()
    scaled[i] = vectors[i] * factor


class PairLists:
    """Lists of pairs on a device."""

    def __init__(self, points: PointMap, seams: SeamNeighbours, margin: float) -> None:
        """Empty lists.

        Args:
            points: the contact points on their device.
            seams: their neighbours across seams.
            margin: distance beyond contact that the lists reach, as a part of the distance of contact.
        """
        self.points, self.margin = points, margin
        device = points.device
        self.longest = 2.0 * float(points.points.layer_radius.max(initial=0.0))
        self.radius = points.scalars(points.points.layer_radius)
        rest_type = wp.types.vector(length=2, dtype=points.scalar)
        self.rest = wp.array(points.points.rest, dtype=rest_type, device=device)
        integers = [np.asarray(a, dtype=np.int32) for a in (points.points.panel, seams.start, seams.point)]
        self.panel, self.seam_start, self.seam_point = (wp.array(a, dtype=wp.int32, device=device) for a in integers)
        self.count = wp.zeros(len(points), dtype=wp.int32, device=device)
        self.lists = allocate_lists(len(points), FIRST_CAPACITY, device)
        self.generation = 0
        self.listed, self.sweep = points.vectors(), points.vectors()
        self._grid = wp.HashGrid(GRID, GRID, GRID, device=device, dtype=points.scalar)
        self._numbers = [points.scalars(), points.scalars()]
        self._made = False

    def invalidate(self) -> None:
        """Declare the lists out of date."""
        self._made = False

    def cover(self, place: wp.array[Any], move: wp.array[Any]) -> float:
        """Make lists that hold all contacts along a move, unless the present lists hold them already.

        Args:
            place: places of the points [cm], shape (M,).
            move: their displacements [cm], shape (M,).

        Returns:
            The part of the move that the lists cover; below 1 where the move is longer than ``LONGEST_SWEEP`` allows.

        Raises:
            SolverError: a place is not finite, or there are too many pairs.
        """
        if len(self.points) < 2 or (self._made and self._drift(place, move) <= self.margin):
            return 1.0
        return self._make(place, move)

    def _drift(self, place: wp.array[Any], move: wp.array[Any]) -> float:
        """Largest distance of a point, after a move, from the motion that the lists cover, over its radius."""
        state = [self.listed, self.sweep, place, move]
        self._run(motion_parts, state, self._numbers)
        along, square = (ordered_sum(numbers) for numbers in self._numbers)
        part = float(np.clip(along / square, 0.0, 1.0)) if square > 0.0 else 0.0
        self._run(drifts, [self.points.scalar(part), self.radius, *state], self._numbers[:1])
        return maximum(self._numbers[0])

    def _make(self, place: wp.array[Any], move: wp.array[Any]) -> float:
        swept = self._extent(move)
        if not np.isfinite(swept + self._extent(place)):
            raise SolverError("self-collision: got places that are not finite; expected numbers; take a shorter step")
        near = self.longest * (1.0 + self.margin)
        part = min(1.0, LONGEST_SWEEP * near / swept) if swept > 0.0 else 1.0
        wp.copy(self.listed, place)
        self._run(scale_vectors, [self.points.scalar(part), move], [self.sweep])
        radius = near + 2.0 * part * swept
        self._grid.build(self.listed, radius)
        self._list(radius)
        longest = int(self.count.numpy().max())
        if longest > self.lists.shape[1]:
            self._check_room(longest)
            self.lists = allocate_lists(len(self.points), longest, self.points.device)
            self.generation += 1
            self._list(radius)
        self._made = True
        return part

    def _list(self, radius: float) -> None:
        scalar = self.points.scalar
        model = [self.radius, self.panel, self.rest, self.seam_start, self.seam_point]
        numbers = [scalar(1.0 + self.margin), scalar(radius), wp.uint64(self._grid.id)]
        self._run(list_pairs, [*model, *numbers, self.listed, self.sweep], [self.count, self.lists])

    def _extent(self, vectors: wp.array[Any]) -> float:
        """Largest distance of a vector from the first one."""
        self._run(relative_sizes, [vectors], self._numbers[:1])
        return maximum(self._numbers[0])

    def _check_room(self, longest: int) -> None:
        """Check that there is enough memory for lists of the given length."""
        if longest * len(self.points) > MOST_ENTRIES:
            worst = int(self.count.numpy().argmax())
            found = f"contact point {worst} has {longest} others near it, of {len(self.points)}"
            raise SolverError(f"self-collision: {found}; expected at most {MOST_ENTRIES} pairs; take a larger spacing")

    def _run(self, kernel: wp.Kernel, inputs: list[Any], outputs: list[Any]) -> None:
        launch(kernel, len(self.points), inputs, outputs, self.points.device)
