# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The drawing of the page Rows: the time and the rows on the surface, begins and ends, and marks; or the stitches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from stitchmesh.app.pages.rows.rows_finder import EndPlace, FoundRows
from stitchmesh.app.pages.rows.rows_state import Marks, MeshBorders
from stitchmesh.app.project.shaping import Point
from stitchmesh.app.scene.drawing import OCTAHEDRON_FACES, Colour, Colours, Labels, Lines, Surface, point_marks
from stitchmesh.app.scene.mesh_drawing import INK, STITCH_DRAWINGS, MeshDrawing, show_stitches
from stitchmesh.app.scene.scene import DrawingScene, Pick
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.picking import PickingTable, pick
from stitchmesh.render.colour_scale import ColourScale


def contour_segments(points: FloatArray, triangles: IntArray, values: FloatArray, interval: float) -> FloatArray:
    """Return the pieces of the lines in single triangles, shape (n, 2, 3).

    Args:
        points: corners of the triangles [cm], shape (V, 3).
        triangles: corners of each triangle, shape (T, 3).
        values: value of the function at each corner, linear on each triangle, shape (V,).
        interval: difference of the values of neighbouring lines; each line has a multiple of it.
    """
    level = values[triangles] / interval + 1e-7  # With this shift hardly any vertex lies on a line.
    first = np.ceil(level.min(axis=1)).astype(np.int64)
    count = np.maximum(np.floor(level.max(axis=1)).astype(np.int64) - first + 1, 0)
    triangle = np.repeat(np.arange(len(triangles)), count)
    line = first[triangle] + np.arange(len(triangle)) - np.repeat(np.cumsum(count) - count, count)
    ends = [_crossings(points[triangles[triangle]], level[triangle], line, side) for side in range(3)]
    place = np.stack([point for point, _ in ends], axis=1)
    crossed = np.stack([cut for _, cut in ends], axis=1)
    whole = crossed.sum(axis=1) == 2
    return place[whole][crossed[whole]].reshape(-1, 2, 3)


def _crossings(corner: FloatArray, level: FloatArray, line: IntArray, side: int) -> tuple[FloatArray, IntArray]:
    """Return the point at which each line crosses a side of its triangle, shape (n, 3), and whether it does, (n,)."""
    start, end = level[:, side], level[:, (side + 1) % 3]
    cut = (start < line) != (end < line)
    share = np.where(cut, (line - start) / np.where(cut, end - start, 1.0), 0.0)[:, None]
    return corner[:, side] * (1.0 - share) + corner[:, (side + 1) % 3] * share, cut


SIZE = 0.014
"""Size of a handle, over the size of the mesh."""
REACH = 0.01
"""Largest angle between a click and the handle that it selects [rad], about eleven pixels."""


class MarkHandles:
    """Draws the points of marks, and finds them under the pointer."""

    def __init__(self, scene: DrawingScene, size: float) -> None:
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


PIECES = 12
"""Number of pieces of the line between two points."""


def line_on_surface(table: PickingTable, points: Sequence[Point]) -> FloatArray:
    """Return the pieces of the line through some points, shape (n, 2, 3).

    Each piece of a straight line is moved along the mean normal of the surface at both ends until it meets the surface.

    Args:
        table: the surface, prepared for picking.
        points: the points, on the surface [cm].
    """
    pieces = [_between(table, np.array(start), np.array(end)) for start, end in pairwise(points)]
    return np.concatenate([np.zeros((0, 2, 3)), *pieces])


def _between(table: PickingTable, start: FloatArray, end: FloatArray) -> FloatArray:
    size = float(np.linalg.norm(np.ptp(table.mesh.vertices, axis=0)))
    normals = np.stack([_normal(table, start), _normal(table, end)])
    outward = normals.mean(axis=0)
    outward = outward / max(float(np.linalg.norm(outward)), 1e-9)
    path = []
    for share in np.linspace(0.0, 1.0, PIECES + 1):
        place = (1.0 - share) * start + share * end
        met = pick(table, place + size * outward, -outward) if outward.any() else None
        path.append((place if met is None else met.point) + 0.004 * size * outward)
    return np.stack([path[:-1], path[1:]], axis=1)


def _normal(table: PickingTable, point: FloatArray) -> FloatArray:
    """Return the normal of the mesh at the vertex nearest to a point, shape (3,)."""
    nearest = int(np.linalg.norm(table.mesh.vertices - point, axis=1).argmin())
    normal: FloatArray = table.mesh.vertex_normal[nearest]
    return normal


TIME_COLOURS = np.array([[250, 244, 226], [214, 226, 220], [160, 195, 210], [104, 150, 190]])
"""Colours from the first row to the last one, sRGB; dark lines are visible on all of them."""
ROLE_COLOURS: dict[str, Colour] = {
    "begin": (22, 130, 60), "end": (196, 40, 40), "row": (30, 70, 170), "side": (130, 110, 150),
    "plain": (110, 90, 60),
}  # fmt: skip
"""Colour of each role."""
LINE_COLOUR: Colour = (232, 140, 20)
"""Colour of an unfinished line, and of the chosen point."""
STEPS = (1, 2, 5, 10, 20, 50, 100, 200)
"""Possible numbers of rows between two lines."""
TIP_SIZE = 0.008
"""Size of the mark of a tip, over the size of the mesh."""
OF_ROWS = ("surface", "row lines", "tips of begin", "tips of end", "tips of row", "times", "borders",
           "begin", "end", "row")  # fmt: skip
