# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The longest step along a direction in which no segment of yarn loses more than a share of its rest length.

A line search starts with this step, so that nodes that slide towards one another come closer by a factor at most and
never pass: D + t dD >= (1 - share) D. A segment that is shorter than its merging distance e already may lose the share
of e (``merging``).
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.crossings.crossing_model import CrossingModel
from stitchmesh.mixed.crossings.star.star import coordinate_of
from stitchmesh.mixed.mixed_vector import MixedVector


@kernel
def find_step_limits(
    # model
    link: wp.array2d[wp.int32],
    slides: wp.array[Any],
    segment: wp.array2d[Any],
    share: Any,
    # state in
    sliding: wp.array[Any],
    direction: wp.array[Any],
    # state out
    limit: wp.array[Any],
) -> None:
    """Longest step of the segments after each node, at most 1."""
    i = wp.tid()
    one = type(share)(1.0)
    longest = type(share)(1.0)
    for c in range(2):
        after = link[i, 2 * c]
        if after >= 0:
            rest = coordinate_of(after, sliding, one) - sliding[i][c]
            ahead = coordinate_of(after, direction, one) * coordinate_of(after, slides, one)
            loss = direction[i][c] * slides[i][c] - ahead
            allowed = share * wp.max(rest, segment[i, c][3])
            if loss * longest > allowed:
                longest = allowed / loss
    limit[i] = longest


def sliding_limits(
    model: CrossingModel,
    state: MixedVector,
    direction: MixedVector,
    limits: wp.array[Any],
    launcher: Launcher,
    *,
    share: float = 0.5,
) -> list[Any]:
    """The launch that finds the longest step t in (0, 1] along a direction for the segments of each node.

    Args:
        model: the segments.
        state: Eulerian coordinates at the beginning of the step [cm].
        direction: what a step of 1 adds to the state.
        limits: set to t of each node, shape (N,).
        launcher: ``launch`` or ``prepare`` with the device bound.
        share: share of its rest length that a segment may lose, in (0, 1).

    Raises:
        ParameterError: the share is out of range.
    """
    if not 0.0 < share < 1.0:
        raise ParameterError(f"step limit: got a share of {share}; expected a number between 0 and 1")
    if model.count == 0:
        return []
    inputs = [model.link, model.slides, model.segment, state.scalar(share), state.sliding, direction.sliding]
    return [launcher(find_step_limits, model.count, inputs, [limits])]
