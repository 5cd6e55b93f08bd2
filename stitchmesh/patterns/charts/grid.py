# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The grid of a chart in the editor: its limits, a box of squares, and the brush that paints squares."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray

LONGEST_SIDE = 500
"""Largest number of rows, and of columns, of a chart in the editor."""
BLANK = -1
"""Index that stands for a new row or column in ``EditedChart.taken``."""


@dataclass(frozen=True)
class Box:
    """A rectangle of squares; rows and columns are numbered from 0, and the ends are not part of the box.

    Raises:
        ParameterError: the box is empty or begins below 0.
    """

    row: int
    column: int
    row_end: int
    column_end: int

    def __post_init__(self) -> None:
        if min(self.row, self.column) < 0 or self.row_end <= self.row or self.column_end <= self.column:
            found = f"rows {self.row} to {self.row_end} and columns {self.column} to {self.column_end}"
            raise ParameterError(f"box of a chart: got {found}; expected at least one square")

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of columns."""
        return self.row_end - self.row, self.column_end - self.column

    @property
    def rows(self) -> IntArray:
        """The rows of the box."""
        return np.arange(self.row, self.row_end)

    @property
    def columns(self) -> IntArray:
        """The columns of the box."""
        return np.arange(self.column, self.column_end)

    def within(self, shape: tuple[int, int]) -> Box:
        """Return the part of the box that lies in a chart of ``shape`` (rows, columns).

        Raises:
            ParameterError: the box lies outside.
        """
        return Box(self.row, self.column, min(self.row_end, shape[0]), min(self.column_end, shape[1]))

    def places(self) -> IntArray:
        """Return row and column of every square, row by row, shape (n, 2)."""
        return np.stack(np.meshgrid(self.rows, self.columns, indexing="ij"), axis=-1).reshape(-1, 2)


@dataclass(frozen=True)
class Brush:
    """The changes that painting makes; None leaves that property of a square as it is."""

    word: str | None = None
    """The stitch: a word of a chart (``docs/patterns.md``); in a weave "1" (weft over) or "0" (warp over)."""
    yarn: int | None = None
    """The number of the yarn; the yarns of a weave belong to its threads."""


class EditedChart(Protocol):
    """The methods of a chart that the operations need; each returns a new chart and leaves this chart as it is."""

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of columns."""

    def painted(self, places: IntArray, brush: Brush) -> Self:
        """Paint squares one after another.

        Args:
            places: row and column of each square, shape (n, 2). A word that covers several squares begins there.
            brush: the stitch and the yarn.
        """

    def taken(self, rows: IntArray, columns: IntArray) -> Self:
        """Make a chart from rows and columns of this chart, in any order; ``BLANK`` makes a new one."""

    def pasted(self, part: Self, row: int, column: int) -> Self:
        """Put another chart over the squares that begin at a place; squares outside are dropped."""

    def blanked(self, box: Box) -> Self:
        """Return the chart with plain squares in a box."""

    def mirrored(self, *, upwards: bool) -> Self:
        """Mirror the whole chart from left to right, or from the lowest to the highest row with ``upwards``."""

    def equal_squares(self, row: int, column: int) -> NDArray[np.bool_]:
        """Whether each square has the stitch and the yarn of a given square, shape (rows, columns)."""


def check_chart_shape(shape: tuple[int, ...]) -> None:
    """Check the number of rows and columns of a chart that is edited.

    Raises:
        ParameterError: the chart is empty, or longer or wider than ``LONGEST_SIDE``.
    """
    if len(shape) != 2 or not (1 <= shape[0] <= LONGEST_SIDE and 1 <= shape[1] <= LONGEST_SIDE):
        found = " x ".join(str(side) for side in shape)
        expected = f"1 to {LONGEST_SIDE} rows and as many columns"
        raise ParameterError(f"chart: got {found} (rows x columns); expected {expected}: crop or scale it")
