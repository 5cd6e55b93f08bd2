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
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.yarnrelax.energies.body_surface import from_edge, from_triangle, gap_to, single


@wp.func
def penalty(x: Any) -> Any:
    """f, for x below 1."""
    one = type(x)(1.0)
    y = x - type(x)(0.5)
    if y < one - one:
        return type(x)(2.25) - type(x)(15.0) * y + type(x)(49.0) * y * y
    return one / (x * x) + x * x - one - one


@wp.func
def penalty_push(x: Any) -> Any:
    """Minus the first derivative of f."""
    two = type(x)(2.0)
    y = x - type(x)(0.5)
    if y < two - two:
        return type(x)(15.0) - type(x)(98.0) * y
    return two / (x * x * x) - two * x


@wp.func
def penalty_stiffness(x: Any) -> Any:
    """Second derivative of f."""
    y = wp.max(x, type(x)(0.5))
    return type(x)(6.0) / (y * y * y * y) + type(x)(2.0)


@wp.func
def with_feature(push: Any, energy: Any, apart: Any, reach: Any, share: Any) -> tuple[Any, Any]:
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
def with_triangle(push: Any, energy: Any, surface: Any, t: int, place: Any, reach: Any) -> tuple[Any, Any]:
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
def near_triangles(surface: Any, place: Any, reach: Any) -> wp.MeshQueryAABB:
    """The triangles whose boxes are within a reach, always in the same order."""
    # a little wider, for the boxes are single precision
    wide = wp.vec3(1.001 * float(reach), 1.001 * float(reach), 1.001 * float(reach))
    return wp.mesh_query_aabb(surface.tree, single(place) - wide, single(place) + wide)


@wp.func
def push_outside(surface: Any, sample: Any, reach: Any) -> tuple[Any, Any]:
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
def push_listed(surface: Any, listed: wp.array2d[wp.int32], p: int, count: int, sample: Any, reach: Any) -> Any:
    """Push of the triangles in a list that holds all within reach of a sample outside; the same bits."""
    place = type(surface.corners[0])(sample[0], sample[1], sample[2])
    push = type(sample)()
    energy = reach - reach
    for k in range(count):
        push, energy = with_triangle(push, energy, surface, listed[p, k], place, reach)
    return push


@wp.func
def push_inside(gap: Any, reach: Any) -> tuple[Any, Any]:
    """Push and energy of the nearest feature of a sample inside, from its direction and signed distance."""
    x = gap[3] / reach
    size = penalty_push(x) / reach
    push = type(gap)(gap[0] * size, gap[1] * size, gap[2] * size, penalty_stiffness(x) / (reach * reach))
    return push, penalty(x)


@wp.func
def push_of(surface: Any, sample: Any, reach: Any, depth: Any) -> tuple[Any, Any]:
    """Push and energy of a sample wherever it is, down to a depth."""
    gap = gap_to(surface, sample, depth)
    if gap[3] >= reach:
        return type(sample)(), reach - reach
    if gap[3] > reach - reach:
        return push_outside(surface, sample, reach)
    return push_inside(gap, reach)
