# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Signed distance from a triangle mesh, on the device, and anchors of friction, which move with one of its triangles.

A search through Warp's tree of boxes, in single precision, finds the nearest face, edge or corner. The distance and the
direction from this feature are then computed in the precision of the model. The search may find the farther of two
features only if their distances are equal in single precision; the error of the distance is then just as small. The
sign comes from the outward direction of the feature (``mesh_features``). Everything beyond a border is outside.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import warp as wp

from stitchmesh.compute.kernel_variants import named_type
from stitchmesh.compute.precision import Scalar, ScalarType, Vec3, Vec4, vector
from stitchmesh.simulation.bodies.mesh_features import MeshFeatures

NO_ANCHOR = wp.constant(-1)
"""Number of the triangle for a point without an anchor, which does not touch the body."""


SurfaceArrays: TypeAlias = Any
"""The struct of a ``BodySurface``, in either precision."""
ExactSurface: TypeAlias = Any
"""``SurfaceArrays`` in double precision."""

@wp.func
def feature_of(u: float, v: float) -> int:
    """Which feature of a triangle a point of it lies on, from the weights of the first two corners."""
    # the query leaves rounding errors of single precision where a weight is zero
    weight = wp.vec3(u, v, 1.0 - u - v)
    absent = int(0)
    edge = int(0)
    corner = int(0)
    for k in range(3):
        if weight[k] < 1.0e-6:
            absent += 1
            edge = k
        else:
            corner = k
    if absent == 0:
        return 0
    if absent == 1:
        return 1 + edge
    return 4 + corner


@wp.func
def from_edge(place: Vec3, start: Vec3, along: Vec3) -> Any:
    """Shortest vector from an edge to a place."""
    apart = place - start
    length2 = wp.dot(along, along)
    part = wp.dot(apart, along) / wp.max(length2, type(length2)(1.0e-30))
    return apart - along * wp.clamp(part, part - part, type(part)(1.0))


@wp.func
def from_feature(corners: wp.array[Vec3], triangle: int, feature: int, outward: Vec3, place: Vec3) -> Any:
    """Shortest vector from a feature of a triangle to a place."""
    if feature == 0:
        return outward * wp.dot(place - corners[3 * triangle], outward)
    if feature >= 4:
        return place - corners[3 * triangle + feature - 4]
    start = corners[3 * triangle + feature % 3]
    return from_edge(place, start, corners[3 * triangle + (feature + 1) % 3] - start)


@wp.func
def from_triangle(surface: SurfaceArrays, t: int, place: Vec3) -> Any:
    """Shortest vector from a triangle to a place."""
    normal = surface.outward[7 * t]
    apart = place - surface.corners[3 * t]
    height = wp.dot(apart, normal)
    zero = height - height
    over = wp.dot(normal, normal) > zero
    for k in range(3):
        start = surface.corners[3 * t + k]
        along = surface.corners[3 * t + (k + 1) % 3] - start
        if wp.dot(wp.cross(normal, along), place - start) < zero:
            over = False
        edge = from_edge(place, start, along)
        if wp.dot(edge, edge) < wp.dot(apart, apart):
            apart = edge
    if over:
        apart = normal * height
    return apart


@wp.func
def gap_to(surface: SurfaceArrays, sample: Vec4, limit: Scalar) -> Any:
    """Direction away from the inside and signed distance; no direction and ``limit`` where the surface is farther."""
    place = type(surface.corners[0])(sample[0], sample[1], sample[2])
    query = wp.mesh_query_point_no_sign(surface.tree, single(place), float(limit))
    away = type(surface.corners[0])()
    distance = limit
    if query.result:
        feature = feature_of(query.u, query.v)
        away = surface.outward[7 * query.face + feature]
        apart = from_feature(surface.corners, query.face, feature, away, place)
        distance = wp.length(apart)
        if wp.dot(apart, away) < distance - distance:
            distance = -distance
        if distance != distance - distance:
            away = apart / distance
    return type(sample)(away[0], away[1], away[2], distance)


@wp.func
def single(place: Vec3) -> wp.vec3:
    """A place in the precision of the tree."""
    return wp.vec3(float(place[0]), float(place[1]), float(place[2]))


@dataclass(frozen=True, eq=False)
class BodySurface:
    """A surface on the device, in the coordinates of a simulation."""

    tree: wp.Mesh
    """The tree for searches; kernels receive its identifier."""
    constants: Any
    """The struct that kernels receive."""


@functools.cache
def _constants_type(scalar: ScalarType) -> Any:
    """Return the struct of a surface in one precision."""
    vectors = wp.array(dtype=vector(3, scalar))
    annotations = {
        "tree": wp.uint64,
        "corners": vectors,  # of each triangle, shape (3 T, 3)
        "outward": vectors,  # of each triangle's features, shape (7 T, 3)
        "shares": vectors,  # of each triangle's edges and of its corners, shape (2 T, 3)
    }
    return wp.struct(type(f"BodySurface_{scalar.__name__}", (), {"__annotations__": annotations}))


named_type("SurfaceArrays", lambda form: [_constants_type(form.scalar)])
named_type("ExactSurface", lambda form: [_constants_type(wp.float64)])


def surface_of(features: MeshFeatures, scalar: ScalarType, device: wp.Device) -> BodySurface:
    """Send triangles and their features to a device."""
    corners = features.corners.reshape(-1, 3)
    points = wp.array(corners, dtype=wp.vec3, device=device)
    indices = wp.array(np.arange(len(corners)), dtype=wp.int32, device=device)
    tree = wp.Mesh(points, indices, bvh_constructor="sah")  # the same tree on every device
    constants = _constants_type(scalar)()
    constants.tree = tree.id
    vectors = [corners, features.outward.reshape(-1, 3), features.shares.reshape(-1, 3)]
    arrays = [wp.array(values, dtype=vector(3, scalar), device=device) for values in vectors]
    constants.corners, constants.outward, constants.shares = arrays
    return BodySurface(tree, constants)


@wp.func
def anchor_place(surface: SurfaceArrays, face: int, local: Vec3) -> Any:
    """The place of an anchor, from its coordinates along two sides of a triangle and its normal."""
    start = surface.corners[3 * face]
    along = surface.corners[3 * face + 1] - start
    other = surface.corners[3 * face + 2] - start
    return start + along * local[0] + other * local[1] + surface.outward[7 * face] * local[2]


@wp.func
def anchor_at(surface: SurfaceArrays, face: int, place: Vec3) -> Any:
    """Coordinates of a place along two sides of a triangle and its normal."""
    apart = place - surface.corners[3 * face]
    along = surface.corners[3 * face + 1] - surface.corners[3 * face]
    other = surface.corners[3 * face + 2] - surface.corners[3 * face]
    normal = wp.cross(along, other)
    square = wp.dot(normal, normal)
    first = wp.dot(wp.cross(apart, other), normal) / square
    second = wp.dot(wp.cross(along, apart), normal) / square
    return type(place)(first, second, wp.dot(apart, surface.outward[7 * face]))
