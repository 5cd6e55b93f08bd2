# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows as lists of faces, and stacks of rows that run around a tube."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.courses import right_neighbours
from stitchmesh.mesh import BORDER, IntArray, StitchMesh


@dataclass(frozen=True)
class Strip:
    """Faces that one row leads through, from left to right."""

    faces: tuple[int, ...]
    is_ring: bool
    """Whether the last face lies beside the first."""


def strips(fabric: StitchMesh) -> list[Strip]:
    """All rows; a ring starts at its lowest face."""
    following = right_neighbours(fabric).tolist()
    ends = sorted(set(range(fabric.face_count)) - set(following))
    seen, result = [False] * fabric.face_count, []
    for first in [*ends, *range(fabric.face_count)]:
        faces, face = [], first
        while face != BORDER and not seen[face]:
            seen[face] = True
            faces.append(face)
            face = following[face]
        if faces:
            result.append(Strip(tuple(faces), face == first))
    return result


def ring_stacks(fabric: StitchMesh) -> list[list[Strip]]:
    """Maximal stacks of rings, each from below: the whole top of one is the whole bottom of the next."""
    rings = [strip for strip in strips(fabric) if strip.is_ring]
    ring_of = np.full(fabric.face_count, BORDER)
    for number, ring in enumerate(rings):
        ring_of[list(ring.faces)] = number
    above = [_only_neighbour(fabric, ring, ring_of, 2) for ring in rings]
    below = [_only_neighbour(fabric, ring, ring_of, 0) for ring in rings]
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


def _only_neighbour(fabric: StitchMesh, ring: Strip, ring_of: IntArray, role: int) -> int:
    """The ring that lies across all top (2) or all bottom (0) sides of a ring the same way up, else ``BORDER``."""
    sides = np.flatnonzero(np.isin(fabric.side_face, ring.faces) & (fabric.side_role == role))
    across = fabric.twin[sides]
    if len(sides) == 0 or (across == BORDER).any() or (fabric.side_role[across] != 2 - role).any():
        return BORDER
    found = np.unique(ring_of[fabric.side_face[across]])
    return int(found[0]) if len(found) == 1 else BORDER
