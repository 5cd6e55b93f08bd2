# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One repeat of a knitting pattern as a stitch mesh without borders.

The tile of a pattern lies on a lattice: its upper border is the lower border shifted by one period upwards, and its
right border is the left border shifted by one period to the right. The mesh is therefore a torus; in the smallest case
it is one stitch whose four corners are one vertex. An image of each corner gives the period in which the corner lies
(Leaf et al. 2018, section 3).
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from stitchmesh.errors import check_kind
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import BOTTOM, LEFT, RIGHT, TOP, FloatArray, IntArray, StitchMesh
from stitchmesh.patterns import Pattern, check_closes
from stitchmesh.patterns.placement.block import Block, block_of
from stitchmesh.patterns.swatch_mesh import check_swatch_size


def torus_mesh(
    pattern: Pattern, columns: int = 1, rows: int = 1, *, stitch_width: float, stitch_height: float
) -> StitchMesh:
    """Make a stitch mesh of the tile of a pattern on a lattice; the borders of the pattern are left out.

    The mesh lies in the plane z = 0 with its right side up.

    Args:
        pattern: the pattern, for example from ``read_pattern``.
        columns: number of tiles side by side in the cell.
        rows: number of repeats one above another in the cell.
        stitch_width: wale spacing of the first row [cm]; rows with more or fewer loops keep the same total width.
        stitch_height: course spacing [cm].

    Raises:
        PatternError: the last row does not make the loops on which the first row is worked, or their twists do not fit.
        ParameterError: a number or a size is not positive.
    """
    check_kind("torus_mesh", pattern, Pattern)
    check_swatch_size(columns, rows, stitch_width, stitch_height)
    unit, size = _unit_torus(pattern, columns, rows), np.array([stitch_width, stitch_height, 1.0])
    assert unit.lattice is not None
    return replace(unit, vertices=unit.vertices * size, lattice=Lattice(unit.lattice.periods * size))


@lru_cache(maxsize=16)
def _unit_torus(pattern: Pattern, columns: int, rows: int) -> StitchMesh:
    """The mesh with stitches of 1 cm, which is kept because variants of a pattern often differ in size alone.

    Raises:
        PatternError: as for ``torus_mesh``.
    """
    tile = pattern.without_borders()
    check_closes(tile)
    # Index of the tile among the sections of a row
    block = block_of(tile, 1)
    assert block is not None  # no row of a pattern has a tile without loops
    return _Tiling(block, tile, columns, rows).mesh()


class _Tiling:
    """Copies of a block side by side and one above another, numbered row by row from the lower left.

    The last copy of a row or column is adjacent to the first copy.
    """

    def __init__(self, block: Block, tile: Pattern, columns: int, rows: int) -> None:
        self.block, self.tile = block, tile
        self.count = np.array([columns, rows])
        self.copy = np.stack([index.ravel() for index in np.indices((rows, columns))[::-1]], axis=1)  # shape (n, 2)
        self.size = np.array([len(line) - 1 for line in block.lines])
        """Number of loops of each course line."""
        self.first_corner = np.concatenate([[0], np.cumsum(block.face_size)])

    def mesh(self) -> StitchMesh:
        """Return the copies as one stitch mesh, with stitches of 1 cm."""
        block, count = self.block, len(self.copy)
        corner_count = len(block.corners)
        vertex, image = self._corners()
        width, height = self.count * [block.width, block.height]
        twist, shift, layer = (np.tile(marks, count) for marks in self._marks())
        starts = (np.arange(count)[:, None] * corner_count + self.first_corner[:-1]).ravel()
        return StitchMesh(
            vertices=self._vertices(),
            face_start=np.append(starts, count * corner_count),
            face_vertex=vertex,
            twin=self._twins(),
            lattice=Lattice(np.array([[width, 0.0, 0.0], [0.0, height, 0.0]])),
            corner_image=image,
            n_bottom=np.tile(block.n_bottom, count),
            n_top=np.tile(block.n_top, count),
            stitch=np.tile(block.stitch, count),
            row=(self.copy[:, 1, None] * block.height + block.row).ravel(),
            yarn=np.tile(block.yarn, count),
            twist=twist,
            cable_shift=shift,
            cable_layer=layer,
            palette=np.array(self.tile.palette, dtype=np.uint8),
            own_stitches=self.tile.own_stitches,
        )

    def _vertices(self) -> FloatArray:
        """Return the ends of the loops [cm], by copy; the last end of each line and the last line are left out."""
        x = np.concatenate([line[:-1] for line in self.block.lines[:-1]])
        y = np.repeat(np.arange(self.block.height), self.size[:-1])
        own = np.stack([x, y], axis=1)
        place = own + (self.copy * [self.block.width, self.block.height])[:, None, :]
        return np.pad(place.reshape(-1, 2), [(0, 0), (0, 1)])

    def _corners(self) -> tuple[IntArray, IntArray]:
        """Return the vertex and the lattice image of each corner, shapes (C,) and (C, 2)."""
        line = np.repeat(np.arange(len(self.size)), self.size + 1)[self.block.corners]
        first = np.concatenate([[0], np.cumsum(self.size + 1)])
        place = self.block.corners - first[line]
        beyond = np.stack([place == self.size[line], line == self.block.height], axis=1)  # start of the next copy
        start = np.concatenate([[0], np.cumsum(self.size[:-1])])
        own = start[np.where(beyond[:, 1], 0, line)] + np.where(beyond[:, 0], 0, place)
        image, copy = self._wrapped(self.copy[:, None, :] + beyond)
        return (copy * start[-1] + own).ravel(), image.reshape(-1, 2)

    def _wrapped(self, copy: IntArray) -> tuple[IntArray, IntArray]:
        """Return the lattice image of copies given by column and row, and their numbers in the cell."""
        within = copy % self.count
        return copy // self.count, within[..., 1] * self.count[0] + within[..., 0]

    def _twins(self) -> IntArray:
        """Return the opposite side of each side, shape (C,)."""
        block = self.block
        across = self._corner_of(block.twin)
        step = np.zeros((len(block.corners), 2), dtype=np.int64)
        for role, opposite, towards in (
            (BOTTOM, TOP, (0, -1)), (TOP, BOTTOM, (0, 1)), (LEFT, RIGHT, (-1, 0)), (RIGHT, LEFT, (1, 0)),
        ):  # fmt: skip
            own = self._corner_of(block.border[role])
            across[own], step[own] = self._corner_of(block.border[opposite]), towards
        _, copy = self._wrapped(self.copy[:, None, :] + step)
        twin: IntArray = (copy * len(block.corners) + across).ravel()
        return twin

    def _corner_of(self, places: IntArray) -> IntArray:
        """Return the numbers within the block of corners given as (face, place); shape (n, 2) to (n,)."""
        corner: IntArray = self.first_corner[places[:, 0]] + places[:, 1]
        return corner

    def _marks(self) -> tuple[IntArray, IntArray, IntArray]:
        """Return twists, shifts and layers of the sides of one copy. The first row of the tile works its top loops."""
        twist, shift, layer = (
            marks.copy() for marks in (self.block.twist, self.block.cable_shift, self.block.cable_layer)
        )
        upper = self._corner_of(self.block.border[TOP])
        loops = self.tile.loops_above(self.tile.height - 1)
        twist[upper] = [loop.twist for loop in loops]
        shift[upper] = [loop.shift for loop in loops]
        layer[upper] = [loop.layer for loop in loops]
        return twist, shift, layer
