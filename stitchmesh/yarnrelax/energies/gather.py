# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Forces on control points: each gathers from its segments and their samples, always in the same order."""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.vector_loads import load_vector
from stitchmesh.yarnrelax.model.spline import weight_row


@wp.func
def leg_forces_on(leg_force: wp.array2d[Any], s: int, slot: int) -> Any:
    """Force of a segment's legs on the control point in a slot: the leg before pulls, the leg after holds back."""
    force = type(leg_force[0, 0])()
    if slot > 0:
        force += leg_force[slot - 1, s]
    if slot < 3:
        force -= leg_force[slot, s]
    return force


@wp.func
def sample_forces_on(model: Any, sample_force: wp.array[Any], s: int, slot: int) -> Any:
    """Force of a segment's samples on the control point in a slot, and the row sum of its stiffness."""
    total = type(sample_force[0])()
    first = model.sample_start[s]
    count = model.sample_start[s + 1] - first
    row = weight_row(model, count, 0)
    for k in range(count):
        total += load_vector(sample_force, first + k) * model.sample_basis[row + k][slot]
    return total


@wp.func
def gather_at(model: Any, i: int, point_stiffness: wp.array[Any], state: Any) -> None:
    """Force on a control point, and the row sum of stiffness there (``stiffness``)."""
    slots = model.point_segments[i]
    force = type(state.leg_force[0, 0])()
    push = type(state.sample_force[0])()
    for slot in range(4):
        s = slots[slot]
        if s >= 0:
            force += leg_forces_on(state.leg_force, s, slot)
            push += sample_forces_on(model, state.sample_force, s, slot)
    if state.external_force.shape[0] > 0:
        force += state.external_force[i]
    state.force[i] = force + type(force)(push[0], push[1], push[2])
    state.stiffness[i] = point_stiffness[i] + push[3] * type(push[3])(2.0)


@kernel
def gather_forces(
    # model
    model: Any,
    point_stiffness: wp.array[Any],
    # state in and out
    state: Any,
) -> None:
    """Force on each control point, and the row sum of stiffness there."""
    gather_at(model, wp.tid(), point_stiffness, state)
