# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far a control point may move in one iteration, and the move."""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel


@wp.func
def room_left(points: wp.array[Any], listed_points: wp.array[Any], budget: wp.array[Any], i: int) -> Any:
    """How far control point ``i`` may still go before the candidate lists are made again (``step_limit``)."""
    return wp.max(budget[i] - wp.length(points[i] - listed_points[i]), budget[i] - budget[i])


@kernel
def move_points(
    # state in
    step: wp.array[Any],
    # state out
    points: wp.array[Any],
) -> None:
    """Move."""
    i = wp.tid()
    points[i] = points[i] + step[i]


@kernel
def wear(
    # state in
    points: wp.array[Any],
    listed_points: wp.array[Any],
    budget: wp.array[Any],
    # state out
    worn: wp.array[Any],
) -> None:
    """Part of its budget that each control point has used up."""
    i = wp.tid()
    worn[i] = wp.length(points[i] - listed_points[i]) / budget[i]
