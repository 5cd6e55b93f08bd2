# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One section of a pattern as a piece of stitch mesh, to be put in the place of as many plain stitches.

"A pattern is merely a stitch mesh generated on a quad with equal tessellation values on both course edges" (Yuksel
et al. 2012, section 5.3). Its border is that of the plain stitches it replaces: a loop for each column below and
above, a wale edge for each row on the left and right.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from stitchmesh.mesh import BOTTOM, LEFT, RIGHT, TOP, FloatArray, IntArray
from stitchmesh.patterns.pattern import Cell, Loop, Pattern
from stitchmesh.patterns.placement.course_points import Wale, course_points

Edge = tuple[str, int, int]
"""A loop or a wale: its line or row, and its place from the left."""


@dataclass(frozen=True, eq=False)
class Block:
    """Faces of one section, row by row from the lower left."""

    lines: tuple[FloatArray, ...]
    """Ends of the loops of each course line, in columns of the plain stitches; vertices are numbered in this order."""
    row: IntArray
    """Row of each face, shape (n,)."""
    column: IntArray
    """The plain column that lies nearest under each face, shape (n,)."""
    n_bottom: IntArray
    n_top: IntArray
    stitch: IntArray
    yarn: IntArray
    corners: IntArray
    """Vertices of all faces, shape (c,)."""
    twin: IntArray
    """(face, place) across each side; at the border (-1, -1), shape (c, 2)."""
    border: dict[int, IntArray]
    """(face, place) of the sides of each border, by their role: loops from the left, wales from below, shape (m, 2)."""
    twist: IntArray
    """Marks of the sides between the rows, shape (c,); those of the top border are what its stitches make."""
    cable_shift: IntArray
    cable_layer: IntArray

    @property
    def width(self) -> int:
        """Columns it takes."""
        return len(self.lines[0]) - 1

    @property
    def height(self) -> int:
        """Rows it takes."""
        return len(self.lines) - 1

    @property
    def face_size(self) -> IntArray:
        """Corners of each face, shape (n,)."""
        size: IntArray = self.n_bottom + self.n_top + 2
        return size


def block_of(pattern: Pattern, section: int) -> Block | None:
    """A section of a pattern that closes; None where some row of it has no loops to stand on."""
    rows = [row.sections[section] for row in pattern.rows]
    loops = [row.bottoms[section] for row in pattern.rows]
    if min(loops) < 1:
        return None
    held = [row.loop_sections[section] for row in pattern.rows]
    return _Builder([*loops, loops[0]], held).build(rows)


@dataclass
class _Builder:
    """Lists faces cell by cell."""

    loops: list[int]
    held: list[tuple[Loop, ...]]
    corners: list[int] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)
    places: list[tuple[int, int]] = field(default_factory=list)
    marks: list[tuple[int, int, int]] = field(default_factory=list)
    wales: list[Wale] = field(default_factory=list)
    cells: list[tuple[int, int, Cell]] = field(default_factory=list)

    def build(self, rows: list[tuple[Cell, ...]]) -> Block:
        """The block of some rows of cells."""
        start = np.concatenate([[0], np.cumsum(np.array(self.loops) + 1)]).tolist()
        for row, cells in enumerate(rows):
            low = high = 0
            for place, cell in enumerate(cells):
                self._add(row, place, len(cells), cell, low, high, start)
                low, high = low + cell.n_bottom, high + cell.n_top
        lines = tuple(course_points(self.loops, self.wales))
        twin, border = self._connect(len(rows))
        twist, shift, layer = np.array(self.marks).T
        at = np.array([lines[row][low] for row, low, _ in self.cells])
        return Block(
            lines=lines,
            row=np.array([row for row, _, _ in self.cells]),
            column=np.minimum(np.floor(at + 0.5).astype(np.int64), self.loops[0] - 1),
            n_bottom=np.array([cell.n_bottom for _, _, cell in self.cells]),
            n_top=np.array([cell.n_top for _, _, cell in self.cells]),
            stitch=np.array([int(cell.stitch) for _, _, cell in self.cells]),
            yarn=np.array([cell.yarn for _, _, cell in self.cells]),
            corners=np.array(self.corners),
            twin=twin,
            border=border,
            twist=twist,
            cable_shift=shift,
            cable_layer=layer,
        )

    def _add(self, row: int, place: int, count: int, cell: Cell, low: int, high: int, start: list[int]) -> None:
        """List the corners, edges and marks of one face; ``low`` and ``high`` loops lie left of it."""
        number, nb, nt = len(self.cells), cell.n_bottom, cell.n_top
        bottoms, tops = range(low, low + nb), range(high + nt - 1, high - 1, -1)
        self.corners += [start[row] + loop for loop in range(low, low + nb + 1)]
        self.corners += [start[row + 1] + loop for loop in range(high + nt, high - 1, -1)]
        self.edges += [("loop", row, loop) for loop in bottoms]
        self.edges += [("wale", row, place + 1), *(("loop", row + 1, loop) for loop in tops), ("wale", row, place)]
        self.places += [(number, side) for side in range(nb + nt + 2)]
        held = self.held[row + 1] if row + 1 < len(self.held) else (Loop(),) * self.loops[-1]
        made = [(cell.twist[loop - high] + held[loop].twist, held[loop].shift, held[loop].layer) for loop in tops]
        self.marks += [(0, 0, 0)] * (nb + 1) + made + [(0, 0, 0)]
        if place + 1 < count:
            self.wales.append((row, low + nb, high + nt))
        self.cells.append((row, low, cell))

    def _connect(self, rows: int) -> tuple[IntArray, dict[int, IntArray]]:
        """Twins, and the sides without one by border."""
        by_edge: dict[Edge, list[int]] = {}
        for side, edge in enumerate(self.edges):
            by_edge.setdefault(edge, []).append(side)
        twin = [(-1, -1)] * len(self.edges)
        outer: dict[int, list[tuple[tuple[int, int], tuple[int, int]]]] = {border: [] for border in range(4)}
        for edge, sides in by_edge.items():
            if len(sides) == 2:
                twin[sides[0]], twin[sides[1]] = self.places[sides[1]], self.places[sides[0]]
            else:
                kind, row, place = edge
                border = (BOTTOM if row == 0 else TOP) if kind == "loop" else (LEFT if place == 0 else RIGHT)
                outer[border].append(((row, place), self.places[sides[0]]))
        border_sides = {border: np.array([side for _, side in sorted(sides)]) for border, sides in outer.items()}
        return np.array(twin), border_sides
