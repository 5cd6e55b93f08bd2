# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yield of bending: a yarn that is bent by too much keeps a part of it.

At a node with the angle t, the rest angle r and the span D, the change of curvature from rest is 2 (t - r) / D
(``bending``). Beyond the yield curvature kappa_y the rest angle follows (ideal plasticity):

    r <- t - max(-y, min(t - r, y)),    y = kappa_y D / 2

It changes once a step, after the step is accepted, so that a step has one elastic energy.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.mixed.crossings.energies.angle import angle_of, place_of
from stitchmesh.mixed.crossings.star.star import leg_of


@kernel
def turn_after_yield(
    # model
    link: wp.array2d[wp.int32],
    yield_curvature: wp.array2d[Any],
    # state in
    nodes: wp.array[Any],
    sliding: wp.array[Any],
    # state out
    turn: wp.array2d[Any],
) -> None:
    """Let the rest angles of both yarns of each node follow the angles beyond their limits."""
    i = wp.tid()
    n = int(2)
    for c in range(n):
        after, before = link[i, 2 * c], link[i, 2 * c + 1]
        if after >= 0 and before >= 0:
            leg, other = leg_of(link, nodes, sliding, i, 2 * c), leg_of(link, nodes, sliding, i, 2 * c + 1)
            angle, span = angle_of(-place_of(other), place_of(leg)), leg[3] - other[3]
            most = yield_curvature[i, c] * span * type(span)(0.5)
            turn[i, c] = angle - wp.clamp(angle - turn[i, c], -most, most)
