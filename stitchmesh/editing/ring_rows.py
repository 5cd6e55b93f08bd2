# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows that run around a tube (rings), stacks of rings, and stacks that are cut along a wale."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import BORDER, BOTTOM, TOP, IntArray, StitchMesh
from stitchmesh.mesh.courses import Course, bottom_sides, find_courses, sides_across, top_sides


@dataclass(frozen=True)
class CutRings:
    """A stack of rings that is cut along a seam."""

    rings: list[list[int]]
    """Faces of each ring, from the face to the right of the seam around to the face on its left."""

    @property
    def firsts(self) -> list[int]:
        """Faces to the right of the seam, from below."""
        return [ring[0] for ring in self.rings]

    @property
    def lasts(self) -> list[int]:
        """Faces to the left of the seam, from below."""
        return [ring[-1] for ring in self.rings]


def ring_stacks(fabric: StitchMesh) -> list[list[Course]]:
    """Return the maximal stacks of rings, each from below; the top of a ring is exactly the bottom of the next ring."""
    rings = [ring for ring in find_courses(fabric, climbing=True) if ring.closed]
    ring_of = np.full(fabric.face_count, BORDER)
    for number, ring in enumerate(rings):
        ring_of[list(ring.faces)] = number
    above = [_only_neighbour(fabric, ring, ring_of, TOP) for ring in rings]
    below = [_only_neighbour(fabric, ring, ring_of, BOTTOM) for ring in rings]
    stacks, used = [], [False] * len(rings)
    for number in range(len(rings)):
        lowest = number
        while (under := below[lowest]) != BORDER and above[under] == lowest and under != number:
            lowest = under
        stack = []
        while lowest != BORDER and not used[lowest]:
            used[lowest] = True
            stack.append(rings[lowest])
            over = above[lowest]
            lowest = over if over != BORDER and below[over] == lowest else BORDER
        if stack:
            stacks.append(stack)
    return stacks


def _only_neighbour(fabric: StitchMesh, ring: Course, ring_of: IntArray, role: int) -> int:
    """Return the ring with the same wale direction across all top or bottom sides of a ring, or ``BORDER``."""
    sides = top_sides(fabric, ring.faces) if role == TOP else bottom_sides(fabric, ring.faces)
    across = sides_across(fabric, np.array(sides, dtype=np.int64), BOTTOM if role == TOP else TOP)
    if len(sides) == 0 or (across == BORDER).any():
        return BORDER
    found = np.unique(ring_of[fabric.side_face[across]])
    return int(found[0]) if len(found) == 1 else BORDER
