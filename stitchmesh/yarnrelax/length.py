# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Length penalty: a soft stand-in for inextensible segments (L eq 1).

Energy of one segment of rest length l:

    E = k_length (1 - (1 / l) int |y'| ds)^2        [erg]

Its kernels are launched, and compiled, only for a material with k_length > 0.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.yarnrelax.curve import curve_speed, segment_legs

wp.set_module_options({"enable_backward": False})


@wp.func
def length_energy(length: Any, rest_length: Any, stiffness: Any) -> Any:
    """Energy [erg] of a segment that is ``length`` [cm] long."""
    strain = length / rest_length - type(length)(1.0)
    return stiffness * strain * strain


@wp.func
def length_slope(length: Any, rest_length: Any, stiffness: Any) -> Any:
    """Derivative of the energy by the length [erg / cm]."""
    return type(length)(2.0) * stiffness * (length / rest_length - type(length)(1.0)) / rest_length


@wp.func
def segment_length(rule: wp.array[Any], quadrature_points: int, leg0: Any, leg1: Any, leg2: Any) -> Any:
    """Arc length of a segment [cm] by Gauss quadrature."""
    length = leg0[0] - leg0[0]
    for g in range(quadrature_points):
        length += curve_speed(rule[g], leg0, leg1, leg2) * rule[g][5]
    return length


@wp.kernel(module="unique")
def add_length_forces(
    # model
    model: Any,
    # state in
    points: wp.array[Any],
    # state out
    segment_force: wp.array[Any],
) -> None:
    """Add the force [dyn] of the penalty on the four control points of each segment."""
    s = wp.tid()
    corner = model.segment_points[s]
    leg0, leg1, leg2 = segment_legs(points, corner)
    length = segment_length(model.rule, model.quadrature_points, leg0, leg1, leg2)
    slope = length_slope(length, model.segment_rest_length[s], model.k_length)
    pull0, pull1, pull2 = type(leg0)(), type(leg0)(), type(leg0)()
    for g in range(model.quadrature_points):
        rule = model.rule[g]
        tangent = leg0 * rule[0] + leg1 * rule[1] + leg2 * rule[2]
        pull = tangent * (slope * rule[5] / wp.length(tangent))
        pull0 += pull * rule[0]
        pull1 += pull * rule[1]
        pull2 += pull * rule[2]
    segment_force[4 * s] += pull0
    segment_force[4 * s + 1] += pull1 - pull0
    segment_force[4 * s + 2] += pull2 - pull1
    segment_force[4 * s + 3] -= pull2


@wp.kernel(module="unique")
def length_energies(
    # model
    model: Any,
    # state in
    points: wp.array[Any],
    # state out
    segment_energy: wp.array[Any],
) -> None:
    """Energy [erg] of the penalty in each segment."""
    s = wp.tid()
    corner = model.segment_points[s]
    leg0, leg1, leg2 = segment_legs(points, corner)
    length = segment_length(model.rule, model.quadrature_points, leg0, leg1, leg2)
    segment_energy[s] = length_energy(length, model.segment_rest_length[s], model.k_length)
