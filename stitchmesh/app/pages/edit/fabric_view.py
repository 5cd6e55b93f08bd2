# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The drawing of the page Edit: the fabric, crossed and twisted loops, the selection, previews and a refused edit."""

from __future__ import annotations

from dataclasses import dataclass
from textwrap import fill, shorten

import numpy as np

from stitchmesh.app.scene.drawing import Colour, Labels, Lines, Surface
from stitchmesh.app.scene.fabric_blocks import ColourBy, FabricBlocks, colours_of_faces
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import CableGroup, cable_groups
from stitchmesh.mesh.face_triangles import face_triangles
from stitchmesh.selection.parts import face_centres

REACH = 0.42
"""Share of the face above and below a course line that the lines of its loops cover."""
GAP = 0.36
"""Share of the line of a rear loop that is left out in its middle."""
STEPS = 4
"""Number of pieces of the line from one loop to its neighbour."""
TWIST_WIDTH = 0.28
"""Half the width of the mark of a twisted loop, over the length of its side."""


def loop_lines(fabric: StitchMesh, height: float) -> FloatArray:
    """Return the ends of the lines of crossed and twisted loops, ``height`` cm above the fabric, shape (n, 2, 3)."""
    paths = [path for group in cable_groups(fabric) for path in _cable(fabric, group)]
    paths += [path for side in np.flatnonzero(fabric.twist).tolist() for path in _twist(fabric, side)]
    if not paths:
        return np.zeros((0, 2, 3))
    segments = np.concatenate([np.stack([path.points[:-1], path.points[1:]], axis=1) for path in paths])
    sides = np.repeat([path.side for path in paths], [len(path.points) - 1 for path in paths])
    normal = fabric.face_vector_area[fabric.side_face[sides]]
    lift = height * normal / np.linalg.norm(normal, axis=1, keepdims=True)
    lifted: FloatArray = segments + lift[:, None]
    return lifted


@dataclass(frozen=True, eq=False)
class _Path:
    """A line of a loop, or a piece of it."""

    points: FloatArray
    """Points [cm], shape (n, 3)."""
    side: int
    """Top side of the loop."""


def _cable(fabric: StitchMesh, group: CableGroup) -> list[_Path]:
    """Return the lines of a cable: each runs from below the place of a loop to above its new place.

    A line passes through the places between, so that it follows the surface.
    """
    position = fabric.corner_position
    middle, up = 0.5 * (position[group.sides] + position[fabric.side_next[group.sides]]), _upwards(fabric, group.sides)
    places = np.arange(len(group.sides))
    crosses = (places[:, None] < places) != (group.destination[:, None] < group.destination)
    behind = (crosses & (group.layer[:, None] < group.layer)).any(axis=1)
    paths: list[_Path] = []
    for first, last in enumerate(group.destination.tolist()):
        share = np.linspace(0.0, 1.0, STEPS * abs(last - first) + 1)
        place = first + (last - first) * share
        line = np.stack([np.interp(place, places, middle[:, axis]) for axis in range(3)], axis=1)
        rise = np.stack([np.interp(place, places, up[:, axis]) for axis in range(3)], axis=1)
        points = line + (2.0 * share - 1.0)[:, None] * rise
        if last == first:
            points = np.stack([middle[first] - up[first], middle[first] + up[first]])
        paths += _pieces(points, int(group.sides[first]), behind=bool(behind[first]))
    return paths


def _twist(fabric: StitchMesh, side: int) -> list[_Path]:
    """Return the two legs of a twisted loop; at twist 1 the leg that comes from the left is in front."""
    position, up = fabric.corner_position, 0.7 * _upwards(fabric, np.array([side]))[0]
    right, left = position[side], position[fabric.side_next[side]]  # A top side runs from right to left.
    middle, across = 0.5 * (left + right), TWIST_WIDTH * (right - left)
    share = np.linspace(-1.0, 1.0, 2 * STEPS + 1)[:, None]
    legs = [middle + share * (up + across), middle + share * (up - across)]
    from_left_behind = bool(fabric.twist[side] < 0)
    first = _pieces(legs[0], side, behind=from_left_behind)
    return first + _pieces(legs[1], side, behind=not from_left_behind)


def _pieces(points: FloatArray, side: int, *, behind: bool) -> list[_Path]:
    """Return a line; a line behind has two pieces."""
    if not behind:
        return [_Path(points, side)]
    first = max(round((0.5 - GAP / 2) * (len(points) - 1)), 1)
    return [_Path(points[: first + 1], side), _Path(points[len(points) - 1 - first :], side)]


def _upwards(fabric: StitchMesh, sides: IntArray) -> FloatArray:
    """Return the vectors from the course line of top sides to the upper ends of the lines, shape (n, 3)."""
    face, position = fabric.side_face[sides], fabric.corner_position
    right, left = fabric.right_wale[face], fabric.left_wale[face]
    low = 0.5 * (position[fabric.face_start[face]] + position[right])
    high = 0.5 * (position[fabric.side_next[right]] + position[left])
    upwards: FloatArray = REACH * (high - low)
    return upwards


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
