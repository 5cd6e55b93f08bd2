# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact of neighbouring parallel yarns, along the yarn that both cross (Cirio et al. 2014, section 4.5).

    E = 1/2 k_c L (D - d)^2  for D < d, else 0

D is the rest length of yarn between the two crossings, L its value in the layout, and d the contact distance. Between
two crossings of which the yarn passes one above and one below, d = 4 R; on the same side, d = 2 R. Where the layout is
denser, d = L, so that a fabric as laid out has no contact energy.
"""

from __future__ import annotations

from typing import Any

import warp as wp


@wp.func
def contact_terms(rest: Any, distance: Any, stiffness: Any) -> tuple[Any, Any, Any]:
    """E [erg], E_D [dyn] and E_DD [dyn/cm]; ``stiffness`` is k_c L."""
    zero, half = type(rest)(0.0), type(rest)(0.5)
    depth = distance - rest
    push = stiffness
    if depth <= zero:
        push = zero
    return half * push * depth * depth, -push * depth, push
