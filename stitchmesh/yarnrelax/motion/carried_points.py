# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Points that a moving surface of triangles carries: bound to it once, and placed again wherever it has moved.

A point x is bound to the nearest triangle (c0, c1, c2) at the barycentric coordinates b of its nearest place. With the
sides e1 = c1 - c0 and e2 = c2 - c0, the normals n_i of the surface at the corners and N of the triangle,

    x = c0 + l1 e1 + l2 e2 + h n,    n = (sum of b_i n_i) / |sum of b_i n_i|,    h = (x - p) . N / (n . N)

where p is the nearest place and l1, l2 take up the rest. The coordinates (b, l1, l2, h) never change. A rigid motion
of the surface moves x rigidly. An affine motion moves x affinely but for the part along n, whose length is kept: a
cloth that is stretched does not become thicker or thinner here. n is continuous across the edges, and it has a
direction at borders too.

The frame of a point is (t, n, n x t) with t the part of e1 across n. It turns displacements with the surface.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import Vec2, Vec3
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.simulation.bodies.body_surface import single
from stitchmesh.simulation.bodies.mesh_features import FeatureTopology, feature_topology
from stitchmesh.yarnrelax.model.constants import Model

LEAST_COSINE = wp.constant(0.3)
"""Cosine between the normal of a triangle and the normal of the surface below which the triangle's own normal is taken:
the triangle is folded over its neighbours there."""


@wp.func
def direction_of(vector: Vec3, otherwise: Vec3) -> Any:
    """The unit vector along a vector; another one if the vector is zero."""
    length = wp.length(vector)
    if length > type(length)(1.0e-12):
        return vector / length
    return otherwise


@wp.func
def surface_normal(normals: wp.array[Vec3], place: wp.array[wp.int32], t: int, weight: Vec2, own: Vec3) -> Any:
    """Normal of the surface on a triangle, from the weights of its second and third corner."""
    one = type(weight[0])(1.0)
    mean = (
        normals[place[3 * t]] * (one - weight[0] - weight[1])
        + normals[place[3 * t + 1]] * weight[0] + normals[place[3 * t + 2]] * weight[1]
    )  # fmt: skip
    normal = direction_of(mean, own)
    if wp.dot(normal, own) < type(one)(LEAST_COSINE):
        return own
    return normal


@wp.func
def triangle_normal(corners: wp.array[Vec3], t: int) -> Any:
    """Unit normal of a triangle; zero if it has no area."""
    start = corners[3 * t]
    return direction_of(wp.cross(corners[3 * t + 1] - start, corners[3 * t + 2] - start), start - start)


@kernel
def place_corners(
    # model
    corner: wp.array[wp.int32],
    # state in
    vertices: wp.array[Vec3],
    # state out
    corners: wp.array[Vec3],
) -> None:
    """Corners of the triangles, from the vertices."""
    k = wp.tid()
    corners[k] = vertices[corner[k]]


@kernel
def sum_normals(
    # model
    around_start: wp.array[wp.int32],
    around: wp.array[wp.int32],
    # state in
    corners: wp.array[Vec3],
    # state out
    normals: wp.array[Vec3],
) -> None:
    """Normal of the surface at each place: the sum of the normals of its triangles, each times its area."""
    v = wp.tid()
    total = type(corners[0])()
    for n in range(around_start[v], around_start[v + 1]):
        t = around[n] // 3
        start = corners[3 * t]
        total += wp.cross(corners[3 * t + 1] - start, corners[3 * t + 2] - start)
    normals[v] = direction_of(total, total)


@kernel
def bind_points(
    # model
    tree: wp.uint64,
    corners: wp.array[Vec3],
    place: wp.array[wp.int32],
    # state in
    normals: wp.array[Vec3],
    points: wp.array[Vec3],
    # state out
    face: wp.array[wp.int32],
    weight: wp.array[Vec2],
    local: wp.array[Vec3],
) -> None:
    """Bind each point to the nearest triangle."""
    i = wp.tid()
    query = wp.mesh_query_point_no_sign(tree, single(points[i]), 1.0e6)  # units, farther than any triangle
    t = query.face
    own = triangle_normal(corners, t)
    start = corners[3 * t]
    along, other = corners[3 * t + 1] - start, corners[3 * t + 2] - start
    # Warp's u and v are the weights of the first two corners
    share = type(weight[0])(type(own[0])(query.v), type(own[0])(1.0 - query.u - query.v))
    normal = surface_normal(normals, place, t, share, own)
    apart = points[i] - start - along * share[0] - other * share[1]
    height = wp.dot(apart, own) / wp.dot(normal, own)
    beside = apart - normal * height
    area = wp.cross(along, other)
    square = wp.dot(area, area)
    first = share[0] + wp.dot(wp.cross(beside, other), area) / square
    second = share[1] + wp.dot(wp.cross(along, beside), area) / square
    face[i] = t
    weight[i] = share
    local[i] = type(own)(first, second, height)


