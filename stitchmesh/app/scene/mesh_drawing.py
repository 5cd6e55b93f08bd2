# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawings of a polygon mesh: its faces in colours, lines along its sides, and flat arrowheads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.app.scene.drawing import Colour, Colours, Lines, Surface
from stitchmesh.app.scene.scene import Scene
from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.mesh.face_triangles import face_triangles
from stitchmesh.render.surface import lifted_corners


class MeshDrawing:
    """Draws one mesh; positions are computed once, so that a change of colours sends only the colours."""

    def __init__(self, scene: Scene, mesh: Mesh) -> None:
        """Draw nothing yet."""
        self._scene, self.mesh = scene, mesh
        self._triangles = face_triangles(mesh)
        self._lifted = lifted_corners(mesh)

    def show_faces(self, name: str, colours: NDArray[np.uint8]) -> None:
        """Draw the faces with one sRGB colour each, shape (F, 3)."""
        of_faces = Colours.of(colours)
        of_triangles = Colours(of_faces.index[self._triangles.face], of_faces.palette)
        self._scene.show(name, Surface(self.mesh.corner_position, self._triangles.corners, of_triangles))

    def show_sides(self, name: str, sides: IntArray, colour: Colour, width: float) -> None:
        """Draw lines along some sides, a little in front of the surface; without sides, nothing.

        Args:
            name: name of the drawing.
            sides: the sides, shape (n,).
            colour: colour of the lines, sRGB.
            width: width of the lines [pixels].
        """
        ends = np.stack([sides, self.mesh.side_next[sides]], axis=1)
        self._show_lines(name, self._lifted[ends], colour, width)

    def show_crosses(self, name: str, faces: IntArray, colour: Colour, width: float) -> None:
        """Draw lines from the middle of some faces to their corners; without faces, nothing.

        Args:
            name: name of the drawing.
            faces: the faces, shape (n,).
            colour: colour of the lines, sRGB.
            width: width of the lines [pixels].
        """
        sides, size = self.mesh.sides_of(faces), np.diff(self.mesh.face_start)[faces]
        corners = self._lifted[sides]
        middles = np.add.reduceat(corners, np.cumsum(size) - size, axis=0) / size[:, None]
        self._show_lines(name, np.stack([np.repeat(middles, size, axis=0), corners], axis=1), colour, width)

    def show_arrowheads(self, name: str, arrowheads: FloatArray, colour: Colour) -> None:
        """Draw triangles of one colour, shape (n, 3, 3); without triangles, nothing."""
        if not len(arrowheads):
            self._scene.remove(name)
            return
        corners = np.arange(3 * len(arrowheads)).reshape(-1, 3)
        self._scene.show(name, Surface(arrowheads.reshape(-1, 3), corners, colour))

    def look(self) -> None:
        """Show the whole mesh."""
        position = self.mesh.corner_position
        self._scene.look_at(position.min(axis=0), position.max(axis=0))

    def _show_lines(self, name: str, segments: FloatArray, colour: Colour, width: float) -> None:
        """Draw lines, shape (n, 2, 3); without lines, nothing."""
        if len(segments):
            self._scene.show(name, Lines(segments, colour, width))
        else:
            self._scene.remove(name)
