# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The drawing of the page Edit: the fabric, the selection, the place of a tool, a preview, and a refused edit."""

from __future__ import annotations

from textwrap import fill, shorten

import numpy as np

from stitchmesh.app.pages.edit.loop_marks import loop_lines
from stitchmesh.app.scene.drawing import Colour, Labels, Lines, Surface
from stitchmesh.app.scene.fabric_blocks import FabricBlocks
from stitchmesh.app.scene.face_colours import ColourBy, colours_of_faces
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.face_triangles import face_triangles
from stitchmesh.selection.parts import face_centres

SELECTED: Colour = (222, 124, 20)
REFUSED: Colour = (170, 24, 70)
PLACE: Colour = (20, 96, 170)
"""Colours of selected faces (orange), of a refused edit (dark red), and of the place of a tool (blue), sRGB."""
INK: Colour = (38, 34, 30)
"""Colour of crossed and twisted loops, sRGB."""
LIFT = 0.06
"""Distance of marks from the surface, over the mean side length."""
LINE_WIDTH = 4.0
"""Width of the lines around marked faces [pixels]."""
NUMBERED = 5
"""Number of rows from one row number on the fabric to the next."""
MOST_EDGED = 12_000
"""Largest number of faces whose edges are drawn by default; more edges hide the colours and slow the browser down."""
LONGEST_MESSAGE, LINE_LENGTH = 130, 36
"""Largest number of characters of a message beside a refused edit, and of one of its lines; the notice has the whole
message."""


class FabricView:
    """Draws a fabric and the marks on it."""

    def __init__(self, scene: DrawingScene) -> None:
        """Draw nothing yet."""
        self._scene = scene
        self._blocks = FabricBlocks(scene)
        self._side_length: float | None = None
        self.colour_by: ColourBy = "stitch"
        """What the colours of the faces show."""
        self.edges: bool | None = None
        """Whether edges are drawn; None draws them on fabrics of up to ``MOST_EDGED`` faces."""
        self.row_numbers = False
        """Whether the fabric shows its row numbers."""
        self.takes_strokes = True
        """Whether a drag on the fabric belongs to the tool; otherwise it turns the view."""

    def draws_edges(self, fabric: StitchMesh) -> bool:
        """Whether the edges of a fabric are drawn."""
        return fabric.face_count <= MOST_EDGED if self.edges is None else self.edges

    def show(self, fabric: StitchMesh) -> None:
        """Draw a fabric."""
        colours = colours_of_faces(fabric, self.colour_by)
        self._blocks.show(fabric, colours, edges=self.draws_edges(fabric), takes_strokes=self.takes_strokes)
        height = 2 * self._height(fabric)
        self._scene.show("loops", Lines(loop_lines(fabric, height), INK, 2.5))
        self._scene.show("rows/numbers", _row_labels(fabric, height) if self.row_numbers else None)

    def select(self, fabric: StitchMesh, faces: IntArray) -> None:
        """Mark the selected faces with a colour and a line around them."""
        self._mark("selection", fabric, faces, SELECTED, 0.25)

    def mark_faces(self, fabric: StitchMesh, faces: IntArray) -> None:
        """Mark the faces that a tool is about to change."""
        self._mark("place", fabric, faces, PLACE, 0.35)

    def mark_sides(self, fabric: StitchMesh, sides: IntArray) -> None:
        """Mark sides that a tool is about to change."""
        self._clear("place")
        self._scene.show("place/lines", Lines(_lifted(fabric, sides, self._height(fabric)), PLACE, 2 * LINE_WIDTH))

    def mark_left_out(self, fabric: StitchMesh, faces: IntArray) -> None:
        """Mark the faces that a pattern leaves out."""
        self._mark("left out", fabric, faces, SELECTED, 0.6)

    def refuse(self, fabric: StitchMesh, faces: IntArray, message: str) -> None:
        """Mark the faces of a refused edit, and write the reason beside them."""
        self._mark("refused", fabric, faces, REFUSED, 0.6)
        if len(faces):
            corners = fabric.corner_position[fabric.sides_of(faces)]
            normal = fabric.face_vector_area[faces].sum(axis=0)
            length = float(np.linalg.norm(normal)) or 1.0
            place = corners.mean(axis=0) + 4 * self._height(fabric) * normal / length
            text = fill(shorten(message, LONGEST_MESSAGE, placeholder=" ..."), LINE_LENGTH)
            self._scene.show("refused/reason", Labels(place[None], (text,)))

    def unmark(self) -> None:
        """Remove the marks of a refused edit and of the place of a tool."""
        for name in ("refused", "place", "left out"):
            self._clear(name)

    def forget(self) -> None:
        """Forget the drawing, after the scene was cleared."""
        self._blocks.forget()
        self._side_length = None

    def _height(self, fabric: StitchMesh) -> float:
        """Return the distance of marks from the surface [cm], which the first drawn fabric decides."""
        if self._side_length is None:
            self._side_length = float(fabric.side_length.mean())
        return LIFT * self._side_length

    def _clear(self, name: str) -> None:
        for part in (f"{name}/faces", f"{name}/lines", f"{name}/reason"):
            self._scene.remove(part)

    def _mark(self, name: str, fabric: StitchMesh, faces: IntArray, colour: Colour, opacity: float) -> None:
        self._clear(name)
        if not len(faces):
            return
        height = self._height(fabric)
        self._scene.show(f"{name}/faces", _overlay(fabric, faces, height, colour, opacity))
        self._scene.show(f"{name}/lines", Lines(_lifted(fabric, _outline(fabric, faces), height), colour, LINE_WIDTH))