@wp.func
def carried_place(
    corners: wp.array[Vec3], normals: wp.array[Vec3], place: wp.array[wp.int32], t: int, weight: Vec2, local: Vec3
) -> tuple[Any, Any, Any]:
    """The place of a bound point, and the first two directions t and n of its frame."""
    own = triangle_normal(corners, t)
    normal = surface_normal(normals, place, t, weight, own)
    start = corners[3 * t]
    along, other = corners[3 * t + 1] - start, corners[3 * t + 2] - start
    across = direction_of(along - normal * wp.dot(along, normal), along - along)
    return start + along * local[0] + other * local[1] + normal * local[2], across, normal


@kernel
def place_points(
    # model
    place: wp.array[wp.int32],
    face: wp.array[wp.int32],
    weight: wp.array[Vec2],
    local: wp.array[Vec3],
    # state in
    corners: wp.array[Vec3],
    normals: wp.array[Vec3],
    # state out
    points: wp.array[Vec3],
    across: wp.array[Vec3],
    normal: wp.array[Vec3],
) -> None:
    """Place bound points, and the directions t and n of their frames."""
    i = wp.tid()
    where, first, second = carried_place(corners, normals, place, face[i], weight[i], local[i])
    points[i] = where
    across[i] = first
    normal[i] = second


@kernel
def distances_from(
    # model
    tree: wp.uint64,
    # state in
    points: wp.array[wp.vec3],
    # state out
    distance: wp.array[wp.float32],
) -> None:
    """Distance of each point from a surface."""
    i = wp.tid()
    query = wp.mesh_query_point_no_sign(tree, points[i], 1.0e9)  # cm, farther than any triangle
    distance[i] = wp.length(points[i] - wp.mesh_eval_position(tree, query.face, query.u, query.v))


def distances_from_mesh(mesh: Mesh, points: FloatArray, device: wp.Device) -> FloatArray:
    """Distance of points from a mesh [cm], shape (n,), in single precision.

    Args:
        mesh: the mesh.
        points: the points [cm], shape (n, 3).
        device: where to compute.
    """
    corner = feature_topology(mesh).corner
    indices = wp.array(np.ascontiguousarray(corner.ravel(), dtype=np.int32), dtype=wp.int32, device=device)
    tree = wp.Mesh(wp.array(mesh.vertices.astype(np.float32), dtype=wp.vec3, device=device), indices)
    distance = wp.zeros(len(points), dtype=wp.float32, device=device)
    places = wp.array(points.astype(np.float32), dtype=wp.vec3, device=device)
    launch(distances_from, len(points), [wp.uint64(tree.id), places], [distance], device)
    return distance.numpy().astype(np.float64)


class CarryingSurface:
    """A moving surface on a device, as far as points need it that it carries."""

    def __init__(self, model: Model, topology: FeatureTopology, corners: wp.array[Any]) -> None:
        """Read the corners of a surface, which others move.

        Args:
            model: the model whose coordinates are used.
            topology: the triangles of the surface.
            corners: the corners of the triangles on the device [units], shape (3 T, 3).
        """
        self.model, self.corners = model, corners
        places = topology.place.ravel()
        start = np.concatenate([[0], np.cumsum(np.bincount(places))])
        self.place = model.integers(places)
        self.around_start, self.around = model.integers(start), model.integers(np.argsort(places, kind="stable"))
        self.normals = model.empty(len(start) - 1, 3)

    def launches(self, launcher: Launcher) -> list[Any]:
        """Return the launch that finds the normals of the surface where its corners are now."""
        tables = [self.around_start, self.around, self.corners]
        return [launcher(sum_normals, len(self.normals), tables, [self.normals])]

    def bind(self, points: wp.array[Any]) -> BoundPoints:
        """Bind points [units], shape (N, 3), to the surface where it is now.

        The points must be within a million units of the surface.
        """
        model, count = self.model, len(points)
        self.launches(model.launch)
        single_corners = wp.array(self.corners.numpy(), dtype=wp.vec3, device=model.device)
        indices = wp.array(np.arange(len(single_corners)), dtype=wp.int32, device=model.device)
        tree = wp.Mesh(single_corners, indices, bvh_constructor="sah")  # the same tree on every device
        face = model.integers(np.zeros(count))
        weight, local = model.empty(count, 2), model.empty(count, 3)
        inputs = [wp.uint64(tree.id), self.corners, self.place, self.normals, points]
        model.launch(bind_points, count, inputs, [face, weight, local])
        return BoundPoints(self, face, weight, local)


@dataclass(frozen=True, eq=False)
class BoundPoints:
    """Points that are bound to a surface."""

    surface: CarryingSurface
    face: wp.array[Any]
    """Triangle of each point, shape (N,)."""
    weight: wp.array[Any]
    """Weights of the second and the third corner of the triangle at the nearest place, shape (N, 2)."""
    local: wp.array[Any]
    """Coordinates l1, l2 and h, shape (N, 3)."""

    @property
    def inputs(self) -> list[Any]:
        """The arguments of ``carried_place`` for kernels: place, face, weight, local, corners, normals."""
        return [self.surface.place, self.face, self.weight, self.local, self.surface.corners, self.surface.normals]

    def launch(self, points: wp.array[Any], across: wp.array[Any], normal: wp.array[Any], launcher: Launcher) -> Any:
        """Return the launch that places the points, and the directions t and n of their frames."""
        return launcher(place_points, len(self.face), self.inputs, [points, across, normal])
