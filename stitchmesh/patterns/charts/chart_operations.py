# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Operations on charts in the editor, of knits and of weaves; each makes a new chart."""

from __future__ import annotations

from typing import Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import label as connected_parts

from stitchmesh.errors import ParameterError
from stitchmesh.patterns.charts.grid import BLANK, Box, Brush, EditedChart, check_chart_shape

ChartT = TypeVar("ChartT", bound=EditedChart)
Axis = Literal["rows", "columns"]


def paint(chart: ChartT, places: ArrayLike, brush: Brush) -> ChartT:
    """Paint squares.

    Args:
        chart: the chart.
        places: row and column of each square from 0, in the order of painting, shape (n, 2); places outside are
            dropped.
        brush: the stitch and the yarn.

    Raises:
        ParameterError: a word has no room, or a place is not a pair of whole numbers.
        PatternError: the word describes no stitch.
    """
    found = np.array(places, dtype=np.int64).reshape(-1, 2)
    inside = ((found >= 0) & (found < chart.shape)).all(axis=1)
    return chart.painted(found[inside], brush) if inside.any() else chart


def fill(chart: ChartT, row: int, column: int, brush: Brush) -> ChartT:
    """Paint a square and all squares that are equal to it and connected to it along the sides of squares.

    Raises:
        ParameterError: the square lies outside, or a word has no room.
        PatternError: the word describes no stitch.
    """
    _check_inside(chart, row, column)
    parts, _ = connected_parts(chart.equal_squares(row, column))
    return chart.painted(np.argwhere(parts == parts[row, column]), brush)


def fill_box(chart: ChartT, box: Box, brush: Brush) -> ChartT:
    """Paint all squares of a box.

    Raises:
        ParameterError: the box lies outside, or a word has no room.
        PatternError: the word describes no stitch.
    """
    inside = box.within(chart.shape)
    part = crop(chart, inside)
    whole = Box(0, 0, *inside.shape)
    return chart.pasted(part.painted(whole.places(), brush), inside.row, inside.column)


def resize(chart: ChartT, rows: int, columns: int) -> ChartT:
    """Give a chart another number of rows and columns; new ones follow the last row and the last column.

    Raises:
        ParameterError: the chart would be empty, or larger than ``grid.LONGEST_SIDE``.
    """
    check_chart_shape((rows, columns))
    return chart.taken(_kept(chart.shape[0], rows), _kept(chart.shape[1], columns))


def insert(chart: ChartT, axis: Axis, before: int, count: int = 1) -> ChartT:
    """Insert plain rows or columns before a row or column, or after the last one.

    Raises:
        ParameterError: the place lies outside, or the chart would be larger than ``grid.LONGEST_SIDE``.
    """
    size = chart.shape[axis == "columns"]
    if not 0 <= before <= size or count < 1:
        raise ParameterError(f"chart: got {count} {axis} before {before}; expected 1 or more, before 0 to {size}")
    return _taken(chart, axis, np.insert(np.arange(size), before, [BLANK] * count))


def remove(chart: ChartT, axis: Axis, first: int, end: int) -> ChartT:
    """Remove the rows or columns from ``first`` to ``end``, ``end`` excluded.

    Raises:
        ParameterError: there are no such rows or columns, or none would be left.
    """
    size = chart.shape[axis == "columns"]
    if not 0 <= first < end <= size or end - first == size:
        found = f"{axis} {first} to {end} of {size}"
        raise ParameterError(f"chart: got {found} to remove; expected some of them, and some that stay")
    return _taken(chart, axis, np.delete(np.arange(size), slice(first, end)))


def mirror(chart: ChartT, *, upwards: bool = False, box: Box | None = None) -> ChartT:
    """Mirror a chart, or a box of it, from left to right, or with ``upwards`` from its lowest to its highest row.

    From left to right, stitches and cables that lean become those that lean to the other side.

    Raises:
        ParameterError: the box lies outside.
    """
    if box is None:
        return chart.mirrored(upwards=upwards)
    inside = box.within(chart.shape)
    return chart.pasted(crop(chart, inside).mirrored(upwards=upwards), inside.row, inside.column)


def crop(chart: ChartT, box: Box) -> ChartT:
    """Return the part of a chart in a box, without borders.

    Raises:
        ParameterError: the box lies outside.
    """
    inside = box.within(chart.shape)
    return chart.taken(inside.rows, inside.columns)


def repeat(chart: ChartT, rows: int, columns: int) -> ChartT:
    """Return a chart of several copies side by side and one above another.

    Raises:
        ParameterError: a number is less than 1, or the chart would be larger than ``grid.LONGEST_SIDE``.
    """
    shape = chart.shape[0] * rows, chart.shape[1] * columns
    check_chart_shape(shape)
    return chart.taken(np.arange(shape[0]) % chart.shape[0], np.arange(shape[1]) % chart.shape[1])


def repeat_box(chart: ChartT, box: Box) -> ChartT:
    """Fill a whole chart with copies of a box; the box stays where it is.

    Raises:
        ParameterError: the box lies outside.
    """
    inside = box.within(chart.shape)
    height, width = inside.shape
    part = crop(chart, inside)
    rows = (np.arange(chart.shape[0]) - inside.row) % height
    columns = (np.arange(chart.shape[1]) - inside.column) % width
    return chart.pasted(part.taken(rows, columns), 0, 0)


def move(chart: ChartT, box: Box, rows: int, columns: int, *, keep: bool = False) -> ChartT:
    """Move the squares of a box; plain squares take their place, and squares that leave the chart are dropped.

    Args:
        chart: the chart.
        box: the squares.
        rows: number of rows towards higher row numbers.
        columns: number of columns to the right.
        keep: whether the squares also stay where they are, so that they are copied.

    Raises:
        ParameterError: the box lies outside.
    """
    inside = box.within(chart.shape)
    part = crop(chart, inside)
    ground = chart if keep else chart.blanked(inside)
    return ground.pasted(part, inside.row + rows, inside.column + columns)


def paste(chart: ChartT, part: ChartT, row: int, column: int) -> ChartT:
    """Put a part that ``crop`` made over the squares that begin at a place; squares outside are dropped."""
    return chart.pasted(part, row, column)


def _taken(chart: ChartT, axis: Axis, kept: np.ndarray) -> ChartT:
    rows, columns = np.arange(chart.shape[0]), np.arange(chart.shape[1])
    check_chart_shape((len(kept), len(columns)) if axis == "rows" else (len(rows), len(kept)))
    return chart.taken(kept, columns) if axis == "rows" else chart.taken(rows, kept)


def _kept(size: int, wanted: int) -> np.ndarray:
    index = np.arange(wanted)
    return np.where(index < size, index, BLANK)


def _check_inside(chart: EditedChart, row: int, column: int) -> None:
    if not (0 <= row < chart.shape[0] and 0 <= column < chart.shape[1]):
        found = f"row {row} and column {column}"
        raise ParameterError(f"chart: got {found}; expected a square of its {chart.shape[0]} x {chart.shape[1]}")
