# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Budgets: how far each control point may move before there are new candidate lists (``step_limit``).

A control point stays within a ball around the place where it was when the lists were made. The radius of the ball, its
budget, is at most ``SAFETY`` times the smallest clearance of the arcs that it takes part in and half the margin of the
lists. Where the cell deforms too, the points have the part ``PART_BESIDE_STRAIN`` of both and the strain has the rest.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel

SAFETY = wp.constant(0.45)
"""Part of the clearance that one control point may use; below one half."""
PART_BESIDE_STRAIN = 0.7
"""Part of the budget that remains for control points where the cell deforms too."""
STRAIN_CLEARANCE = wp.constant(wp.float64(PART_BESIDE_STRAIN / 2.0))
"""Part of the smallest clearance that the strain of a cell may use."""
STRAIN_MARGIN = wp.constant(wp.float64(0.3))
"""Part of the margin that the strain of a cell may use: 1 - ``PART_BESIDE_STRAIN``."""
LARGEST_STRAIN_STEP = wp.constant(wp.float64(0.05))
"""Largest strain on one set of lists: its square, which is neglected, is a small part of a clearance."""
STRAIN_UNIT = wp.constant(10.0)
"""Length of the entry of the strains over a strain, in mean radii: a limit on moves of 0.1 radii is one of 1 %."""
USED_UP = wp.constant(0.7)
"""Part of its budget after which a control point asks for new candidate lists."""


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
