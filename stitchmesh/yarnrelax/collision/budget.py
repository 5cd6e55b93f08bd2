# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Step budgets: how far each control point may move before there are new candidate lists (``step_limit``).

A control point stays within a ball around the place where it was when the lists were made. The radius of the ball is
the budget of the point. It is at most ``SAFETY`` times the smallest clearance of the arcs that contain the point, and
at most half the margin of the lists. If the cell deforms too, the points have the part ``PART_BESIDE_STRAIN`` of both
limits, and the strain has the rest.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel

SAFETY = wp.constant(0.45)
"""Part of the clearance that one control point may use; it is below one half."""
PART_BESIDE_STRAIN = 0.7
"""Part of the step budget that remains for control points if the cell deforms too."""
STRAIN_CLEARANCE = wp.constant(wp.float64(PART_BESIDE_STRAIN / 2.0))
"""Part of the smallest clearance that the strain of a cell may use."""
STRAIN_MARGIN = wp.constant(wp.float64(0.3))
"""Part of the margin that the strain of a cell may use: 1 - ``PART_BESIDE_STRAIN``."""
LARGEST_STRAIN_STEP = wp.constant(wp.float64(0.05))
"""Largest strain on one set of lists; its square is neglected, because it is a small part of a clearance."""
STRAIN_UNIT = wp.constant(10.0)
"""Length that stands for a strain of 1, in mean radii: a limit of 0.1 radii on moves is a limit of 1 % on strains."""
USED_UP = wp.constant(0.7)
"""A control point asks for new candidate lists when it has used this part of its budget."""


@wp.func
def room_left(points: wp.array[Any], listed_points: wp.array[Any], budget: wp.array[Any], i: int) -> Any:
    """How far control point ``i`` may still move on these candidate lists."""
    return wp.max(budget[i] - wp.length(points[i] - listed_points[i]), budget[i] - budget[i])


@wp.func
def shortened(step: Any, limit: Any) -> Any:
    """The step, no longer than the limit."""
    length = wp.length(step)
    if length > limit:
        return step * (limit / length)
    return step


@kernel
def measure_budget_use(
    # state in
    points: wp.array[Any],
    listed_points: wp.array[Any],
    budget: wp.array[Any],
    # state out
    used: wp.array[Any],
) -> None:
    """Part of its budget that each control point has used."""
    i = wp.tid()
    used[i] = wp.length(points[i] - listed_points[i]) / budget[i]
