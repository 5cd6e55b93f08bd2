# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The points of tips and lines, as small octahedra that a drag moves."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stitchmesh.app.pages.rows.marks import Marks
from stitchmesh.app.scene.drawing import OCTAHEDRON_FACES, Colour, Colours, Surface, point_marks
from stitchmesh.app.scene.scene import Pick, Scene
from stitchmesh.mesh import FloatArray

SIZE = 0.014
"""Size of a handle, over the size of the mesh."""
REACH = 0.01
"""Largest angle between a click and the handle that it selects [rad], about eleven pixels."""


class MarkHandles:
    """Draws the points of marks, and finds them under the pointer."""

    def __init__(self, scene: Scene, size: float) -> None:
        """Draw nothing yet; ``size`` is the size of the mesh [cm]."""
        self._scene, self._size = scene, size
        self._names: list[tuple[int, int]] = []
        self._points: FloatArray = np.zeros((0, 3))
        self._triangles = np.zeros((0, 3), dtype=np.int64)

    def show(
        self, marks: Marks, chosen: tuple[int, int] | None, colours: Mapping[str, Colour], chosen_colour: Colour
    ) -> None:
        """Draw the points; if their number is the same, the handles move in place, so that a drag of one goes on."""
        self._names = [
            (number, place)
            for number, mark in enumerate(marks)
            if mark.kind != "border"
            for place in range(1 if mark.kind == "point" else len(mark.points))
        ]
        if not self._names:
            self._scene.remove("handles")
            return
        self._points = np.array([marks[number].points[place] for number, place in self._names], dtype=np.float64)
        drawn = point_marks(self._points, SIZE * self._size, chosen_colour)
        if len(self._triangles) != len(drawn.triangles):
            self._triangles = drawn.triangles
        rgb = [chosen_colour if name == chosen else colours[marks[name[0]].role] for name in self._names]
        of_faces = Colours.of(np.repeat(np.array(rgb, dtype=np.uint8), len(OCTAHEDRON_FACES), axis=0))
        self._scene.show("handles", Surface(drawn.points, self._triangles, of_faces, takes_strokes=True))

    def under(self, pick: Pick, depth: float | None) -> tuple[int, int] | None:
        """Return the mark and the point whose handle is under the pointer; None without one.

        Args:
            pick: the ray.
            depth: distance along the ray from which the surface hides everything [cm]; None if the ray misses the
                surface.
        """
        if not self._names:
            return None
        along = np.asarray(pick.ray_direction) / np.linalg.norm(pick.ray_direction)
        away = self._points - pick.ray_origin
        forward = away @ along
        beside = np.linalg.norm(away - forward[:, None] * along, axis=1)
        hidden = np.inf if depth is None else depth + 4.0 * SIZE * self._size
        angle = np.where((forward > 0.0) & (forward < hidden), np.arctan2(beside, forward), np.inf)
        best = int(angle.argmin())
        return self._names[best] if angle[best] <= REACH else None
