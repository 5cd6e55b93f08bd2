# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The length of a stitch contact of a knit (Cirio et al. 2017, section 4).

    E = 1/2 k_l L (l / L - 1)^2

l is the distance of the two nodes of the contact and L its value in the layout. The energy is not one of sliding: yarn
can run through a contact, but what lies in it keeps its length.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.mixed.crossings.energies.angle import unit_of


@wp.func
def stitch_length_energy(axis: Any, rest: Any, stiffness: Any) -> Any:
    """E [erg]; ``stiffness`` is k_l [dyn]."""
    apart = wp.length(axis) - rest
    return type(rest)(0.5) * stiffness * apart * apart / rest


@wp.func
def stitch_length_force(axis: Any, rest: Any, stiffness: Any) -> Any:
    """Force [dyn] on the axis."""
    direction, _inverse = unit_of(axis)
    return direction * (stiffness * (type(rest)(1.0) - wp.length(axis) / rest))


@wp.func
def stitch_length_product(axis: Any, d_axis: Any, rest: Any, stiffness: Any, exact: Any) -> Any:
    """Product of the Hessian with the direction of the axis."""
    direction, inverse = unit_of(axis)
    along = wp.dot(direction, d_axis)
    slope = stiffness * (wp.length(axis) / rest - type(rest)(1.0))
    tight = wp.max(slope, slope * exact) * inverse
    return direction * (along * stiffness / rest) + (d_axis - direction * along) * tight
