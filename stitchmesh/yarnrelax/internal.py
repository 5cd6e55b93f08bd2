# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The forces a yarn exerts on itself: stretch and bending of all segments in one pass."""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.yarnrelax.bend import bend_energy, bend_slopes
from stitchmesh.yarnrelax.curve import segment_legs
from stitchmesh.yarnrelax.stretch import stretch_energy, stretch_slope

wp.set_module_options({"enable_backward": False})


@wp.kernel(module="unique")
def internal_forces(
    # model
    model: Any,
    k_len: Any,
    k_bend: Any,
    # state in
    points: wp.array[Any],
    # state out
    segment_force: wp.array[Any],
) -> None:
    """Force [dyn] of stretch and bending on the four control points of each segment."""
    s = wp.tid()
    corner = model.segment_points[s]
    rest_length = model.segment_rest_length[s]
    leg0, leg1, leg2 = segment_legs(points, corner)
    turn0, turn1 = leg1 - leg0, leg2 - leg1
    pull0, pull1, pull2 = type(leg0)(), type(leg0)(), type(leg0)()
    for g in range(model.quadrature_points):
        rule = model.rule[g]
        tangent = leg0 * rule[0] + leg1 * rule[1] + leg2 * rule[2]
        turn = turn0 * rule[3] + turn1 * rule[4]
        speed = wp.length(tangent)
        by_tangent, by_turn = bend_slopes(tangent, turn, k_bend * rest_length * rule[5])
        by_tangent += tangent * (stretch_slope(speed, rest_length, k_len * rule[5]) / speed)
        first, last = by_turn * rule[3], by_turn * rule[4]
        pull0 += by_tangent * rule[0] - first
        pull1 += by_tangent * rule[1] + first - last
        pull2 += by_tangent * rule[2] + last
    segment_force[4 * s] = pull0
    segment_force[4 * s + 1] = pull1 - pull0
    segment_force[4 * s + 2] = pull2 - pull1
    segment_force[4 * s + 3] = -pull2


@wp.kernel(module="unique")
def internal_energies(
    # model
    model: Any,
    # state in
    points: wp.array[Any],
    # state out
    stretch: wp.array[Any],
    bend: wp.array[Any],
) -> None:
    """Stretch and bending energy [erg] of each segment."""
    s = wp.tid()
    corner = model.segment_points[s]
    rest_length = model.segment_rest_length[s]
    leg0, leg1, leg2 = segment_legs(points, corner)
    in_stretch, in_bend = rest_length - rest_length, rest_length - rest_length
    for g in range(model.quadrature_points):
        rule = model.rule[g]
        tangent = leg0 * rule[0] + leg1 * rule[1] + leg2 * rule[2]
        turn = (leg1 - leg0) * rule[3] + (leg2 - leg1) * rule[4]
        in_stretch += stretch_energy(wp.length(tangent), rest_length, model.k_len * rule[5])
        in_bend += bend_energy(tangent, turn, model.k_bend * rest_length * rule[5])
    stretch[s] = in_stretch
    bend[s] = in_bend
