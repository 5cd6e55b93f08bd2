# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The force of a surface on one contact sample that has to keep a distance R, its reach.

Outside, every feature of the surface (``mesh_features``) within reach contributes with its share s and its distance d:

    e = sum over triangles, edges, corners of  s f(d / R)
    f(x) = 1/x^2 + x^2 - 2                                       for 1/2 <= x < 1, else 0 above
    f(x) = f(1/2) + f'(1/2) (x - 1/2) + f''(1/2) (x - 1/2)^2 / 2 for x < 1/2:  2.25, -15, 98

Over a flat or convex part, e is f of the distance, however the part is divided into triangles. In a concave part both
sides push, and the force is continuous where the nearest triangle changes. The force of the nearest triangle alone
would jump there, and yarns in a concave part would never come to rest. (A sharp ridge, below 90 degrees, pushes
slightly more than f.) Inside the body, where forces do not move a sample, the nearest feature pushes the sample out:
e = f(d / R) with the signed distance.

f grows like the contact energy (L eqs 9, 10) while the overlap is small. It continues with constant curvature, so that
it is finite at the surface. It is twice continuously differentiable at 1/2, and once at 1.

The second derivative of the penalty by the place of the sample is, with the unit vector n from a feature and the unit
tangent t of an edge,

    H = sum of  share (f'' / R^2 n n^T + f' / (R d) Q),    Q = 0 (face), 1 - n n^T - t t^T (edge), 1 - n n^T (corner)

Inside the body only the nearest feature counts, with a signed distance, so d is negative in this formula. The positive
semidefinite matrix is H with its negative eigenvalues set to zero. The result mixes both, with the part ``exact`` of H.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.precision import Mat33, Scalar, Vec3, Vec4
from stitchmesh.simulation.bodies.body_surface import (
    SurfaceArrays,
    feature_of,
    from_edge,
    from_feature,
    from_triangle,
    gap_to,
    single,
)


@wp.func
def penalty(x: Scalar) -> Any:
    """f, for x below 1."""
    one = type(x)(1.0)
    y = x - type(x)(0.5)
    if y < one - one:
        return type(x)(2.25) - type(x)(15.0) * y + type(x)(49.0) * y * y
    return one / (x * x) + x * x - one - one


@wp.func
def penalty_push(x: Scalar) -> Any:
    """Minus the first derivative of f."""
    two = type(x)(2.0)
    y = x - type(x)(0.5)
    if y < two - two:
        return type(x)(15.0) - type(x)(98.0) * y
    return two / (x * x * x) - two * x


@wp.func
def penalty_stiffness(x: Scalar) -> Any:
    """Second derivative of f."""
    y = wp.max(x, type(x)(0.5))
    return type(x)(6.0) / (y * y * y * y) + type(x)(2.0)


@wp.func
def with_feature(push: Vec4, energy: Scalar, apart: Vec3, reach: Scalar, share: Scalar) -> tuple[Any, Any]:
    """Push (its row sum of stiffness last) and energy, with those of one more feature."""
    distance = wp.length(apart)
    x = distance / reach
    if x > x - x and x < type(x)(1.0) and share != x - x:
        size = share * penalty_push(x) / (distance * reach)
        stiff = share * penalty_stiffness(x) / (reach * reach)
        push += type(push)(apart[0] * size, apart[1] * size, apart[2] * size, stiff)
        energy += share * penalty(x)
    return push, energy


@wp.func
def with_triangle(
    push: Vec4, energy: Scalar, surface: SurfaceArrays, t: int, place: Vec3, reach: Scalar
) -> tuple[Any, Any]:
    """Push and energy with those of one more triangle, and of the edges and corners whose shares it has."""
    apart = from_triangle(surface, t, place)
    if wp.dot(apart, apart) < reach * reach:  # its edges and corners are not nearer
        push, energy = with_feature(push, energy, apart, reach, type(reach)(1.0))
        of_edges, of_corners = surface.shares[2 * t], surface.shares[2 * t + 1]
        for k in range(3):
            start = surface.corners[3 * t + (k + 1) % 3]
            edge = from_edge(place, start, surface.corners[3 * t + (k + 2) % 3] - start)
            push, energy = with_feature(push, energy, edge, reach, of_edges[k])
            push, energy = with_feature(push, energy, place - start, reach, of_corners[(k + 1) % 3])
    return push, energy


@wp.func
def near_triangles(surface: SurfaceArrays, place: Vec3, reach: Scalar) -> wp.MeshQueryAABB:
    """The triangles whose boxes are within a reach, always in the same order."""
    # a little wider, for the boxes are single precision
    wide = wp.vec3(1.001 * float(reach), 1.001 * float(reach), 1.001 * float(reach))
    return wp.mesh_query_aabb(surface.tree, single(place) - wide, single(place) + wide)


@wp.func
def push_outside(surface: SurfaceArrays, sample: Vec4, reach: Scalar) -> tuple[Any, Any]:
    """Push and energy of all that is within reach of a sample outside."""
    place = type(surface.corners[0])(sample[0], sample[1], sample[2])
    push = type(sample)()
    energy = reach - reach
    query = near_triangles(surface, place, reach)
    t = wp.int32(0)
    while wp.mesh_query_aabb_next(query, t):
        push, energy = with_triangle(push, energy, surface, t, place, reach)
    return push, energy


@wp.func
def push_listed(
    surface: SurfaceArrays, listed: wp.array2d[wp.int32], p: int, count: int, sample: Vec4, reach: Scalar
) -> Any:
    """Push of the triangles in a list that holds all within reach of a sample outside; the same bits."""
    place = type(surface.corners[0])(sample[0], sample[1], sample[2])
    push = type(sample)()
    energy = reach - reach
    for k in range(count):
        push, energy = with_triangle(push, energy, surface, listed[p, k], place, reach)
    return push


@wp.func
def push_inside(gap: Vec4, reach: Scalar) -> tuple[Any, Any]:
    """Push and energy of the nearest feature of a sample inside, from its direction and signed distance."""
    x = gap[3] / reach
    size = penalty_push(x) / reach
    push = type(gap)(gap[0] * size, gap[1] * size, gap[2] * size, penalty_stiffness(x) / (reach * reach))
    return push, penalty(x)


@wp.func
def push_of(surface: SurfaceArrays, sample: Vec4, reach: Scalar, depth: Scalar) -> tuple[Any, Any]:
    """Push and energy of a sample wherever it is, down to a depth."""
    gap = gap_to(surface, sample, depth)
    if gap[3] >= reach:
        return type(sample)(), reach - reach
    if gap[3] > reach - reach:
        return push_outside(surface, sample, reach)
    return push_inside(gap, reach)


@wp.func
def tangent_at(place: Vec3, start: Vec3, along: Vec3) -> Any:
    """Unit tangent of an edge where its nearest point is inside of it, zero where it is an end."""
    length2 = wp.dot(along, along)
    part = wp.dot(place - start, along)
    tangent = along - along
    if part > length2 - length2 and part < length2:
        tangent = along / wp.sqrt(length2)
    return tangent


@wp.func
def feature_block(apart: Vec3, tangent: Vec3, flat: bool, signed: Scalar, reach: Scalar, share: Scalar) -> Any:
    """H of one feature over that of the energy scale [1 / cm^2], from the vector from it and the signed distance."""
    normal = apart / wp.max(wp.length(apart), type(reach)(1.0e-18))
    x = signed / reach
    block = wp.outer(normal, normal) * (share * penalty_stiffness(x) / (reach * reach))
    if not flat:
        across = wp.identity(n=3, dtype=type(reach)) - wp.outer(normal, normal) - wp.outer(tangent, tangent)
        slope = -penalty_push(x) / (reach * signed)
        if signed != reach - reach:
            block += across * (share * slope)
    return block


@wp.func
def triangle_block(surface: SurfaceArrays, t: int, place: Vec3, reach: Scalar) -> Any:
    """H of a triangle, whose nearest point may be on it, on one of its edges, or one of its corners."""
    apart = from_triangle(surface, t, place)
    tangent = apart - apart
    flat = bool(True)
    distance = wp.length(apart)
    for k in range(3):
        start = surface.corners[3 * t + k]
        along = surface.corners[3 * t + (k + 1) % 3] - start
        edge = from_edge(place, start, along)
        if wp.length(edge - apart) <= type(distance)(1.0e-6) * distance:
            flat = False
            tangent = tangent_at(place, start, along)
    return feature_block(apart, tangent, flat, distance, reach, type(reach)(1.0))


@wp.func
def with_edges(block: Mat33, surface: SurfaceArrays, t: int, place: Vec3, reach: Scalar) -> Any:
    """H with those of the edges and corners whose shares a triangle has."""
    zero = reach - reach
    for k in range(3):
        start = surface.corners[3 * t + (k + 1) % 3]
        along = surface.corners[3 * t + (k + 2) % 3] - start
        edge = from_edge(place, start, along)
        distance, of_edge = wp.length(edge), surface.shares[2 * t][k]
        if of_edge != zero and distance > zero and distance < reach:
            block += feature_block(edge, tangent_at(place, start, along), False, distance, reach, of_edge)
        far, of_corner = wp.length(place - start), surface.shares[2 * t + 1][(k + 1) % 3]
        if of_corner != zero and far > zero and far < reach:
            block += feature_block(place - start, along - along, False, far, reach, of_corner)
    return block


@wp.func
def outside_block(surface: SurfaceArrays, place: Vec3, reach: Scalar) -> Any:
    """H of all features within reach of a point outside."""
    block = wp.identity(n=3, dtype=type(reach)) * (reach - reach)
    query = near_triangles(surface, place, reach)
    t = wp.int32(0)
    while wp.mesh_query_aabb_next(query, t):
        distance = wp.length(from_triangle(surface, t, place))
        if distance < reach:
            if distance > reach - reach:
                block += triangle_block(surface, t, place, reach)
            block = with_edges(block, surface, t, place, reach)
    return block


@wp.func
def body_block(surface: SurfaceArrays, place: Vec3, reach: Scalar, depth: Scalar) -> Any:
    """H of a contact point wherever it is, down to a depth, over the energy scale [1 / cm^2]."""
    block = wp.identity(n=3, dtype=type(reach)) * (reach - reach)
    query = wp.mesh_query_point_no_sign(surface.tree, single(place), float(depth))
    if query.result:
        feature = feature_of(query.u, query.v)
        outward = surface.outward[7 * query.face + feature]
        apart = from_feature(surface.corners, query.face, feature, outward, place)
        distance = wp.length(apart)
        if wp.dot(apart, outward) > distance - distance:
            if distance < reach:
                block = outside_block(surface, place, reach)
        else:
            tangent = apart - apart
            if feature >= 1 and feature <= 3:
                start = surface.corners[3 * query.face + feature % 3]
                tangent = tangent_at(place, start, surface.corners[3 * query.face + (feature + 1) % 3] - start)
            if distance == distance - distance:
                apart = outward
            block = feature_block(apart, tangent, feature == 0, -distance, reach, type(reach)(1.0))
    return block


@wp.func
def without_negative(block: Mat33, exact: Scalar) -> Any:
    """A symmetric matrix whose negative eigenvalues are multiplied by a part, 0 for none of them."""
    double = wp.mat33d()
    for row in range(3):
        for column in range(3):
            double[row, column] = wp.float64(block[row, column])
    vectors, values = wp.eig3(double)
    result = block * (exact - exact)
    for row in range(3):
        for column in range(3):
            total = wp.float64(0.0)
            for k in range(3):
                value = wp.max(values[k], wp.float64(exact) * values[k])
                total += vectors[row, k] * vectors[column, k] * value
            result[row, column] = type(exact)(total)
    return result
