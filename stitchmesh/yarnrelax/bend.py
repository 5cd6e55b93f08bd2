# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bending: a yarn is straight at rest (L eq 7; Kaldor 2008).

Energy of one segment of rest length l:

    E = k_bend l int kappa^2 ds,   kappa = |c| / |y'|^3,   c = y' x y''        [erg]

A ring of radius R holds 2 pi k_bend / R; the flexural rigidity EI is 2 k_bend. Gradients, with t = y', a = y'':

    d kappa^2 / dt = 2 (a x c) / |t|^6 - 6 |c|^2 t / |t|^8,    d kappa^2 / da = 2 (c x t) / |t|^6
"""

from __future__ import annotations

from typing import Any

import warp as wp


@wp.func
def bend_energy(tangent: Any, turn: Any, stiffness: Any) -> Any:
    """Energy [erg] at a point of the curve; ``stiffness`` is k_bend times the rest length."""
    normal = wp.cross(tangent, turn)
    speed2 = wp.dot(tangent, tangent)
    return stiffness * wp.dot(normal, normal) / (speed2 * speed2 * speed2)


@wp.func
def bend_slopes(tangent: Any, turn: Any, inverse: Any, stiffness: Any) -> tuple[Any, Any]:
    """Derivatives of the energy by y' and by y''; ``inverse`` is 1 / |y'|^2."""
    normal = wp.cross(tangent, turn)
    scale = type(stiffness)(2.0) * stiffness * inverse * inverse * inverse
    shrink = type(stiffness)(3.0) * wp.dot(normal, normal) * inverse
    by_tangent = (wp.cross(turn, normal) - tangent * shrink) * scale
    by_turn = wp.cross(normal, tangent) * scale
    return by_tangent, by_turn
