# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Anchors of friction on the surface of a body: points that move with a triangle of the surface."""

from __future__ import annotations

from typing import Any

import warp as wp

NO_ANCHOR = wp.constant(-1)
"""Number of the triangle for a point without an anchor, which does not touch the body."""


@wp.func
def anchor_place(surface: Any, face: int, local: Any) -> Any:
    """The place of an anchor, from its coordinates along two sides of a triangle and its normal."""
    start = surface.corners[3 * face]
    along = surface.corners[3 * face + 1] - start
    other = surface.corners[3 * face + 2] - start
    return start + along * local[0] + other * local[1] + surface.outward[7 * face] * local[2]


@wp.func
def anchor_at(surface: Any, face: int, place: Any) -> Any:
    """Coordinates of a place along two sides of a triangle and its normal."""
    apart = place - surface.corners[3 * face]
    along = surface.corners[3 * face + 1] - surface.corners[3 * face]
    other = surface.corners[3 * face + 2] - surface.corners[3 * face]
    normal = wp.cross(along, other)
    square = wp.dot(normal, normal)
    first = wp.dot(wp.cross(apart, other), normal) / square
    second = wp.dot(wp.cross(along, apart), normal) / square
    return type(place)(first, second, wp.dot(apart, surface.outward[7 * face]))
