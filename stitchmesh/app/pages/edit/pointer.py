# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the pointer is over: places of a fabric under clicks and along drags."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from stitchmesh.app.scene.scene import Pick
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, BOTTOM, TOP, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.picking import PickedPlace, PickingTable, pick, picking_table

STEP = 0.4
"""Distance on the fabric between the rays of a drag, divided by the mean side length."""
MOST_RAYS = 200
"""Largest number of rays between two reports of a drag."""


class Pointer:
    """Finds the places of a fabric under rays; the table for it is made when it is first needed."""

    def __init__(self, fabric: StitchMesh) -> None:
        """Keep the fabric."""
        self.fabric = fabric
        self._table: PickingTable | None = None
        self._before: tuple[FloatArray, FloatArray, float] | None = None

    def place(self, ray: Pick) -> PickedPlace | None:
        """Return the place under a ray, or None beside the fabric."""
        return self._pick(ray.ray_origin, ray.ray_direction)

    def begin(self) -> None:
        """Begin a drag."""
        self._before = None

    def places_along(self, ray: Pick) -> list[PickedPlace]:
        """Return the places that the pointer passed since the last report of a drag, in order."""
        origin, direction = np.asarray(ray.ray_origin), np.asarray(ray.ray_direction)
        direction = direction / np.linalg.norm(direction)
        found = [self._pick(*between) for between in self._rays(origin, direction)]
        places = [place for place in found if place is not None]
        depth = places[-1].depth if places else self._before[2] if self._before else 0.0
        self._before = origin, direction, depth
        return places

    def _rays(self, origin: FloatArray, direction: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
        """Return rays from the last one to this one, so close that no stitch between them is missed."""
        if self._before is None:
            return [(origin, direction)]
        start, last, depth = self._before
        distance = float(np.linalg.norm(direction - last)) * depth + float(np.linalg.norm(origin - start))
        count = int(np.clip(np.ceil(distance / (STEP * self._side_length)), 1, MOST_RAYS))
        shares = (np.arange(count) + 1) / count
        return [(start + share * (origin - start), last + share * (direction - last)) for share in shares]

    @property
    def _side_length(self) -> float:
        return max(float(self.fabric.side_length.mean()), 1e-9)

    def _pick(self, origin: FloatArray, direction: FloatArray) -> PickedPlace | None:
        if self._table is None:
            self._table = picking_table(self.fabric)
        return pick(self._table, origin, direction)


def nearest_side(fabric: StitchMesh, place: PickedPlace, kind: str) -> int:
    """Return the side of a kind that is nearest to a place, among the sides of its face.

    Args:
        fabric: the fabric.
        place: the place.
        kind: ``course side``, ``wale side``, ``top side`` (of the face, or of the face below), or ``border side``.

    Raises:
        ParameterError: the face has no side of this kind.
    """
    sides = fabric.sides_of(np.array([place.face]))
    role = fabric.role_of(sides)
    if kind == "wale side":
        fitting = sides[role % 2 == 1]
    elif kind == "border side":
        fitting = sides[fabric.twin[sides] == BORDER]
    elif kind == "top side":
        return _nearest_top_side(fabric, place, sides, role)
    else:
        fitting = sides[role % 2 == 0]
    if not len(fitting):
        raise ParameterError(f"face {place.face}: has no {kind}; click another stitch")
    return _nearest(fabric, place, fitting)


def _nearest_top_side(fabric: StitchMesh, place: PickedPlace, sides: IntArray, role: IntArray) -> int:
    """Return the nearest top side: one of the face, or the one of a face below across a bottom side."""
    below = sides[role == BOTTOM]
    below = below[fabric.twin[below] != BORDER]
    below = below[fabric.role_of(fabric.twin[below]) == TOP] if len(below) else below
    fitting = np.concatenate([sides[role == TOP], below])
    if not len(fitting):
        raise ParameterError(f"face {place.face}: has no loop above or below; click another stitch")
    side = _nearest(fabric, place, fitting)
    return side if fabric.role_of(side) == TOP else int(fabric.twin[side])


def _nearest(fabric: StitchMesh, place: PickedPlace, sides: IntArray) -> int:
    """Return the side that is nearest to a place."""
    start, end = fabric.corner_position[sides], fabric.corner_position[fabric.side_next[sides]]
    along = end - start
    length = np.einsum("ij,ij->i", along, along)
    share = np.clip(np.einsum("ij,ij->i", place.point - start, along) / np.where(length > 0, length, 1.0), 0.0, 1.0)
    distance = np.linalg.norm(start + share[:, None] * along - place.point, axis=1)
    return int(sides[distance.argmin()])


def without_repeats(faces: list[int]) -> list[int]:
    """Return faces without neighbouring repeats."""
    return faces[:1] + [face for before, face in pairwise(faces) if face != before]
