# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""From segment forces to moved control points."""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.yarnrelax.damping import damped_step
from stitchmesh.yarnrelax.step_limit import largest_step, shortened

wp.set_module_options({"enable_backward": False})


@wp.kernel(module="unique")
def gather_forces(
    # model
    model: Any,
    # state in
    segment_force: wp.array[Any],
    # state out
    point_force: wp.array[Any],
) -> None:
    """Force [dyn] on each control point: its segments' forces, always added in the same order."""
    i = wp.tid()
    slots = model.point_segments[i]
    force = type(point_force[0])()
    for slot in range(4):
        if slots[slot] >= 0:
            force += segment_force[4 * slots[slot] + slot]
    point_force[i] = force


@wp.kernel(module="unique")
def propose_steps(
    # model
    model: Any,
    point_stiffness: wp.array[Any],
    step_fraction: Any,
    # state in
    travel: wp.array[Any],
    points: wp.array[Any],
    listed_points: wp.array[Any],
    point_force: wp.array[Any],
    segment_stiffness: wp.array[Any],
    segment_clearance: wp.array[Any],
    pace: wp.array[wp.float64],
    # state out
    step: wp.array[Any],
    limit: wp.array[Any],
    mobility: wp.array[Any],
    power: wp.array[Any],
) -> None:
    """The next move of each control point [cm], within its limit, and the power of the last one [erg]."""
    i = wp.tid()
    slots = model.point_segments[i]
    stiffness = point_stiffness[i]
    for slot in range(4):
        if slots[slot] >= 0:
            stiffness += segment_stiffness[slots[slot]][slot]
    room = travel[0] - wp.length(points[i] - listed_points[i])
    allowed = largest_step(model, segment_clearance, i, step_fraction, room)
    power[i] = wp.dot(point_force[i], step[i])
    limit[i] = allowed
    mobility[i] = type(stiffness)(1.0) / stiffness
    step[i] = shortened(damped_step(point_force[i], step[i], stiffness, pace), allowed)


@wp.kernel(module="unique")
def move_points(
    # state in
    travel: wp.array[Any],
    step: wp.array[Any],
    listed_points: wp.array[Any],
    # state out
    points: wp.array[Any],
    room: wp.array[Any],
) -> None:
    """Move, and note how far each control point may still go before the candidate lists are made again [cm]."""
    i = wp.tid()
    moved = points[i] + step[i]
    points[i] = moved
    room[i] = travel[0] - wp.length(moved - listed_points[i])
