# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A fabric as surfaces and edges in blocks of faces, so that an edit sends only the blocks that it changes.

Faces keep their numbers in most edits, and faces of neighbouring numbers are neighbours in most fabrics. An unchanged
block is drawn with the same array objects, which the scene does not send again. A block has room for more triangles
than it needs, so that the browser can change its positions in place. The spare triangles have no area.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stitchmesh.app.scene.drawing import LARGEST_PALETTE, Colours, Lines, Surface
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.face_triangles import FaceTriangles, face_triangles
from stitchmesh.mesh.palette import colours_of
from stitchmesh.render.palette import ODD_ROW, stitch_colours
from stitchmesh.render.surface import LIFT
from stitchmesh.yarn.colours import row_colours

BLOCK = 2048
"""Number of faces of a block: about 150 kB of triangles."""
SPARE = 256
"""The room of a block for triangles is a multiple of this number."""


@dataclass(frozen=True, eq=False)
class _Block:
    """The drawing of the faces of one block."""

    surface: Surface
    edges: Lines | None


class FabricBlocks:
    """Draws a fabric under names with a common beginning."""

    def __init__(self, scene: DrawingScene, name: str = "fabric") -> None:
        """Draw nothing yet."""
        self._scene, self._name = scene, name
        self._blocks: list[_Block] = []
        self._fabric: StitchMesh | None = None
        self._found: FaceTriangles | None = None
        self._height = 0.0

    def show(self, fabric: StitchMesh, colours: Colours, *, edges: bool, takes_strokes: bool) -> None:
        """Draw a fabric in place of the one before.

        Args:
            fabric: the fabric.
            colours: colour of each face, shape (F,).
            edges: whether to draw the edges too.
            takes_strokes: whether a drag on the fabric is a stroke (``Surface.takes_strokes``).
        """
        old, self._blocks = self._blocks, []
        if self._fabric is None:  # Later fabrics have the same height, so that the lines of unchanged edges stay equal.
            self._height = LIFT * float(fabric.side_length.mean())
        starts = range(0, fabric.face_count, BLOCK)
        shapes = self._shapes(fabric, old, len(starts))
        lines = self._edges(fabric, old, len(starts)) if edges else [None] * len(starts)
        for number, (points, face) in enumerate(shapes):
            before = old[number] if number < len(old) else None
            shown = _same_colours(before, colours.index[face], colours.palette)
            triangles = _separate_triangles(len(face))
            surface = Surface(points, triangles, shown, flat=True, takes_strokes=takes_strokes)
            self._draw(number, _Block(surface, lines[number]), before)
        for number in range(len(starts), len(old)):
            self._remove(number, old[number])
        self._fabric = fabric

    def forget(self) -> None:
        """Forget the blocks after the scene was cleared."""
        self._blocks, self._fabric = [], None

    def _draw(self, number: int, block: _Block, before: _Block | None) -> None:
        self._scene.show(f"{self._name}/{number}", block.surface)
        if block.edges is not None:
            self._scene.show(f"{self._name}/{number}/edges", block.edges)
        elif before is not None and before.edges is not None:
            self._scene.remove(f"{self._name}/{number}/edges")
        self._blocks.append(block)

    def _remove(self, number: int, block: _Block) -> None:
        self._scene.remove(f"{self._name}/{number}")
        if block.edges is not None:
            self._scene.remove(f"{self._name}/{number}/edges")

    def _shapes(self, fabric: StitchMesh, old: list[_Block], count: int) -> list[tuple[FloatArray, IntArray]]:
        """Return the points of the triangles, and the face of each triangle, block by block."""
        same = self._fabric is not None and _same_shape(self._fabric, fabric)
        found = self._found if same and self._found is not None else face_triangles(fabric)
        self._found = found
        limits = np.searchsorted(found.face, BLOCK * np.arange(count + 1))
        shapes = []
        for number in range(count):
            part = slice(limits[number], limits[number + 1])
            before = old[number].surface if number < len(old) else None
            size = _room(part.stop - part.start, 0 if before is None else len(before.triangles))
            if same and before is not None:
                points = before.points
            else:
                points = _filled(fabric.corner_position[found.corners[part]], size).reshape(-1, 3)
                points = points if before is None else _kept(before.points, points)
            shapes.append((points, _filled(found.face[part], size)))
        return shapes

    def _edges(self, fabric: StitchMesh, old: list[_Block], count: int) -> list[Lines | None]:
        """Return the edges of each block; an edge belongs to the block of its first side."""
        same = self._fabric is not None and _same_shape(self._fabric, fabric)
        if same and len(old) == count and all(block.edges is not None for block in old):
            return [block.edges for block in old]
        sides = fabric.edge_side
        segments = lifted_sides(fabric, sides, self._height)
        limits = np.searchsorted(fabric.side_face[sides], BLOCK * np.arange(count + 1))
        lines: list[Lines | None] = []
        for number in range(count):
            part = segments[limits[number] : limits[number + 1]]
            before = old[number].edges if number < len(old) else None
            unchanged = before is not None and np.array_equal(before.segments, part)
            lines.append(before if unchanged else Lines(part, (70, 64, 58), 1.2))
        return lines


