# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stretch of a segment of yarn between two crossing nodes (Cirio et al. 2014, section 4.2).

With the length l = |x1 - x0| in space and the rest length D = u1 - u0 of the yarn between the nodes, |w| = l / D and

    E = 1/2 k_s D (|w| - 1)^2 = 1/2 k_s (l^2 / D - 2 l + D)

The energy is convex in (l, D): its second derivatives k_s / D (1, -|w|; -|w|, w^2) have rank one. Below the merging
distance 1 / D is replaced by i(D) (``merging``), where D i(D) - 1 = -t^3.

The functions subtract l and D before anything else, because strains of 1e-4 are common and single precision has seven
digits: l^2 i(D) - 2 l + D = (l - D)^2 i(D) - t^3 (2 l - D).
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.mixed.crossings.energies.merging import guarded_inverse


@wp.func
def stretch_energy(length: Any, rest: Any, merging: Any, stiffness: Any) -> Any:
    """E [erg]."""
    zero, half, two = type(rest)(0.0), type(rest)(0.5), type(rest)(2.0)
    inverse, _slope, _bend = guarded_inverse(rest, merging)
    t = wp.max(merging - rest, zero) / wp.max(rest, merging)
    apart = length - rest
    return half * stiffness * (apart * apart * inverse - t * t * t * (two * length - rest))


@wp.func
def stretch_slopes(length: Any, rest: Any, merging: Any, stiffness: Any) -> tuple[Any, Any]:
    """E_l and E_D [dyn]."""
    zero, half, two = type(rest)(0.0), type(rest)(0.5), type(rest)(2.0)
    inverse, _slope, _bend = guarded_inverse(rest, merging)
    most = wp.max(rest, merging)
    t, strain = wp.max(merging - rest, zero) / most, (length - most) / most
    by_length = stiffness * ((length - rest) * inverse - t * t * t)
    return by_length, -half * stiffness * (strain * (length + most) + two * t * length * length / most) / most


@wp.func
def stretch_curvatures(length: Any, rest: Any, merging: Any, stiffness: Any) -> tuple[Any, Any, Any]:
    """E_ll, E_lD and E_DD [dyn/cm]."""
    half = type(rest)(0.5)
    inverse, slope, bend = guarded_inverse(rest, merging)
    return stiffness * inverse, stiffness * length * slope, half * stiffness * length * length * bend
