# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact points on a device: their places follow from the positions of a state, and their forces act on the state.

With the constant matrix C of the shares (``contact_points``), the places are c = C x, the forces on the state are
C^T f, and products with a Hessian are C^T H C d. The sums of C^T run in ascending order of the points.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Mat33, Scalar, ScalarType, Vec3, matrix, vector
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.contact.contact_points import ContactPoints
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector


@kernel
def place_points(
    # model
    index: wp.array[wp.vec3i],
    share: wp.array[Vec3],
    # state in
    position: wp.array[Vec3],
    # state out
    place: wp.array[Vec3],
) -> None:
    """The mean of three positions, or of their displacements."""
    m = wp.tid()
    i, w = index[m], share[m]
    place[m] = position[i[0]] * w[0] + position[i[1]] * w[1] + position[i[2]] * w[2]


@kernel
def spread_vectors(
    # model
    start: wp.array[wp.int32],
    point: wp.array[wp.int32],
    part: wp.array[Scalar],
    # state in
    vectors: wp.array[Vec3],
    # state out
    target: wp.array[Vec3],
) -> None:
    """Add the parts of its points to each vertex and node."""
    i = wp.tid()
    for k in range(start[i], start[i + 1]):
        target[i] += vectors[point[k]] * part[k]


@kernel
def spread_blocks(
    # model
    first: int,
    start: wp.array[wp.int32],
    point: wp.array[wp.int32],
    part: wp.array[Scalar],
    # state in
    blocks: wp.array[Mat33],
    # state out
    target: wp.array[Mat33],
) -> None:
    """Add the blocks of its points, times the squares of the parts, to each vertex, or to each node."""
    i = wp.tid()
    for k in range(start[first + i], start[first + i + 1]):
        target[i] += blocks[point[k]] * (part[k] * part[k])


@dataclass(frozen=True, eq=False)
class PointMap:
    """The matrix C on a device, by rows and by columns."""

    points: ContactPoints
    """The contact points."""
    scalar: ScalarType
    """Warp's floating-point type."""
    device: wp.Device
    """Where the map lies."""
    index: wp.array[Any]
    """Numbers of the three positions of each point, shape (M,)."""
    share: wp.array[Any]
    """Shares of these positions, three-vectors; shape (M,)."""
    start: wp.array[Any]
    """Where the row of each vertex and node begins; shape (V + N + 1,)."""
    point: wp.array[Any]
    """Points of each vertex and node, ascending in each row."""
    part: wp.array[Any]
    """Share of each point in the rows."""

    @staticmethod
    def of(points: ContactPoints, scalar: ScalarType, device: wp.Device) -> PointMap:
        """Send contact points to a device."""
        column, row = points.index.ravel(), np.repeat(np.arange(len(points)), 3)
        used = np.flatnonzero(points.share.ravel() != 0.0)
        used = used[np.argsort(column[used], kind="stable")]
        start = np.searchsorted(column[used], np.arange(points.vertex_count + points.node_count + 1))
        return PointMap(
            points,
            scalar,
            device,
            wp.array(points.index.astype(np.int32), dtype=wp.vec3i, device=device),
            wp.array(points.share, dtype=vector(3, scalar), device=device),
            wp.array(start.astype(np.int32), dtype=wp.int32, device=device),
            wp.array(row[used].astype(np.int32), dtype=wp.int32, device=device),
            wp.array(points.share.ravel()[used], dtype=scalar, device=device),
        )

    def __len__(self) -> int:
        return len(self.points)

    def scalars(self, values: Any = None) -> wp.array[Any]:
        """An array of one scalar for each point; zeros if no values are given."""
        if values is None:
            return wp.zeros(len(self), dtype=self.scalar, device=self.device)
        return wp.array(np.asarray(values, dtype=np.float64), dtype=self.scalar, device=self.device)

    def vectors(self) -> wp.array[Any]:
        """An array of a zero three-vector for each point."""
        return wp.zeros(len(self), dtype=vector(3, self.scalar), device=self.device)

    def blocks(self) -> wp.array[Any]:
        """An array of a zero 3 x 3 matrix for each point."""
        return wp.zeros(len(self), dtype=matrix(3, self.scalar), device=self.device)

    def place(self, state: MixedVector, place: wp.array[Any], launcher: Launcher) -> list[Any]:
        """The launches that find the places of the points, or their displacements along a direction.

        Raises:
            ParameterError: the state has other numbers of vertices or nodes than the points are for.
        """
        return [launcher(place_points, len(self), [self.index, self.share, self._positions(state)], [place])]

    def spread(self, vectors: wp.array[Any], target: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add forces on points to vertices and nodes."""
        inputs = [self.start, self.point, self.part, vectors]
        return [launcher(spread_vectors, len(self.start) - 1, inputs, [self._positions(target)])]

    def spread_blocks(self, blocks: wp.array[Any], target: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that add blocks of points to the diagonal blocks of vertices and nodes."""
        launches = []
        for first, part in ((0, target.vertices), (self.points.vertex_count, target.nodes)):
            inputs = [first, self.start, self.point, self.part, blocks]
            launches += [launcher(spread_blocks, len(part), inputs, [part])] if len(part) else []
        return launches

    def _positions(self, state: MixedVector) -> wp.array[Any]:
        """Vertices and nodes of a vector as one array, shape (V + N,); they follow one another in memory."""
        found, expected = (state.vertex_count, state.node_count), (self.points.vertex_count, self.points.node_count)
        if found != expected or state.scalar is not self.scalar:
            found_words = f"got {found} vertices and nodes in {state.scalar.__name__}"
            raise ParameterError(f"contact points: {found_words}; expected {expected} in {self.scalar.__name__}")
        view = wp.array(ptr=state.values.ptr, dtype=vector(3, self.scalar), shape=sum(found), device=self.device)
        view._ref = state.values  # the memory lives as long as the view
        return view