def _row_labels(fabric: StitchMesh, height: float) -> Labels:
    """Return the number of every ``NUMBERED``-th row in front of its foremost stitch."""
    numbered = np.flatnonzero(fabric.row % NUMBERED == 0)
    centres = face_centres(fabric, numbered)
    order = np.lexsort([-centres[:, 2], fabric.row[numbered]])
    foremost = order[np.unique(fabric.row[numbered][order], return_index=True)[1]]
    faces = numbered[foremost]
    places = centres[foremost] + height * _unit(fabric.face_vector_area[faces])
    return Labels(places, tuple(str(row) for row in fabric.row[faces].tolist()))


def _outline(fabric: StitchMesh, faces: IntArray) -> IntArray:
    """Return the sides between some faces and all other faces."""
    inside = np.zeros(fabric.face_count, dtype=bool)
    inside[faces] = True
    sides = fabric.sides_of(faces)
    across = fabric.twin[sides]
    return sides[(across == BORDER) | ~inside[fabric.side_face[across]]]


def _lifted(fabric: StitchMesh, sides: IntArray, height: float) -> FloatArray:
    """Return the ends of sides, shifted along the normals of their faces, shape (n, 2, 3)."""
    normal = _unit(fabric.face_vector_area[fabric.side_face[sides]])
    ends = fabric.corner_position[np.stack([sides, fabric.side_next[sides]], axis=1)]
    lifted: FloatArray = ends + height * normal[:, None]
    return lifted


def _overlay(fabric: StitchMesh, faces: IntArray, height: float, colour: Colour, opacity: float) -> Surface:
    """Return some faces as a surface a little in front of the fabric."""
    found = face_triangles(fabric)
    chosen = np.isin(found.face, faces)
    shift = height * _unit(fabric.face_vector_area[found.face[chosen]])
    points = fabric.corner_position[found.corners[chosen]] + 0.5 * shift[:, None]
    triangles = np.arange(points.size // 3).reshape(-1, 3)
    return Surface(points.reshape(-1, 3), triangles, colour, flat=True, opacity=opacity)


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    unit: FloatArray = vectors / np.where(length > 0.0, length, 1.0)
    return unit
