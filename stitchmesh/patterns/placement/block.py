# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One section of a pattern as a piece of stitch mesh that replaces a rectangle of plain stitches.

"A pattern is merely a stitch mesh generated on a quad with equal tessellation values on both course edges" (Yuksel
et al. 2012, section 5.3). The border of the block equals the border of the plain stitches: one loop for each column
at the bottom and top, and one wale edge for each row on the left and right.

The positions of loops along the course lines of a tile whose rows have different numbers of loops.

Wales should be nearly upright, and the loops of a line should have nearly equal widths. The positions u of the loop
ends on all inner course lines minimise

    sum over wales (u_above - u_below)^2 + s sum over loops (u_right - u_left - width / loops)^2

while the ends of each line, the first line and the last line are fixed. The weight s is increased until no loop is
narrower than ``NARROWEST`` allows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import spsolve

from stitchmesh.mesh import BOTTOM, LEFT, RIGHT, TOP, FloatArray, IntArray
from stitchmesh.patterns.pattern import Cell, Loop, Pattern

NARROWEST = 0.4
"""Smallest width of a loop, relative to the mean width of the loops of its line."""

Wale = tuple[int, int, int]
"""A wale edge: the course line of its lower end, and the places of its lower and upper ends on their course lines."""
Edge = tuple[str, int, int]
"""A loop or a wale edge: its kind, the number of its course line or row, and its place from the left."""


def course_points(loops: Sequence[int], wales: Sequence[Wale]) -> list[FloatArray]:
    """Return the ends of the loops of each course line, in loops of the first line, each of shape (loops + 1,).

    Args:
        loops: number of loops of each course line from below; the first and the last must be equal.
        wales: the wale edges inside the tile.
    """
    # Initial weight s of equal loop widths, relative to upright wales
    evenness = 0.25
    while True:
        lines = _least_squares(loops, wales, evenness)
        if all(np.diff(line).min() >= NARROWEST * loops[0] / (len(line) - 1) for line in lines):
            return lines
        evenness *= 4.0


def _least_squares(loops: Sequence[int], wales: Sequence[Wale], evenness: float) -> list[FloatArray]:
    start = np.concatenate([[0], np.cumsum(np.array(loops) + 1)])
    width, last = float(loops[0]), len(loops) - 1
    value = np.concatenate([np.linspace(0.0, width, count + 1) for count in loops])
    free = np.ones(len(value), dtype=bool)
    free[: start[1]] = free[start[last] :] = False
    free[start[:-1]] = free[start[1:] - 1] = False
    if free.any():
        lines = np.array(wales, dtype=np.int64).reshape(-1, 3)
        left = np.concatenate([np.arange(low, high - 1) for low, high in pairwise(start)])
        one = np.concatenate([start[lines[:, 0]] + lines[:, 1], left])
        other = np.concatenate([start[lines[:, 0] + 1] + lines[:, 2], left + 1])
        length = np.concatenate([np.zeros(len(lines)), np.repeat(width / np.array(loops), loops)])
        weight = np.concatenate([np.ones(len(lines)), np.full(len(left), evenness)])
        spring = np.arange(len(one))
        signs = np.repeat([-1.0, 1.0], len(one))
        ends = np.concatenate([one, other])
        change = csr_array((signs, (np.tile(spring, 2), ends)), shape=(len(one), len(value)))
        pull = change.T @ diags_array(weight)
        known = pull @ (length - change[:, ~free] @ value[~free])
        value[free] = spsolve((pull @ change).tocsc()[free][:, free], known[free])
    return [value[low:high] for low, high in pairwise(start)]


@dataclass(frozen=True, eq=False)
class Block:
    """Faces of one section, row by row from the lower left."""

    lines: tuple[FloatArray, ...]
    """Ends of the loops of each course line, in columns of the plain stitches, each of shape (loops + 1,). The vertices
    of the block are numbered in this order."""
    row: IntArray
    """Row of each face, shape (n,)."""
    column: IntArray
    """The plain column nearest to each face, shape (n,)."""
    n_bottom: IntArray
    """Number of bottom sides of each face, shape (n,)."""
    n_top: IntArray
    """Number of top sides of each face, shape (n,)."""
    stitch: IntArray
    """Type of each stitch, shape (n,)."""
    yarn: IntArray
    """Yarn of each face, shape (n,)."""
    corners: IntArray
    """Vertices of all faces in the order of their sides, shape (c,)."""
    twin: IntArray
    """Face and place of the opposite side of each side; (-1, -1) at the border, shape (c, 2)."""
    border: dict[int, IntArray]
    """Face and place of the sides of each border, by their role; loops from the left, wale edges from below, shape
    (m, 2)."""
    twist: IntArray
    """Half turn of the loop at each top side, 0 at other sides, shape (c,); at the top border, only the half turn from
    the stitches of the block."""
    cable_shift: IntArray
    """Cable shift of each side, as in ``StitchMesh``, shape (c,)."""
    cable_layer: IntArray
    """Cable layer of each side, as in ``StitchMesh``, shape (c,)."""

    @property
    def width(self) -> int:
        """Number of columns of the block."""
        return len(self.lines[0]) - 1

    @property
    def height(self) -> int:
        """Number of rows of the block."""
        return len(self.lines) - 1

    @property
    def face_size(self) -> IntArray:
        """Number of corners of each face, shape (n,)."""
        size: IntArray = self.n_bottom + self.n_top + 2
        return size


def block_of(pattern: Pattern, section: int) -> Block | None:
    """Return a section of a pattern that closes; None if a row of the section takes no loops."""
    rows = [row.sections[section] for row in pattern.rows]
    loops = [row.bottoms[section] for row in pattern.rows]
    if min(loops) < 1:
        return None
    held = [row.loop_sections[section] for row in pattern.rows]
    return build_block(rows, [*loops, loops[0]], held, pattern)


def build_block(
    rows: list[tuple[Cell, ...]], loops: list[int], held: list[tuple[Loop, ...]], pattern: Pattern
) -> Block:
    """Return a piece of stitch mesh.

    Args:
        rows: stitches of each row, left to right.
        loops: number of loops on each course line, from below the first row to above the last row.
        held: for each row, how it holds the loops of the line below it.
        pattern: the pattern, which gives the type codes of the stitches.
    """
    return _Builder(loops, held, pattern).build(rows)


@dataclass
class _Builder:
    """Builder of a block that adds its faces cell by cell."""

    loops: list[int]
    held: list[tuple[Loop, ...]]
    pattern: Pattern
    corners: list[int] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)
    places: list[tuple[int, int]] = field(default_factory=list)
    marks: list[tuple[int, int, int]] = field(default_factory=list)
    wales: list[Wale] = field(default_factory=list)
    cells: list[tuple[int, int, Cell]] = field(default_factory=list)

    def build(self, rows: list[tuple[Cell, ...]]) -> Block:
        """Build the block from the cells of each row."""
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
            stitch=np.array([self.pattern.type_code(cell.stitch) for _, _, cell in self.cells]),
            yarn=np.array([cell.yarn for _, _, cell in self.cells]),
            corners=np.array(self.corners),
            twin=twin,
            border=border,
            twist=twist,
            cable_shift=shift,
            cable_layer=layer,
        )

    def _add(self, row: int, place: int, count: int, cell: Cell, low: int, high: int, start: list[int]) -> None:
        """Add the corners, edges and marks of one face; ``low`` loops below and ``high`` above lie to its left."""
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
        """Return the twin of each side, and the sides of each border."""
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
