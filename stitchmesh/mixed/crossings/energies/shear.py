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

from stitchmesh.mixed.crossings.energies.angle import angle_blocks, angle_frame, over_sine, place_of


@wp.func
def shear_energy(angle: Any, rest: Any, stiffness: Any) -> Any:
    """E [erg]; ``stiffness`` is k_x L."""
    return type(angle)(0.5) * stiffness * (angle - rest) * (angle - rest)


@wp.func
def shear_blocks(warp: Any, weft: Any, rest: Any, stiffness: Any, exact: Any) -> tuple[Any, Any, Any]:
    """Blocks of the Hessian of the leg of the warp, of both legs, and of the leg of the weft."""
    angle, sine, p, q, z, by_a, by_b = angle_frame(place_of(warp), place_of(weft))
    slope = stiffness * (angle - rest)
    aa, ab, bb = angle_blocks(p, q, z, by_a, by_b, slope, over_sine(slope, sine), stiffness, exact)
    return aa, ab, bb
