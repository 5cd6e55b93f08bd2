# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The sites of a pattern's units: the rectangles of plain stitches that take them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.courses import right_neighbours
from stitchmesh.patterns.pattern import Pattern
from stitchmesh.patterns.placement.block import Block
from stitchmesh.patterns.placement.columns import LEFT_BORDER, OUTSIDE, RIGHT_BORDER, TILE, columns_of
from stitchmesh.patterns.placement.placement import Placement, is_plain, plain_above
from stitchmesh.patterns.placement.units import Unit


@dataclass(frozen=True, eq=False)
class Site:
    """The places of all copies of a unit."""

    unit: Unit
    """The unit that is copied."""
    grids: IntArray
    """Plain faces that each copy replaces, from the lower left, shape (copies, rows, columns)."""

    @property
    def block(self) -> Block:
        """Faces of the unit."""
        return self.unit.block

    @property
    def face_count(self) -> int:
        """Number of faces of all copies."""
        return len(self.grids) * len(self.block.stitch)


class CellNumbers:
    """The number of each face's cell in a pattern whose cells are counted by base column and row."""

    def __init__(self, pattern: Pattern, placement: Placement) -> None:
        """Find the cell of each face; ``BORDER`` outside the pattern."""
        self._height = pattern.height
        self._first = np.cumsum([0, *pattern.rows[0].bottoms])
        self.of_face = np.full(len(placement.column), BORDER)
        for section in (LEFT_BORDER, TILE, RIGHT_BORDER):
            columns = columns_of(section, placement.column)
            own = np.flatnonzero(columns != OUTSIDE)
            width = max(pattern.rows[0].bottoms[section], 1)
            self.of_face[own] = self.number(section, placement.row[own], columns[own] % width)

    def number(self, section: int, row: IntArray | int, column: IntArray | int) -> IntArray:
        """Return the number of a cell."""
        number: IntArray = np.asarray(row * self._first[-1] + self._first[section] + column)
        return number


def find_sites(
    fabric: StitchMesh, placement: Placement, cells: CellNumbers, units: tuple[Unit, ...]
) -> tuple[list[Site], NDArray[np.bool_]]:
    """Find the sites of units, whose earlier ones go first.

    Args:
        fabric: the mesh.
        placement: the pattern's row and column of each face.
        cells: the number of each face's cell.
        units: units of the pattern, whole sections first.

    Returns:
        The sites that have copies, and whether each face belongs to one of them, shape (F,).
    """
    free = is_plain(fabric) & (cells.of_face != BORDER)
    taken = np.zeros(fabric.face_count, dtype=bool)
    right, above = right_neighbours(fabric), plain_above(fabric)
    faces = np.flatnonzero(free)
    faces = faces[np.argsort(cells.of_face[faces], kind="stable")]
    numbers = cells.of_face[faces]
    sites = []
    for unit in units:
        number = cells.number(unit.section, unit.row, unit.column)
        first = faces[np.searchsorted(numbers, number) : np.searchsorted(numbers, number, side="right")]
        grids = _grids(first, unit.block, right, above)
        columns = placement.column[grids]
        whole = (grids != BORDER).all(axis=(1, 2)) & (free & ~taken)[grids].all(axis=(1, 2))
        whole &= (columns == columns[:, :1, :1] + np.arange(unit.block.width)).all(axis=(1, 2))
        whole &= (placement.row[grids] == unit.row + np.arange(unit.block.height)[:, None]).all(axis=(1, 2))
        whole &= (right[grids[:, :, :-1]] == grids[:, :, 1:]).all(axis=(1, 2))
        if whole.any():
            sites.append(Site(unit, grids[whole]))
            taken[grids[whole].ravel()] = True
    return sites, taken


def _grids(first: IntArray, block: Block, right: IntArray, above: IntArray) -> IntArray:
    """Return the faces to the right of and above each given face, shape (n, rows, columns)."""
    lowest = [first]
    for _ in range(block.width - 1):
        lowest.append(_neighbours(right, lowest[-1]))
    rows = [np.stack(lowest, axis=1)]
    for _ in range(block.height - 1):
        rows.append(_neighbours(above, rows[-1]))
    return np.stack(rows, axis=1)


def _neighbours(step: IntArray, faces: IntArray) -> IntArray:
    return np.where(faces == BORDER, BORDER, step[faces])
