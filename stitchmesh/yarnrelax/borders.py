# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Borders: the loops at the edge of a garment keep their place (Y section 6.3, eq 5).

For each loop S_j of the border, a hard constraint:

    C_j = sum over i in S_j of q_i  -  sum over i in S_j of q0_i  =  0

The constraint pulls every control point of the loop with one force, so the steps lose that force times the points'
mobility; the drift that it takes away is measured from the start, so that rounding cannot add up. The steps are then
shortened by one common factor to the step limits, which leaves the mean where it is.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.yarnrelax.forces import Run
from stitchmesh.yarnrelax.shape import Shape
from stitchmesh.yarnrelax.state import State

wp.set_module_options({"enable_backward": False})


@wp.kernel(module="unique")
def hold_loops(
    # model
    held: wp.array[wp.int32],
    loop_start: wp.array[wp.int32],
    loop_points: wp.array[wp.int32],
    home: wp.array[Any],
    # state in
    points: wp.array[Any],
    limit: wp.array[Any],
    mobility: wp.array[Any],
    # state out
    step: wp.array[Any],
) -> None:
    """Take from the steps of each border loop what would move its mean, then shorten all of them alike."""
    loop = held[wp.tid()]
    first, last = loop_start[loop], loop_start[loop + 1]
    drift = type(points[0])()
    whole = limit[0] - limit[0]
    for k in range(first, last):
        i = loop_points[k]
        drift += points[i] + step[i] - home[i]
        whole += mobility[i]
    pull = drift / whole
    scale = type(whole)(1.0)
    for k in range(first, last):
        i = loop_points[k]
        step[i] = step[i] - pull * mobility[i]
        length = wp.length(step[i])
        if length * scale > limit[i]:
            scale = limit[i] / length
    for k in range(first, last):
        step[loop_points[k]] = step[loop_points[k]] * scale


@wp.kernel(module="unique")
def centre_forces(
    # model
    held: wp.array[wp.int32],
    loop_start: wp.array[wp.int32],
    loop_points: wp.array[wp.int32],
    # state out
    force: wp.array[Any],
) -> None:
    """Take the mean, which the constraint carries, from the forces of each border loop."""
    loop = held[wp.tid()]
    first, last = loop_start[loop], loop_start[loop + 1]
    mean = type(force[0])()
    for k in range(first, last):
        mean += force[loop_points[k]]
    mean = mean / type(mean[0])(last - first)
    for k in range(first, last):
        force[loop_points[k]] = force[loop_points[k]] - mean


def hold_borders(shape: Shape, state: State, run: Run) -> Any:
    """Filter the proposed steps of the border's loops."""
    inputs = [shape.held, shape.loop_start, shape.loop_points, shape.home, state.points, state.limit,
              state.mobility]  # fmt: skip
    return run(hold_loops, len(shape.held), inputs, [state.step])


def free_forces(shape: Shape, force: wp.array[Any], run: Run) -> Any:
    """Take from forces what the border's constraints carry."""
    return run(centre_forces, len(shape.held), [shape.held, shape.loop_start, shape.loop_points], [force])
