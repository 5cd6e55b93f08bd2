# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bending of a yarn that is straight at rest (L eq 7; Kaldor 2008), or has a natural curvature k.

Energy of one segment of rest length l:

    E = k_bend l int (kappa - k)^2 ds,   kappa = |c| / |y'|^3,   c = y' x y'',   k >= 0        [erg]

A ring of radius R has the energy 2 pi R k_bend (1 / R - k)^2; the flexural rigidity EI is 2 k_bend. The yarn can rotate
about its own axis without energy. Its natural curvature therefore points in the direction of its curvature, because
this rotation has the least energy of all. The gradients are the gradients of a straight yarn, with t = y'
and a = y'', times 1 - k / kappa:

    d kappa^2 / dt = 2 (a x c) / |t|^6 - 6 |c|^2 t / |t|^8,    d kappa^2 / da = 2 (c x t) / |t|^6

This energy has a kink at kappa = 0. Below q k, with q = 1/4, it continues as the parabola in kappa that has the same
value and slope at q k, (1 - q) k^2 - (1/q - 1) kappa^2. A straight segment has 3/4 of the exact energy.
"""

from __future__ import annotations

from typing import Any

import warp as wp

NEARLY_STRAIGHT = wp.constant(0.25)
"""Below this part of the natural curvature the energy continues as a parabola."""


@wp.func
def bend_energy(tangent: Any, turn: Any, stiffness: Any, natural: Any) -> Any:
    """Energy [erg] at a point of the curve; ``stiffness`` is k_bend times the rest length."""
    normal = wp.cross(tangent, turn)
    speed2 = wp.dot(tangent, tangent)
    curvature2 = wp.dot(normal, normal) / (speed2 * speed2 * speed2)
    if natural > type(natural)(0.0):
        part, one = type(natural)(NEARLY_STRAIGHT), type(natural)(1.0)
        least, away = part * natural, wp.sqrt(curvature2) - natural
        if curvature2 < least * least:
            return stiffness * ((one - part) * natural * natural - (one / part - one) * curvature2)
        return stiffness * away * away
    return stiffness * curvature2


@wp.func
def bend_slopes(tangent: Any, turn: Any, inverse: Any, stiffness: Any, natural: Any) -> tuple[Any, Any]:
    """Derivatives of the energy by y' and by y''; ``inverse`` is 1 / |y'|^2."""
    normal = wp.cross(tangent, turn)
    scale = type(stiffness)(2.0) * stiffness * inverse * inverse * inverse
    if natural > type(natural)(0.0):
        curvature = wp.sqrt(wp.dot(normal, normal) * inverse) * inverse
        scale *= type(natural)(1.0) - natural / wp.max(curvature, type(natural)(NEARLY_STRAIGHT) * natural)
    shrink = type(stiffness)(3.0) * wp.dot(normal, normal) * inverse
    by_tangent = (wp.cross(turn, normal) - tangent * shrink) * scale
    by_turn = wp.cross(normal, tangent) * scale
    return by_tangent, by_turn
