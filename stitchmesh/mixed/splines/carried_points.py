# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Control points beside the region, which triangles carry.

Loops at the border of the region need the yarn beyond it: without this yarn they would lose the loops that they hold
and that hold them, and open. The control points beside the region therefore belong to the model, without unknowns of
their own,

    q = B v + o,

where the offset o turns with the triangle of the point and is constant within an iteration of the solver. A force f on
such a point acts on the vertices as B' f, and a motion of the vertices moves the point by B dv.

``TurnedVectors`` holds vectors that are constant in the frame of a triangle and turn with it. The axes of the frame are
the direction of the first side, the direction perpendicular to it in the plane, and the normal.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.sparse import csr_array

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import Scalar, ScalarType, Vec3, vector

Numbers = NDArray[np.float64]
Integers = NDArray[np.int64]


@kernel
def turn_vectors(
    # model
    corners: wp.array[wp.vec3i],
    local: wp.array[Vec3],
    # state in
    vertices: wp.array[Vec3],
    # state out
    turned: wp.array[Vec3],
) -> None:
    """Each vector in space."""
    k = wp.tid()
    corner = corners[k]
    side, other = vertices[corner[1]] - vertices[corner[0]], vertices[corner[2]] - vertices[corner[0]]
    along, normal = wp.normalize(side), wp.normalize(wp.cross(side, other))
    c = local[k]
    turned[k] = along * c[0] + wp.cross(normal, along) * c[1] + normal * c[2]


class TurnedVectors:
    """Vectors on a device."""

    def __init__(
        self, corners: Integers, vectors: Numbers, vertices: Numbers, scalar: ScalarType, device: wp.Device
    ) -> None:
        """Store the vectors in the frames of their triangles.

        Args:
            corners: vertices of the triangle with which each vector turns, shape (n, 3).
            vectors: the vectors while the vertices are at ``vertices``, shape (n, 3).
            vertices: positions of the vertices [cm], shape (V, 3).
            scalar: Warp's floating-point type.
            device: where the vectors lie.
        """
        kind = vector(3, scalar)
        local = np.einsum("nij,nj->ni", triangle_frames(vertices[corners]), vectors)
        self._corners = wp.array(corners.astype(np.int32), dtype=wp.vec3i, device=device)
        self._local = wp.array(local, dtype=kind, device=device)
        self.vectors = wp.array(vectors, dtype=kind, device=device)
        """The vectors in space, as last turned, shape (n, 3)."""
        self._launch = partial(launch, device=device)

    def turn(self, vertices: wp.array[Any]) -> None:
        """Turn the vectors with their triangles."""
        self._launch(turn_vectors, len(self.vectors), [self._corners, self._local, vertices], [self.vectors])


def triangle_frames(corners: Numbers) -> Numbers:
    """Return the frame of each triangle as rows, shape (n, 3, 3).

    Args:
        corners: positions of the corners [cm], shape (n, 3, 3).
    """
    side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(side, other)
    along = side / np.linalg.norm(side, axis=1, keepdims=True)
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    return np.stack([along, np.cross(normal, along), normal], axis=1)


@kernel
def place_carried(
    # model
    point: wp.array[wp.int32],
    corners: wp.array[wp.vec3i],
    weight: wp.array[Vec3],
    origin: Vec3,
    per_unit: Scalar,
    with_offset: int,
    # state in
    offset: wp.array[Vec3],
    vertices: wp.array[Vec3],
    # state out
    points: wp.array[Vec3],
) -> None:
    """Place the control points that triangles carry; with a zero origin and without offsets, carry directions."""
    k = wp.tid()
    corner, b = corners[k], weight[k]
    place = vertices[corner[0]] * b[0] + vertices[corner[1]] * b[1] + vertices[corner[2]] * b[2] - origin
    if with_offset != 0:
        place += offset[k]
    points[point[k]] = place * per_unit


