# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wrapping of two yarns around one another in a stitch contact of a knit (Cirio et al. 2017, section 4).

    E = 1/2 k_w L (t - r)^2

The axis of a stitch contact joins its two nodes; L is its length in the layout. A leg of one yarn and a leg of the
other one span two half planes with it, and t is their angle (``dihedral``): 0 in the flat layout, in which the legs
lie on opposite sides. The angle at rest is a quarter turn: r = +pi/2 or -pi/2. Seen with the axis upwards and the
first leg on its left, a positive angle turns both legs away from the viewer. The matrix that is never negative keeps
k_w L grad t grad t^T.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.mixed.crossings.dihedral import dihedral_gradient, dihedral_hessian, dihedral_of

TURN = wp.constant(6.283185307179586)


@wp.func
def unwrapped(axis: Any, a: Any, b: Any, rest: Any) -> Any:
    """T - r, in the turn around the axis that is shorter."""
    apart = dihedral_of(axis, a, b) - rest
    turn = type(rest)(TURN)
    return apart - turn * wp.floor(apart / turn + type(rest)(0.5))


@wp.func
def wrapping_energy(axis: Any, a: Any, b: Any, rest: Any, stiffness: Any) -> Any:
    """E [erg]; ``stiffness`` is k_w L."""
    apart = unwrapped(axis, a, b, rest)
    return type(rest)(0.5) * stiffness * apart * apart


@wp.func
def wrapping_force(axis: Any, a: Any, b: Any, rest: Any, stiffness: Any) -> tuple[Any, Any, Any]:
    """Forces [dyn] on the axis, a and b."""
    by_axis, by_a, by_b = dihedral_gradient(axis, a, b)
    pull = -stiffness * unwrapped(axis, a, b, rest)
    return by_axis * pull, by_a * pull, by_b * pull


@wp.func
def wrapping_product(
    axis: Any, a: Any, b: Any, d_axis: Any, da: Any, db: Any, rest: Any, stiffness: Any, exact: Any
) -> tuple[Any, Any, Any]:
    """Product of the Hessian with a direction; the parts of the axis, a and b."""
    by_axis, by_a, by_b = dihedral_gradient(axis, a, b)
    change = stiffness * (wp.dot(by_axis, d_axis) + wp.dot(by_a, da) + wp.dot(by_b, db))
    slope = stiffness * unwrapped(axis, a, b, rest) * exact
    of_axis, of_a, of_b = dihedral_hessian(axis, a, b, d_axis, da, db)
    return by_axis * change + of_axis * slope, by_a * change + of_a * slope, by_b * change + of_b * slope
