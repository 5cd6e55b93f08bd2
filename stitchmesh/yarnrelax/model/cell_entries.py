# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The entries of a state that belong to some cells of a batch, one cell after another.

The arrays of a state hold the control points of all cells, and then the strains of the cells if their periods relax.
Here the control points of a cell stand before its strain, so that one call of ``reduceat`` serves all cells. What it
finds in a cell depends on the entries of this cell alone, to the last bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.model.constants import Model


@dataclass(frozen=True, eq=False)
class CellEntries:
    """The M entries of K cells."""

    cells: NDArray[np.int64]
    """Numbers of the cells, ascending, shape (K,)."""
    number: NDArray[np.int64]
    """Number of each entry in the arrays of a state, shape (M,)."""
    start: NDArray[np.int64]
    """Place of the first entry of each cell, shape (K,)."""
    cell: NDArray[np.int64]
    """Cell of each entry, from 0 to K - 1, shape (M,)."""
    is_point: NDArray[np.bool_]
    """Whether each entry is a control point, shape (M,)."""

    @classmethod
    def of(cls, model: Model, cells: NDArray[np.bool_], *, relaxes: bool) -> CellEntries:
        """Return the entries of some cells, shape (C,); ``relaxes`` says whether the cells have strains."""
        chosen, counts = np.flatnonzero(cells), np.diff(model.point_start)[cells] + relaxes
        start, cell = np.cumsum(counts) - counts, np.repeat(np.arange(len(counts)), counts)
        number = np.arange(len(cell)) + (model.point_start[:-1][cells] - start)[cell]
        is_point = np.ones(len(cell), dtype=bool)
        if relaxes:
            last = start + counts - 1
            number[last], is_point[last] = model.point_count + chosen, False
        return cls(chosen, number, start, cell, is_point)

    def largest(self, values: FloatArray) -> FloatArray:
        """Return the largest of the values in each cell, from shape (M,) to (K,)."""
        return np.maximum.reduceat(values, self.start) if len(self.start) else np.zeros(0)

    def sums(self, values: FloatArray) -> FloatArray:
        """Return the sum of the values in each cell, from shape (M,) to (K,)."""
        return np.add.reduceat(values, self.start) if len(self.start) else np.zeros(0)

    @property
    def points(self) -> NDArray[np.int64]:
        """Number of control points of each cell, shape (K,)."""
        return np.bincount(self.cell[self.is_point], minlength=len(self.cells))

    @property
    def strains(self) -> NDArray[np.int64]:
        """Numbers of the strains of the cells in the arrays of a state, shape (K,); none if cells do not relax."""
        return self.number[~self.is_point]
