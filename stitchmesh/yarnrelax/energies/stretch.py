# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stretch: the resistance of a yarn to another length, or distribution of length, than at rest (L eq 8; Kaldor 2008).

Energy of one segment of rest length l, with y' the derivative by its parameter s in [0, 1]:

    E = k_len int (1 - |y'| / l)^2 ds        [erg]

Under a uniform stretch by lambda every segment has the energy k_len (1 - lambda)^2. The length penalty depends on the
length of the whole segment. It replaces the constraint of inextensible segments (L eq 1):

    E = k_length (1 - (1 / l) int |y'| ds)^2        [erg]
"""

from __future__ import annotations

from typing import Any

import warp as wp


@wp.func
def stretch_energy(speed: Any, rest_length: Any, stiffness: Any) -> Any:
    """Energy [erg] at a point of the curve where |y'| is ``speed`` [cm]."""
    strain = speed / rest_length - type(speed)(1.0)
    return stiffness * strain * strain


@wp.func
def stretch_slope(speed: Any, per_length: Any, stiffness: Any) -> Any:
    """Derivative of the energy by the speed; ``per_length`` is 1 over the rest length."""
    return type(speed)(2.0) * stiffness * (speed * per_length - type(speed)(1.0)) * per_length


@wp.func
def length_energy(length: Any, rest_length: Any, stiffness: Any) -> Any:
    """Energy [erg] of a segment that is ``length`` long."""
    strain = length / rest_length - type(length)(1.0)
    return stiffness * strain * strain


@wp.func
def length_slope(length: Any, rest_length: Any, stiffness: Any) -> Any:
    """Derivative of the energy by the length."""
    return type(length)(2.0) * stiffness * (length / rest_length - type(length)(1.0)) / rest_length