@kernel
def add_to_vertices(
    # model
    vertex: wp.array[wp.int32],
    start: wp.array[wp.int32],
    point: wp.array[wp.int32],
    weight: wp.array[Scalar],
    factor: Scalar,
    # state in
    values: wp.array[Vec3],
    # state in and out
    vertices: wp.array[Vec3],
) -> None:
    """Add a multiple of B' f to each vertex, in ascending order of the points."""
    i = wp.tid()
    total = vertices[vertex[i]] * (factor - factor)
    for k in range(start[i], start[i + 1]):
        total += values[point[k]] * weight[k]
    vertices[vertex[i]] = vertices[vertex[i]] + total * factor


@dataclass(frozen=True, eq=False, kw_only=True)
class CarriedSplinePoints:
    """Control points that triangles carry."""

    point: Integers
    """Numbers of the control points in the yarn model, shape (m,)."""
    corners: Integers
    """Vertices of the triangle of each control point, shape (m, 3)."""
    weight: Numbers
    """Barycentric coordinates of each control point, shape (m, 3)."""
    place: Numbers
    """Position of each control point in the layout [cm], shape (m, 3)."""


class Carrier:
    """Carried control points on a device."""

    def __init__(self, carried: CarriedSplinePoints, vertices: Numbers, scalar: ScalarType, device: wp.Device) -> None:
        """Store the points with their offsets from the triangles at ``vertices`` [cm], shape (V, 3)."""
        foot = np.einsum("nk,nkd->nd", carried.weight, vertices[carried.corners])
        self._offset = TurnedVectors(carried.corners, carried.place - foot, vertices, scalar, device)
        self._point = wp.array(carried.point, dtype=wp.int32, device=device)
        self._corners = wp.array(carried.corners.astype(np.int32), dtype=wp.vec3i, device=device)
        self._weight = wp.array(carried.weight, dtype=vector(3, scalar), device=device)
        self._origin = vector(3, scalar)()
        rows = np.repeat(carried.point, 3)
        shape = (len(vertices), int(carried.point.max(initial=-1)) + 1)
        of_vertices = csr_array((carried.weight.ravel(), (carried.corners.ravel(), rows)), shape=shape)
        of_vertices.sort_indices()
        used = np.flatnonzero(np.diff(of_vertices.indptr))
        tables = used, np.append(of_vertices.indptr[used], of_vertices.indptr[-1]), of_vertices.indices
        self._gather = [wp.array(table, dtype=wp.int32, device=device) for table in tables]
        self._gather.append(wp.array(of_vertices.data, dtype=scalar, device=device))

    def turn(self, vertices: wp.array[Any]) -> None:
        """Turn the offsets with the triangles."""
        self._offset.turn(vertices)

    def place(self, vertices: wp.array[Any], points: wp.array[Any], origin: Any, unit: Any, launcher: Launcher) -> Any:
        """The launch that places the points; ``unit`` is the unit of the yarn model over cm."""
        return self._placed(vertices, points, origin, unit, launcher, with_offset=1)

    def move(self, vertices: wp.array[Any], motion: wp.array[Any], unit: Any, launcher: Launcher) -> Any:
        """The launch that finds how the points move with the vertices."""
        return self._placed(vertices, motion, self._origin, unit, launcher, with_offset=0)

    def add(self, values: wp.array[Any], vertices: wp.array[Any], factor: Any, launcher: Launcher) -> Any:
        """The launch that adds ``factor`` B' f to the vertices."""
        return launcher(add_to_vertices, len(self._gather[0]), [*self._gather, factor, values], [vertices])

    def _placed(
        self, vertices: wp.array[Any], points: wp.array[Any], origin: Any, unit: Any, launcher: Launcher, *,
        with_offset: int,
    ) -> Any:  # fmt: skip
        inputs = [self._point, self._corners, self._weight, origin, unit, with_offset, self._offset.vectors, vertices]
        return launcher(place_carried, len(self._point), inputs, [points])
