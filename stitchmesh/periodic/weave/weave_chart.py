# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A weave as an editable chart: the matrix with its wefts and warps, whether or not the fabric hangs together.

A fabric of several layers is one chart of all yarns; ``layer_chart`` shows the crossings of one layer alone, and
``with_layer`` puts that chart back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.mesh import IntArray
from stitchmesh.mesh.polygon_mesh import frozen_array
from stitchmesh.patterns.charts.grid import BLANK, Box, Brush, check_chart_shape
from stitchmesh.patterns.charts.knit_chart import overlap
from stitchmesh.patterns.language.tokens import TextPlace
from stitchmesh.periodic.weave.text import WrittenWeave, format_weave, parse_written_weave
from stitchmesh.periodic.weave.weave import Thread, Weave

Threads = Literal["wefts", "warps"]


@dataclass(frozen=True, eq=False)
class WeaveChart:
    """A weave that may fall apart.

    Raises:
        ParameterError: the chart is empty or too large, a square is not 0 or 1, or the number of threads differs from
            the rows or columns.
    """

    words: ClassVar[tuple[str, str]] = ("0", "1")
    squares: IntArray
    """1 where the weft of a row passes over the warp of a column, otherwise 0, shape (wefts, warps); top row first."""
    wefts: tuple[Thread, ...] = ()
    """Properties of the weft of each row; all equal by default."""
    warps: tuple[Thread, ...] = ()
    """Properties of the warp of each column; all equal by default."""
    name: str = "weave"
    source: str = ""
    palette: tuple[tuple[int, int, int], ...] = ()
    """Colour of each colour number (sRGB, 0 to 255)."""

    def __post_init__(self) -> None:
        squares = np.asarray(self.squares)
        check_chart_shape(squares.shape)
        if not np.isin(squares, (0, 1)).all():
            raise ParameterError("chart of a weave: got other numbers than 0 and 1; expected 1 where the weft is over")
        for kind, count in zip(("wefts", "warps"), squares.shape, strict=True):
            threads = tuple(getattr(self, kind)) or (Thread(),) * count
            object.__setattr__(self, kind, threads)
            if len(threads) != count:
                raise ParameterError(f"chart of a weave: got {len(threads)} {kind} of {count}; expected one for each")
        object.__setattr__(self, "squares", frozen_array(squares, np.int64))

    def __repr__(self) -> str:
        """Return one line: the name and the size."""
        return f"WeaveChart({self.name!r}, {self.shape[1]} warps x {self.shape[0]} wefts)"

    @property
    def shape(self) -> tuple[int, int]:
        """Number of wefts and of warps."""
        return self.squares.shape[0], self.squares.shape[1]

    @property
    def yarns(self) -> IntArray:
        """Number of the colour on top at each crossing, shape (wefts, warps)."""
        weft, warp = (np.array([thread.colour for thread in threads]) for threads in (self.wefts, self.warps))
        return np.where(self.squares == 1, weft[:, None], warp[None, :])

    @property
    def yarn_count(self) -> int:
        """One more than the largest colour number."""
        return 1 + max(thread.colour for thread in (*self.wefts, *self.warps))

    @property
    def layer_count(self) -> int:
        """Number of layers."""
        return 1 + max(thread.layer for thread in (*self.wefts, *self.warps))

    def word_at(self, row: int, column: int) -> str:
        """Return "1" where the weft is over and "0" where the warp is over."""
        return self.words[self.squares[row, column]]

    def weave(self) -> Weave:
        """Return the weave.

        Raises:
            PatternError: a yarn never interlaces, or the fabric falls apart.
        """
        matrix = tuple(map(tuple, self.squares.tolist()))
        return Weave(matrix, self.wefts, self.warps, self.name, self.source, self.palette)

    def painted(self, places: IntArray, brush: Brush) -> WeaveChart:
        """Paint squares; see ``EditedChart``.

        Raises:
            PatternError: the word is neither 0 nor 1.
            ParameterError: the brush has a yarn.
        """
        if brush.yarn is not None:
            raise ParameterError("chart of a weave: got a colour for squares; give it to wefts or warps (dye)")
        if brush.word is None:
            return self
        if brush.word not in self.words:
            raise PatternError(f"chart of a weave: got {brush.word!r}; expected 1 (weft over) or 0 (warp over)")
        squares = self.squares.copy()
        squares[places[:, 0], places[:, 1]] = int(brush.word)
        return replace(self, squares=squares)

    def dyed(self, kind: Threads, numbers: ArrayLike, colour: int) -> WeaveChart:
        """Give a colour number to some wefts or warps.

        Args:
            kind: ``wefts`` or ``warps``.
            numbers: indices of the threads from the top or the left, shape (n,); other numbers are dropped.
            colour: the colour number.
        """
        chosen = set(np.asarray(numbers, dtype=np.int64).ravel().tolist())
        threads = getattr(self, kind)
        dyed = tuple(
            replace(thread, colour=colour) if index in chosen else thread for index, thread in enumerate(threads)
        )
        return replace(self, wefts=dyed) if kind == "wefts" else replace(self, warps=dyed)

    def taken(self, rows: IntArray, columns: IntArray) -> WeaveChart:
        """Make a chart from wefts and warps of this chart; new ones repeat the weave."""
        check_chart_shape((len(rows), len(columns)))
        rows, columns = _repeating(rows, self.shape[0]), _repeating(columns, self.shape[1])
        wefts = tuple(self.wefts[row] for row in rows.tolist())
        warps = tuple(self.warps[column] for column in columns.tolist())
        return replace(self, squares=self.squares[np.ix_(rows, columns)], wefts=wefts, warps=warps)

    def pasted(self, part: WeaveChart, row: int, column: int) -> WeaveChart:
        """Put the crossings of another chart over the crossings that begin at a place; the threads stay as they are."""
        squares = self.squares.copy()
        target, own = overlap(self.shape, part.shape, row, column)
        squares[target] = part.squares[own]
        return replace(self, squares=squares)

    def blanked(self, box: Box) -> WeaveChart:
        """Return the chart with plain weave in a box; layers there lie one behind another."""
        inside = box.within(self.shape)
        target = np.ix_(inside.rows, inside.columns)
        squares = self.squares.copy()
        squares[target] = self._plain()[target]
        return replace(self, squares=squares)

    def mirrored(self, *, upwards: bool) -> WeaveChart:
        """Mirror the chart with its threads from left to right, or from the top to the bottom with ``upwards``."""
        if upwards:
            return replace(self, squares=self.squares[::-1], wefts=self.wefts[::-1])
        return replace(self, squares=self.squares[:, ::-1], warps=self.warps[::-1])

    def equal_squares(self, row: int, column: int) -> NDArray[np.bool_]:
        """Whether each square has the value of a given square, shape (wefts, warps)."""
        return np.asarray(self.squares == self.squares[row, column])

    def layer_chart(self, layer: int) -> WeaveChart:
        """Return the chart of the wefts and warps of one layer.

        Raises:
            ParameterError: no weft or no warp is in the layer.
        """
        return self.taken(*self._of_layer(layer))

    def with_layer(self, layer: int, part: WeaveChart) -> WeaveChart:
        """Return the chart with the crossings and threads of one layer taken from a chart that ``layer_chart`` made.

        Raises:
            ParameterError: the chart has another size than the layer.
        """
        rows, columns = self._of_layer(layer)
        if part.shape != (len(rows), len(columns)):
            found = f"{part.shape[0]} x {part.shape[1]} crossings"
            raise ParameterError(f"layer {layer + 1}: got {found}; expected {len(rows)} x {len(columns)}")
        squares, wefts, warps = self.squares.copy(), list(self.wefts), list(self.warps)
        squares[np.ix_(rows, columns)] = part.squares
        for threads, places, own in ((wefts, rows, part.wefts), (warps, columns, part.warps)):
            for place, thread in zip(places.tolist(), own, strict=True):
                threads[place] = thread
        return replace(self, squares=squares, wefts=tuple(wefts), warps=tuple(warps), palette=part.palette)

    def _of_layer(self, layer: int) -> tuple[IntArray, IntArray]:
        rows, columns = (
            np.array([index for index, thread in enumerate(threads) if thread.layer == layer], dtype=np.int64)
            for threads in (self.wefts, self.warps)
        )
        if not len(rows) or not len(columns):
            found = f"{len(rows)} wefts and {len(columns)} warps in layer {layer + 1}"
            raise ParameterError(f"chart of a weave: got {found}; expected at least one of each")
        return rows, columns

    def _plain(self) -> IntArray:
        """Plain weave in each layer, with the layers one behind another, shape (wefts, warps)."""
        weft, warp = (np.array([thread.layer for thread in threads]) for threads in (self.wefts, self.warps))
        numbers = [
            [sum(other.layer == thread.layer for other in threads[:index]) for index, thread in enumerate(threads)]
            for threads in (self.wefts, self.warps)
        ]
        alternating = np.add.outer(numbers[0], numbers[1]) % 2
        return np.where(weft[:, None] == warp[None, :], alternating, weft[:, None] < warp[None, :])


