# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Length penalty: a soft stand-in for inextensible segments (L eq 1).

Energy of one segment of rest length l:

    E = k_length (1 - (1 / l) int |y'| ds)^2        [erg]
"""

from __future__ import annotations

from typing import Any

import warp as wp


@wp.func
def length_energy(length: Any, rest_length: Any, stiffness: Any) -> Any:
    """Energy [erg] of a segment that is ``length`` long."""
    strain = length / rest_length - type(length)(1.0)
    return stiffness * strain * strain


@wp.func
def length_slope(length: Any, rest_length: Any, stiffness: Any) -> Any:
    """Derivative of the energy by the length."""
    return type(length)(2.0) * stiffness * (length / rest_length - type(length)(1.0)) / rest_length
