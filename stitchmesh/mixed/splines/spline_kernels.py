# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Maps between the nodes of the mixed system and the control points of the yarn model, which has units of its own.

The yarn model measures lengths in yarn radii r from an origin o: q = (p - o) / r (``yarnrelax.model``). Forces on p are
forces on q over r, and second derivatives by p are second derivatives by q over r^2. The blocks on the diagonal of the
Hessian at a control point are sums over its four segments, where k is its place among the control points of a segment:

    sum of  (D_k - D_(k-1))' H (D_k - D_(k-1))        H by the three legs, D_j the part of leg j
    sum of  B_k(s_i)^2 (a a^T - b I)                  over the samples s_i and the pairs that touch them

The second sum leaves out pairs whose two samples both depend on the control point. They are rare, and the blocks serve
only as a metric.

``longest_move`` finds the longest move along a direction on which each control point stays within its step budget. With
the displacement d since the lists were made, the motion u and the budget R of a control point, the move t u leaves the
ball |d + t u| <= R at

    t = (R^2 - d^2) / (d.u + ((d.u)^2 + u^2 (R^2 - d^2))^(1/2))

in the form of the root without cancellation where d.u > 0.

Distances between yarns do not change when all yarns move alike. Displacements and motions are therefore relative to
their means over all control points.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.reduction import minimum
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.spline import weight_row
from stitchmesh.yarnrelax.model.state import State


@kernel
def place_points(
    # model
    node: wp.array[wp.int32],
    origin: Any,
    per_unit: Any,
    # state in
    nodes: wp.array[Any],
    # state out
    points: wp.array[Any],
) -> None:
    """The control points of the yarn model that are nodes; with an origin of zero also directions."""
    k = wp.tid()
    if node[k] >= 0:
        points[k] = (nodes[node[k]] - origin) * per_unit


@kernel
def add_to_nodes(
    # model
    node: wp.array[wp.int32],
    factor: Any,
    # state in
    values: wp.array[Any],
    # state in and out
    nodes: wp.array[Any],
) -> None:
    """Add a multiple of the vector of each control point to its node; no node occurs twice."""
    k = wp.tid()
    if node[k] >= 0:
        nodes[node[k]] = nodes[node[k]] + values[k] * factor


@wp.func
def leg_block(leg_hessian: wp.array2d[Any], s: int, slot: int) -> Any:
    """Second derivative of the energy of a segment by the control point in a slot."""
    block = leg_hessian[0, s]
    if slot == 1:
        block = leg_hessian[0, s] + leg_hessian[3, s] - leg_hessian[1, s] - wp.transpose(leg_hessian[1, s])
    if slot == 2:
        block = leg_hessian[3, s] + leg_hessian[5, s] - leg_hessian[4, s] - wp.transpose(leg_hessian[4, s])
    if slot == 3:
        block = leg_hessian[5, s] + leg_hessian[5, s] * type(leg_hessian[5, s][0, 0])(0.0)
    return block


@kernel
def add_point_blocks(
    # model
    model: Any,
    node: wp.array[wp.int32],
    factor: Any,
    # state in
    leg_hessian: wp.array2d[Any],
    touching_count: wp.array[wp.int32],
    stiffness: wp.array2d[Any],
    # state in and out
    blocks: wp.array[Any],
) -> None:
    """Add a multiple of the block of each control point to that of its node."""
    i = wp.tid()
    if node[i] < 0:
        return
    slots = model.point_segments[i]
    total = blocks[node[i]] * (factor - factor)
    identity = wp.identity(n=3, dtype=type(factor))
    for slot in range(4):
        s = slots[slot]
        if s >= 0:
            total += leg_block(leg_hessian, s, slot)
            first = model.sample_start[s]
            count = model.sample_start[s + 1] - first
            row = weight_row(model, count, 0)
            for k in range(count):
                weight = model.sample_basis[row + k][slot]
                for c in range(touching_count[first + k]):
                    pair = stiffness[first + k, c]
                    apart = wp.vector(pair[0], pair[1], pair[2])
                    total += (wp.outer(apart, apart) - identity * pair[3]) * (weight * weight)
    blocks[node[i]] = blocks[node[i]] + total * factor


@kernel
def moves_within_budgets(
    # model
    mean_displacement: Any,
    mean_motion: Any,
    # state in
    points: wp.array[Any],
    listed_points: wp.array[Any],
    budget: wp.array[Any],
    motion: wp.array[Any],
    # state out
    limit: wp.array[Any],
) -> None:
    """The part of the motion of each control point that keeps its budget, at most 1."""
    i = wp.tid()
    d, u = points[i] - listed_points[i] - mean_displacement, motion[i] - mean_motion
    radius = budget[i] * type(budget[i])(1.0)
    zero, one = radius - radius, type(radius)(1.0)
    room = wp.max(radius * radius - wp.dot(d, d), zero)
    along, square = wp.dot(d, u), wp.dot(u, u)
    longest = one
    if square > zero:
        root = wp.sqrt(along * along + square * room)
        if along > zero:
            longest = room / (along + root)
        else:
            longest = (root - along) / square
    limit[i] = wp.min(longest, one)


def longest_move(model: Model, state: State, motion: wp.array[Any]) -> float:
    """The part of a motion, in [0, 1], on which all control points stay within their budgets.

    Args:
        model: the yarns.
        state: the yarns' control points, the points for which contacts were listed, and the budgets.
        motion: displacement of the control points for a part of 1 [units], shape (N, 3).
    """
    limit = model.empty(model.point_count)
    points, listed = (_mean(places) for places in (state.points, state.listed_points))
    means = [model.numbers(*mean) for mean in (points - listed, _mean(motion))]
    inputs = [*means, state.points, state.listed_points, state.budget, motion]
    model.launch(moves_within_budgets, model.point_count, inputs, [limit])
    return minimum(limit)


def _mean(vectors: wp.array[Any]) -> NDArray[np.float64]:
    """Mean of vectors, shape (3,)."""
    mean: NDArray[np.float64] = vectors.numpy().mean(axis=0, dtype=np.float64)
    return mean
