# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Shear of a weave at a crossing node (Cirio et al. 2014, section 4.4).

    E = 1/2 k_x L (f - r)^2,    k_x = S R^2

f is the angle between a segment of the warp and a segment of the weft that meet in the node, r the same angle in the
layout (pi / 2 as a rule), and L the rest length between crossings. An inner node has four such pairs of segments, one
for each quadrant, each with this energy; a node at a border has those whose segments exist.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.mixed.crossings.angle import angle_frame, angle_of, angle_product, over_sine


@wp.func
def shear_energy(angle: Any, rest: Any, stiffness: Any) -> Any:
    """E [erg]; ``stiffness`` is k_x L."""
    return type(angle)(0.5) * stiffness * (angle - rest) * (angle - rest)


@wp.func
def shear_product(warp: Any, weft: Any, d_warp: Any, d_weft: Any, rest: Any, stiffness: Any, exact: Any) -> tuple[Any, Any]:
    """Product of the Hessian with the directions of both segments; their parts."""
    zero = type(rest)(0.0)
    _p, _q, _z, sine = angle_frame(warp, weft)
    slope = stiffness * (angle_of(warp, weft) - rest)
    curvatures = type(warp)(stiffness, zero, zero)
    side = over_sine(slope, sine)
    of_warp, of_weft, _rest = angle_product(warp, weft, d_warp, d_weft, zero, slope, side, curvatures, exact)
    return of_warp, of_weft
