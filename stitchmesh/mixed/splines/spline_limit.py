# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The longest move along a direction on which each control point stays within its budget.

With the displacement d since the lists were made, the motion u and the budget R of a control point, the move t u leaves
the ball |d + t u| <= R at

    t = (R^2 - d^2) / (d.u + ((d.u)^2 + u^2 (R^2 - d^2))^(1/2))

for the form of the root without cancellation where d.u > 0.

Distances of yarns do not change when all of them move alike. Displacements and motions are therefore relative to their
means over all control points.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.reduction import minimum
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import State


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
    """The part of a motion, in [0, 1], that keeps the budgets of all control points.

    Args:
        model: the yarns.
        state: where they are, where their contacts were listed, and their budgets.
        motion: what a part of 1 adds to the control points [units], shape (N, 3).
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
