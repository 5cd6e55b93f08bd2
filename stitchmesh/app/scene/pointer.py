# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The places of a mesh under the pointer: under clicks, along drags and in rectangles."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from stitchmesh.app.scene.scene import Pick, ScreenBox, Stroke
from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.mesh.picking import PickedPlace, PickingTable, pick, picking_table

STEP = 0.4
"""Distance on the mesh between the rays of a drag, over the mean side length."""
MOST_RAYS = 200
"""Largest number of rays between two reports of a drag."""


class Pointer:
    """Finds the places of a mesh under rays; the first use makes the table for it."""

    def __init__(self, mesh: Mesh) -> None:
        """Keep the mesh."""
        self.mesh = mesh
        self._table: PickingTable | None = None
        self._before: tuple[FloatArray, FloatArray, float] | None = None

    def place(self, ray: Pick) -> PickedPlace | None:
        """Return the place under a ray; None beside the mesh."""
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
        """Return rays from the last one to this one, so close together that they miss no face between."""
        if self._before is None:
            return [(origin, direction)]
        start, last, depth = self._before
        distance = float(np.linalg.norm(direction - last)) * depth + float(np.linalg.norm(origin - start))
        count = int(np.clip(np.ceil(distance / (STEP * self._side_length)), 1, MOST_RAYS))
        shares = (np.arange(count) + 1) / count
        return [(start + share * (origin - start), last + share * (direction - last)) for share in shares]

    @property
    def _side_length(self) -> float:
        return max(float(self.mesh.side_length.mean()), 1e-9)

    def _pick(self, origin: FloatArray, direction: FloatArray) -> PickedPlace | None:
        if self._table is None:
            self._table = picking_table(self.mesh)
        return pick(self._table, origin, direction)


class DragPath:
    """The places that a drag has passed, without neighbouring repeats of a face."""

    def __init__(self) -> None:
        """Start with no drag."""
        self.places: list[PickedPlace] = []

    def follow(self, stroke: Stroke, pointer: Pointer) -> list[PickedPlace]:
        """Add the places of one moment of a drag, and return all places so far; the start of a drag begins anew."""
        if stroke.phase == "start":
            pointer.begin()
            self.places = []
        self.places = without_repeats([*self.places, *pointer.places_along(stroke)])
        return self.places

    def clear(self) -> None:
        """Forget the drag."""
        self.places = []


def without_repeats(places: list[PickedPlace]) -> list[PickedPlace]:
    """Return places, where neighbouring places lie on different faces."""
    return places[:1] + [place for before, place in pairwise(places) if place.face != before.face]


def visible_faces(mesh: Mesh, box: ScreenBox) -> IntArray:
    """Return the faces whose centres lie in a rectangle on the screen, and whose right sides face the camera."""
    first = mesh.face_start[:-1]
    centre = np.add.reduceat(mesh.corner_position, first, axis=0) / np.diff(mesh.face_start)[:, None]
    inside = np.flatnonzero(box.inside(centre))
    towards = np.asarray(box.camera.position) - centre[inside]
    faces: IntArray = inside[np.einsum("ij,ij->i", towards, mesh.face_vector_area[inside]) > 0.0]
    return faces