def lifted_sides(fabric: StitchMesh, sides: IntArray, height: float) -> FloatArray:
    """Return the ends of some sides, shifted from the surface along the normals of their faces, shape (n, 2, 3).

    Args:
        fabric: the fabric.
        sides: the sides, shape (n,).
        height: the shift [cm].
    """
    faces = fabric.side_face[sides]
    across = np.where(fabric.twin[sides] == BORDER, faces, fabric.side_face[fabric.twin[sides]])
    normal = fabric.face_vector_area[faces] + fabric.face_vector_area[across]
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    shift = height * normal / np.where(length > 0.0, length, 1.0)
    ends = fabric.corner_position[np.stack([sides, fabric.side_next[sides]], axis=1)]
    lifted: FloatArray = ends + shift[:, None]
    return lifted


@cache
def _separate_triangles(count: int) -> IntArray:
    """Return the corners of triangles that share no points; an equal number gives the same object."""
    return np.arange(3 * count).reshape(-1, 3)


def _room(needed: int, before: int) -> int:
    """Return the number of triangles that fit into a block: as before, if it is large enough and not far too large."""
    if needed <= before <= needed + 4 * SPARE:
        return before
    return (needed // SPARE + 2) * SPARE


def _filled(values: NDArray, size: int) -> NDArray:
    """Return values of triangles, filled up to a number with the last value; the added triangles are single points."""
    last = values[-1] if values.ndim == 1 else np.broadcast_to(values[-1, -1], values.shape[1:])
    return np.concatenate([values, np.broadcast_to(last, (size - len(values), *values.shape[1:]))])


def _same_shape(one: StitchMesh, other: StitchMesh) -> bool:
    """Return whether two fabrics share their arrays of positions and corners, as after a change of marks only."""
    return all(getattr(one, name) is getattr(other, name) for name in ("vertices", "face_start", "face_vertex"))


def _kept(before: NDArray, now: NDArray) -> NDArray:
    """Return the earlier array if nothing in it has changed."""
    return before if np.array_equal(before, now) else now


def _same_colours(before: _Block | None, index: NDArray[np.uint8], palette: NDArray[np.uint8]) -> Colours:
    """Return the earlier colours if nothing in them has changed."""
    if before is not None and isinstance(before.surface.colours, Colours):
        same = np.array_equal(before.surface.colours.index, index)
        if same and np.array_equal(before.surface.colours.palette, palette):
            return before.surface.colours
    return Colours(index, palette)


ColourBy = Literal["stitch", "yarn", "row"]
"""The choices of what decides the colour of a face."""
_ALL_STITCHES = np.arange(LARGEST_PALETTE // 2)


def colours_of_faces(fabric: StitchMesh, by: ColourBy) -> Colours:
    """Return the colour of each face of a fabric, shape (F,)."""
    if by == "stitch":
        return Colours(_with_parity(fabric.stitch, fabric), _stitch_palette())
    if by == "yarn":
        return _by_yarn(fabric)
    return Colours.of(row_colours(fabric.row))


def _with_parity(number: IntArray, fabric: StitchMesh) -> NDArray[np.uint8]:
    """Return twice the number of each face, and one more in odd rows."""
    return (2 * number + fabric.row % 2).astype(np.uint8)


def _stitch_palette() -> NDArray[np.uint8]:
    """Return the colours of all stitches, each in even and in odd rows."""
    even, odd = (stitch_colours(_ALL_STITCHES, np.full(len(_ALL_STITCHES), row)) for row in (0, 1))
    return np.stack([even, odd], axis=1).reshape(-1, 3)


def _by_yarn(fabric: StitchMesh) -> Colours:
    """Return the colours of the yarns; yarns beyond the size of a palette repeat its colours."""
    numbers, rank = np.unique(fabric.yarn, return_inverse=True)
    even = colours_of(numbers[: LARGEST_PALETTE // 2], fabric.palette)
    odd = np.round(ODD_ROW * even).astype(np.uint8)
    return Colours(_with_parity(rank % len(even), fabric), np.stack([even, odd], axis=1).reshape(-1, 3))