@dataclass(frozen=True, eq=False)
class WeaveChartText:
    """A chart of a weave with its text."""

    text: str
    chart: WeaveChart
    places: tuple[TextPlace, ...]
    """Place in the text of each weft, from the top."""

    def pattern(self) -> Weave:
        """Return the weave.

        Raises:
            PatternError: the fabric falls apart; if one weft is at fault, the error has its line.
        """
        try:
            return self.chart.weave()
        except PatternError as error:
            line = None if error.row is None else self.places[error.row].line
            raise PatternError(str(error), line=line, column=1 if line else None, row=error.row) from None


def weave_chart(weave: Weave) -> WeaveChart:
    """Return the chart of a weave.

    Raises:
        ParameterError: the chart is larger than ``grid.LONGEST_SIDE``.
    """
    squares = np.array(weave.matrix, dtype=np.int64)
    return WeaveChart(squares, weave.wefts, weave.warps, weave.name, weave.source, weave.palette)


def write_weave_chart(chart: WeaveChart) -> WeaveChartText:
    """Write a chart as text that ``parse_weave_chart`` reads."""
    names = chart.name, chart.source, chart.palette
    matrix = tuple(map(tuple, chart.squares.tolist()))
    text = format_weave(WrittenWeave(matrix, chart.wefts, chart.warps, *names))
    first = text.count("\n") - chart.shape[0] + 1
    return WeaveChartText(text, chart, tuple(TextPlace(chart.name, first + row, 1) for row in range(chart.shape[0])))


def parse_weave_chart(text: str, name: str = "weave") -> WeaveChartText:
    """Read the chart of a weave from a text, whether or not the fabric hangs together.

    Raises:
        PatternError: a statement cannot be read; the message gives the line and the column.
        ParameterError: the chart is larger than ``grid.LONGEST_SIDE``.
    """
    written = parse_written_weave(text, name)
    names = written.name, written.source, written.palette
    chart = WeaveChart(np.array(written.matrix, dtype=np.int64), written.wefts, written.warps, *names)
    return WeaveChartText(text, chart, written.places)


def _repeating(index: IntArray, count: int) -> IntArray:
    """Return indices of threads; each new thread gets the index that it has in a repeat of all threads."""
    places = np.arange(len(index))
    return np.where(np.asarray(index) == BLANK, places % count, index)
