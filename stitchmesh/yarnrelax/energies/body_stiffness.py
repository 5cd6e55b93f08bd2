# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The second derivative of a body's penalty by the place of one contact point.

The penalty is a sum over features (``stitchmesh.yarnrelax.energies.body_penalty``) of share f(d / R), with the distance
d of a face, an edge or a corner and the unit vector n from it. With the unit tangent t of an edge,

    H = sum of  share (f'' / R^2 n n^T + f' / (R d) Q),    Q = 0 (face), 1 - n n^T - t t^T (edge), 1 - n n^T (corner)

Inside the body only the nearest feature counts, with a signed distance, so d is negative in this formula. The positive
semidefinite matrix is H with its negative eigenvalues set to zero. The result mixes both, with the part ``exact`` of H.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.yarnrelax.energies.body_penalty import near_triangles, penalty_push, penalty_stiffness
from stitchmesh.yarnrelax.energies.body_surface import feature_of, from_edge, from_feature, from_triangle, single


@wp.func
def tangent_at(place: Any, start: Any, along: Any) -> Any:
    """Unit tangent of an edge where its nearest point is inside of it, zero where it is an end."""
    length2 = wp.dot(along, along)
    part = wp.dot(place - start, along)
    tangent = along - along
    if part > length2 - length2 and part < length2:
        tangent = along / wp.sqrt(length2)
    return tangent


@wp.func
def feature_block(apart: Any, tangent: Any, flat: bool, signed: Any, reach: Any, share: Any) -> Any:
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
def triangle_block(surface: Any, t: int, place: Any, reach: Any) -> Any:
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
def with_edges(block: Any, surface: Any, t: int, place: Any, reach: Any) -> Any:
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
def outside_block(surface: Any, place: Any, reach: Any) -> Any:
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
def body_block(surface: Any, place: Any, reach: Any, depth: Any) -> Any:
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
def without_negative(block: Any, exact: Any) -> Any:
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
