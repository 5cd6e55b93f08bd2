# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The numbers of the vertices on the side of a mesh that faces the camera."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.scene.drawing import Labels
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.mesh import FloatArray, IntArray, Mesh

NAME = "vertex numbers"
"""Name of the drawing."""
MOST = 400
"""Largest number of vertices whose numbers are shown."""
FACING = 0.15
"""Smallest cosine of the angle between the normal of a vertex and the camera; it leaves out the rim of the mesh."""


class VertexNumbers:
    """Shows the numbers of the vertices of one mesh while the user wants them."""

    def __init__(self, scene: DrawingScene, mesh: Mesh) -> None:
        """Show nothing yet."""
        self._scene, self._mesh = scene, mesh
        normals = mesh.vertex_normal
        self._is_flat = bool((normals @ normals[0] > 0.0).all())
        self._middle: FloatArray = mesh.vertices.mean(axis=0)
        self._direction: FloatArray | None = None
        self._shown = False

    def show(self, shown: bool) -> None:
        """Show the numbers, or remove them."""
        if shown and not self._shown:
            self._draw(self._camera_direction())
        elif not shown:
            self._scene.remove(NAME)
        self._shown = shown

    def camera_moved(self) -> None:
        """Choose the vertices again if the camera has turned."""
        direction = self._camera_direction()
        if self._shown and direction is not None:
            before = self._direction
            if before is None or float(direction @ before) < np.cos(np.radians(15.0)):  # Each choice is sent anew.
                self._draw(direction)

    def _camera_direction(self) -> FloatArray | None:
        """Return the unit direction from the middle of the mesh to the first camera; None without a camera."""
        cameras = self._scene.cameras()
        if not cameras:
            return None
        away = np.asarray(cameras[0].position) - self._middle
        length = float(np.linalg.norm(away))
        return away / length if length > 0.0 else None

    def _draw(self, direction: FloatArray | None) -> None:
        self._direction = direction
        chosen = self._facing(direction)[:MOST]
        self._scene.show(NAME, Labels(self._mesh.vertices[chosen], tuple(map(str, chosen.tolist()))))

    def _facing(self, direction: FloatArray | None) -> IntArray:
        """Return the vertices whose outside faces a direction; without a direction all vertices, shape (n,)."""
        if direction is None:
            return np.arange(len(self._mesh.vertices))
        cosine = self._mesh.vertex_normal @ direction
        return np.flatnonzero((np.abs(cosine) if self._is_flat else cosine) > FACING)
