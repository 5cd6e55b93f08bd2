# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The guard against nodes that merge: finite energies where two nodes of a yarn come close along it.

The energies of a segment hold 1 / D, where D is the rest length of yarn between two nodes. When sliding makes D small,
stiffness grows without bound, and at D = 0 the energy has no value. Two measures keep it finite.

*The inverse.* Below the merging distance e, 1 / D is replaced by its Taylor polynomial of second order at e, which has
a value for every D and no stiffness beyond that at e:

    i(D) = 1 / D  for D >= e,   else  (1 + t + t^2) / e  with  t = (e - D) / e

*The spring.* A segment whose nodes have merged in space (length 0) has the stretch energy k_s D / 2, which shortens D
with the force k_s / 2, and the published contact of parallel yarns is far weaker than that. A spring therefore opens
D below twice the merging distance, g = 2 e:

    E = 1/2 (STRENGTH k_s / g) (g - D)^2  for D < g, else 0

At length 0 it balances the stretch at D = g (1 - 1 / (2 STRENGTH)) = 1.9 e. Only a strain of the segment beside it
above sqrt(STRENGTH) - 1 = 2.2 presses D below e. The merging distance is
``MERGING_SHARE`` of the rest length or of the contact distance, whichever is smaller, so that both measures are
without effect in any state that yarns of their thickness can reach.
"""

from __future__ import annotations

from typing import Any

import warp as wp

MERGING_SHARE = 0.1
"""Merging distance e as a share of the rest length or of the contact distance of a segment."""
STRENGTH = wp.constant(10.0)
"""Force of the opening spring at D = 0, as a multiple of k_s."""


@wp.func
def guarded_inverse(rest: Any, merging: Any) -> tuple[Any, Any, Any]:
    """i(D) [1/cm] and its first and second derivative."""
    one, two = type(rest)(1.0), type(rest)(2.0)
    inverse = one / wp.max(rest, merging)
    t = wp.max(merging - rest, type(rest)(0.0)) * inverse
    return inverse * (one + t + t * t), -inverse * inverse * (one + two * t), two * inverse * inverse * inverse


@wp.func
def opening_spring(rest: Any, merging: Any, stiffness: Any) -> tuple[Any, Any, Any]:
    """Energy [erg] of the spring that opens a segment, and its derivatives by D [dyn], [dyn/cm]."""
    zero, half, two = type(rest)(0.0), type(rest)(0.5), type(rest)(2.0)
    reach = two * merging
    closed = reach - rest
    pull = stiffness * type(rest)(STRENGTH) / reach
    if closed <= zero:
        pull = zero
    return half * pull * closed * closed, -pull * closed, pull