"""Drawings that show rows."""


class RowsView:
    """Draws one mesh."""

    def __init__(self, scene: DrawingScene, borders: MeshBorders, table: PickingTable) -> None:
        """Draw nothing yet; ``table`` holds the mesh of the borders, prepared for picking."""
        self._scene, self._borders, self._table = scene, borders, table
        self._drawing = MeshDrawing(scene, borders.mesh)
        self._size = float(np.linalg.norm(np.ptp(borders.mesh.vertices, axis=0)))
        self._shown: object = self
        self.handles = MarkHandles(scene, self._size)
        """The points of the marks, which the user can drag."""

    def look(self) -> None:
        """Show the whole mesh."""
        self._drawing.look()

    def show_bare(self) -> None:
        """Draw the mesh without rows."""
        if self._shown is None:
            return
        self._forget(None, OF_ROWS + STITCH_DRAWINGS)
        mesh = self._borders.mesh
        self._drawing.show_faces("surface", np.tile(np.array((226, 222, 212), dtype=np.uint8), (mesh.face_count, 1)))
        self._drawing.show_sides("borders", self._borders.sides, ROLE_COLOURS["side"], 4.0)

    def show_found(self, found: FoundRows) -> None:
        """Draw rows, and where knitting begins and ends."""
        if self._shown is found:
            return
        self._forget(found, STITCH_DRAWINGS)
        surface, low = found.surface, float(found.time.min())
        share = (found.time - low) / max(float(np.ptp(found.time)), 1e-9)
        colours = Colours(np.rint(255 * share).astype(np.uint8), ColourScale(TIME_COLOURS, 0.0, 1.0).table(256))
        self._scene.show("surface", Surface(surface.vertices, surface.triangles, colours, flat=False))
        interval = lines_every(found) * found.course_height
        lines = contour_segments(found.in_front, surface.triangles, found.time, interval)
        self._scene.show("row lines", Lines(lines, INK, 1.5))
        self._scene.show("borders", Lines(found.in_front[found.side_edges], ROLE_COLOURS["side"], 5.0))
        for role in ("begin", "end", "row"):
            self._show_places(found, role)
        self._name_places(found)

    def show_stitches(self, fabric: StitchMesh) -> None:
        """Draw stitches in their colours."""
        if self._shown is fabric:
            return
        self._forget(fabric, OF_ROWS)
        show_stitches(self._scene, fabric)

    def show_marks(self, marks: Marks, chosen: tuple[int, int] | None, line: Sequence[Point]) -> None:
        """Draw the points of tips and lines, with the chosen mark and its chosen point, and an unfinished line."""
        self.handles.show(marks, chosen, ROLE_COLOURS, LINE_COLOUR)
        points = np.array(line, dtype=np.float64).reshape(-1, 3)
        self._scene.show("begun line", Lines(line_on_surface(self._table, line), LINE_COLOUR, 5.0))
        self._scene.show("begun points", point_marks(points, TIP_SIZE * self._size, LINE_COLOUR))

    def _forget(self, shown: object, names: Sequence[str]) -> None:
        self._shown = shown
        for name in names:
            self._scene.remove(name)

    def _show_places(self, found: FoundRows, role: str) -> None:
        paths = [found.in_front[place.vertices] for place in found.places if place.role == role]
        segments = [np.stack([path[:-1], path[1:]], axis=1) for path in paths]
        self._scene.show(role, Lines(np.concatenate([np.zeros((0, 2, 3)), *segments]), ROLE_COLOURS[role], 7.0))
        tips = np.concatenate([np.zeros((0, 3)), *[path for path in paths if len(path) == 1]])
        self._scene.show(f"tips of {role}", point_marks(tips, TIP_SIZE * self._size, ROLE_COLOURS[role]))

    def _name_places(self, found: FoundRows) -> None:
        """Write the role and the time of each begin and end at its front."""
        named = [place for place in found.places if place.role != "row"][:24]
        points = np.array([_front(found, place) for place in named]).reshape(-1, 3)
        self._scene.show("times", Labels(points, tuple(f"{place.role} {place.time:.0f} cm" for place in named)))


def lines_every(found: FoundRows) -> int:
    """Return a number of rows between two lines at which the lines remain distinct."""
    return next((step for step in STEPS if found.rows <= 50 * step), STEPS[-1])


def _front(found: FoundRows, place: EndPlace) -> FloatArray:
    """Return the point of a place that is nearest to a viewer in front of the garment [cm], shape (3,)."""
    points = found.in_front[place.vertices]
    front: FloatArray = points[points[:, 2].argmax()]
    return front
