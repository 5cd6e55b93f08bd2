# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stretch of a segment of yarn between two crossing nodes (Cirio et al. 2014, section 4.2).

With the length l = |x1 - x0| in space and the rest length D = u1 - u0 of the yarn between the nodes, |w| = l / D and

    E = 1/2 k_s D (|w| - 1)^2 = 1/2 k_s (l^2 / D - 2 l + D)

The energy is convex in (l, D): its second derivatives k_s / D (1, -|w|; -|w|, w^2) have rank one. Below the merging
distance 1 / D is replaced by i(D) (``merging``).
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.mixed.crossings.merging import guarded_inverse


@wp.func
def stretch_energy(length: Any, rest: Any, merging: Any, stiffness: Any) -> Any:
    """E [erg]."""
    half, two = type(rest)(0.5), type(rest)(2.0)
    inverse, _slope, _bend = guarded_inverse(rest, merging)
    return half * stiffness * (length * (length * inverse - two) + rest)


@wp.func
def stretch_slopes(length: Any, rest: Any, merging: Any, stiffness: Any) -> tuple[Any, Any]:
    """E_l and E_D [dyn]."""
    one, half = type(rest)(1.0), type(rest)(0.5)
    inverse, slope, _bend = guarded_inverse(rest, merging)
    return stiffness * (length * inverse - one), half * stiffness * (length * length * slope + one)


@wp.func
def stretch_curvatures(length: Any, rest: Any, merging: Any, stiffness: Any) -> tuple[Any, Any, Any]:
    """E_ll, E_lD and E_DD [dyn/cm]."""
    half = type(rest)(0.5)
    inverse, slope, bend = guarded_inverse(rest, merging)
    return stiffness * inverse, stiffness * length * slope, half * stiffness * length * length * bend
