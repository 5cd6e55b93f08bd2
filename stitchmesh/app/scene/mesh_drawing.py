# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawings of a polygon mesh: faces in colours, lines along sides, flat arrowheads, and the numbers of vertices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.scene.drawing import Colour, Colours, Labels, Lines, Surface
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.mesh import FloatArray, IntArray, Mesh, StitchMesh
from stitchmesh.mesh.face_triangles import face_triangles
from stitchmesh.render.palette import stitch_colours
from stitchmesh.render.surface import MOST_LINES, lifted_corners

INK: Colour = (58, 54, 50)
"""Colour of edges and arrows."""
BODY_COLOUR: Colour = (176, 168, 158)
"""Colour of bodies that the yarns or the cloth touch."""


def plain_surface(mesh: Mesh, colour: Colour, *, flat: bool = True, opacity: float = 1.0) -> Surface:
    """Return a mesh in one colour; other arguments as for ``Surface``."""
    triangles = mesh.face_vertex[face_triangles(mesh).corners]
    return Surface(mesh.vertices, triangles, colour, flat=flat, opacity=opacity)


GARMENT, EDGES = "garment", "edges"
"""Names of the drawings of ``draw_plainly``."""


def draw_plainly(scene: DrawingScene, mesh: Mesh, opacity: float = 1.0) -> None:
    """Draw a mesh in one colour with its edges."""
    scene.show(GARMENT, plain_surface(mesh, (206, 200, 186), opacity=opacity))
    ends = np.stack([mesh.edge_side, mesh.side_next[mesh.edge_side]], axis=1)
    scene.show(EDGES, Lines(mesh.vertices[mesh.face_vertex[ends]], (96, 96, 104), 1.0))
    scene.look_at(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0))


def remove_plain(scene: DrawingScene) -> None:
    """Remove the drawing of ``draw_plainly``."""
    scene.remove(GARMENT)
    scene.remove(EDGES)


STITCH_DRAWINGS = ("stitches", "stitch edges")
"""Names of the drawings of stitches."""


def show_stitches(scene: DrawingScene, fabric: StitchMesh) -> None:
    """Draw stitches in their colours."""
    drawing = MeshDrawing(scene, fabric)
    drawing.show_faces("stitches", stitch_colours(fabric.stitch, fabric.row))
    shown = fabric.edge_side if fabric.face_count <= MOST_LINES else fabric.edge_side[:0]
    drawing.show_sides("stitch edges", shown, (128, 120, 110), 1.0)


class MeshDrawing:
    """Draws one mesh; it computes positions once, so that a change of colours sends only the colours."""

    def __init__(self, scene: DrawingScene, mesh: Mesh) -> None:
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
        self._scene.show(name, Lines(self._lifted[ends], colour, width))

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
        self._scene.show(name, Lines(np.stack([np.repeat(middles, size, axis=0), corners], axis=1), colour, width))

    def show_arrowheads(self, name: str, arrowheads: FloatArray, colour: Colour) -> None:
        """Draw triangles of one colour, shape (n, 3, 3); without triangles, nothing."""
        corners = np.arange(3 * len(arrowheads)).reshape(-1, 3)
        self._scene.show(name, Surface(arrowheads.reshape(-1, 3), corners, colour))

    def look(self) -> None:
        """Show the whole mesh."""
        position = self.mesh.corner_position
        self._scene.look_at(position.min(axis=0), position.max(axis=0))


VERTEX_NUMBERS = "vertex numbers"
"""Name of the drawing of the numbers of vertices."""


class VertexNumbers:
    """Shows the numbers of the vertices of a mesh while the user wants them."""

    def __init__(self, scene: DrawingScene, controls: Controls) -> None:
        """Make the box to tick."""
        self._scene = scene
        self._mesh: Mesh | None = None
        self._direction: FloatArray | None = None
        hint = "Show the numbers of the vertices, by which edges are named."
        self._box = controls.toggle("Vertex numbers", hint, False, lambda _: self._draw())

    def show(self, mesh: Mesh) -> None:
        """Take a mesh."""
        self._mesh = mesh
        self._draw()

    def camera_moved(self) -> None:
        """Choose the vertices again if the camera has turned."""
        if not self._box.value:
            return
        direction, before = self._camera_direction(), self._direction
        if direction is not None and (before is None or float(direction @ before) < np.cos(np.radians(15.0))):
            self._draw()  # Each choice is sent anew.

    def _camera_direction(self) -> FloatArray | None:
        """Return the unit direction from the middle of the mesh to the first camera; None without a camera."""
        cameras = self._scene.cameras()
        if not cameras or self._mesh is None:
            return None
        away = np.asarray(cameras[0].position) - self._mesh.vertices.mean(axis=0)
        length = float(np.linalg.norm(away))
        return away / length if length > 0.0 else None

    def _draw(self) -> None:
        """Draw the numbers, or remove them if they are not wanted."""
        if not self._box.value or self._mesh is None:
            self._scene.remove(VERTEX_NUMBERS)
            return
        self._direction = self._camera_direction()
        chosen = _facing(self._mesh, self._direction)[:400]  # More numbers would hide the mesh.
        self._scene.show(VERTEX_NUMBERS, Labels(self._mesh.vertices[chosen], tuple(map(str, chosen.tolist()))))


def _facing(mesh: Mesh, direction: FloatArray | None) -> IntArray:
    """Return the vertices whose outside faces a direction; without a direction all vertices, shape (n,)."""
    if direction is None:
        return np.arange(len(mesh.vertices))
    normals = mesh.vertex_normal
    cosine = normals @ direction
    is_flat = bool((normals @ normals[0] > 0.0).all())
    return np.flatnonzero((np.abs(cosine) if is_flat else cosine) > 0.15)  # This leaves out the rim of the mesh.
