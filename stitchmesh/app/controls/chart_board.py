# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The state of a chart editor: the chart and its text with their steps, the brush, the selection and the fault."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from stitchmesh.editing.undo_history import UndoHistory
from stitchmesh.errors import ParameterError, PatternError, StitchMeshError
from stitchmesh.mesh.palette import LAST_YARN, parse_colour, recolour_palette
from stitchmesh.patterns import Pattern, check_closes
from stitchmesh.patterns.charts import chart_operations as operations
from stitchmesh.patterns.charts.grid import Box, Brush, check_chart_shape
from stitchmesh.patterns.charts.knit_chart import PLAIN, KnitChart, read_square
from stitchmesh.periodic.charts.chart_files import Chart, ChartText, chart_of, parse_chart, write_chart
from stitchmesh.periodic.resolve_pattern import Source
from stitchmesh.periodic.weave.weave_chart import Threads, WeaveChart

MOST_SQUARES = 5_000_000
"""Number of squares that all steps of a chart may hold, about 100 MB; a large chart therefore has fewer steps."""
LEAST_STEPS, MOST_STEPS = 10, 200
"""Bounds of the number of steps that can be undone."""
Operation = Callable[[Chart], Chart]
NewChart = Literal["Knit", "Colours", "Weave"]
NEW_CHARTS: tuple[NewChart, ...] = get_args(NewChart)


class ChartBoard:
    """A chart in the editor. Every method that changes the chart is one step that can be undone."""

    def __init__(self, written: ChartText) -> None:
        """Start with a chart and its text."""
        self.history: UndoHistory[ChartText] = UndoHistory(written)
        self.text = written.text
        """The text as the user sees it. If it is unreadable, the chart is the chart of the last readable text."""
        self.source: Source | None = None
        """The last valid pattern or weave of the chart; None if no state was valid."""
        self.fault = ""
        """Why the chart or the text describes no fabric; empty if it does."""
        self.fault_line: int | None = None
        """Line of the text at fault, from 1."""
        self.yarn = 0
        """Number of the yarn that the user chose last."""
        self.brush = Brush()
        """What painting changes: the stitch, the yarn, or both."""
        self.selection: Box | None = None
        self.layer: int | None = None
        """Number of the layer of a weave that is shown alone; None for all layers."""
        self._clipboard: Chart | None = None
        self._stroke = 0  # The parts of one stroke are one step.
        self._settle()

    @property
    def chart(self) -> Chart:
        """The whole chart."""
        return self.history.present.chart

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo, or a text that could not be read."""
        return bool(self.history.past) or self.text != self.history.present.text

    @property
    def view(self) -> Chart:
        """The visible chart: the whole chart, or one layer of a weave."""
        chart = self.chart
        return chart.layer_chart(self.layer) if isinstance(chart, WeaveChart) and self.layer is not None else chart

    @property
    def fault_row(self) -> int | None:
        """Row of the chart at fault, from 0."""
        lines = [place.line for place in self.history.present.places]
        readable = self.text == self.history.present.text and self.layer is None
        return lines.index(self.fault_line) if readable and self.fault_line in lines else None

    def edit(self, operation: Operation, *, merge: bool = False) -> None:
        """Apply an operation to the visible chart.

        Args:
            operation: makes a new chart.
            merge: whether the change belongs to the last step, as the next part of a stroke does.

        Raises:
            StitchMeshError: the library refuses the operation; the chart stays as it is.
        """
        whole, view = self.chart, self.view
        edited = operation(view)
        if isinstance(whole, WeaveChart) and isinstance(edited, WeaveChart) and self.layer is not None:
            edited = self._with_layer(whole, edited)
        written = write_chart(edited)
        if not merge:
            self._stroke += 1
        if written.text != write_chart(whole).text:
            self._step(written, f"stroke {self._stroke}")

    def paint(self, places: Sequence[Sequence[int]], brush: Brush, *, merge: bool = False) -> None:
        """Paint squares one after another; rows and columns count in the visible chart."""
        self.edit(lambda chart: operations.paint(chart, places, brush), merge=merge)

    def fill(self, row: int, column: int, brush: Brush) -> None:
        """Paint all connected equal squares."""
        self.edit(lambda chart: operations.fill(chart, row, column, brush))

    def paint_box(self, box: Box, brush: Brush) -> None:
        """Paint all squares of a box."""
        self.edit(lambda chart: operations.fill_box(chart, box, brush))

    def dye(self, kind: Threads, numbers: Sequence[int]) -> None:
        """Give the brush's yarn to wefts or warps, counted from the top or the left of the visible chart."""
        self.edit(lambda chart: chart.dyed(kind, numbers, self.yarn) if isinstance(chart, WeaveChart) else chart)

    def pick(self, row: int, column: int) -> None:
        """Take the stitch and the yarn of a square as the brush."""
        view = self.view
        self.yarn = min(int(view.yarns[row, column]), LAST_YARN)
        word = view.word_at(row, column)
        self.brush = Brush(word) if isinstance(view, WeaveChart) else Brush(word, self.yarn)

    @property
    def painted_yarn(self) -> int | None:
        """The yarn with which the brush paints; None if it paints the stitch alone."""
        return self.yarn if isinstance(self.chart, WeaveChart) else self.brush.yarn

    def choose_word(self, word: str) -> None:
        """Choose the stitch of the brush; if it is chosen already, the brush paints the yarn alone.

        Raises:
            PatternError: the word describes no stitch.
        """
        if isinstance(self.chart, KnitChart):
            read_square(word)
        again = word == self.brush.word and self.brush.yarn is not None
        self.brush = replace(self.brush, word=None if again else word)

    def choose_yarn(self, yarn: int) -> None:
        """Choose the yarn of the brush; if it is chosen already, the brush paints the stitch alone.

        Raises:
            ParameterError: the number is beyond the palette.
        """
        if not 0 <= yarn <= LAST_YARN:
            raise ParameterError(f"yarn: got {yarn}; expected 0 to {LAST_YARN}")
        again = yarn == self.brush.yarn and self.brush.word is not None
        self.yarn = yarn
        self.brush = replace(self.brush, yarn=None if again or isinstance(self.chart, WeaveChart) else yarn)

    def set_colour(self, yarn: int, colour: str) -> None:
        """Give a yarn a colour; lower yarns without a colour keep their stock colours.

        Raises:
            ParameterError: the text is no colour.
        """
        own = np.array(self.chart.palette, dtype=np.uint8).reshape(-1, 3)
        colours = recolour_palette(own, {yarn: parse_colour(colour)})
        palette = tuple((int(red), int(green), int(blue)) for red, green, blue in colours)
        if palette != self.chart.palette:
            self._step(write_chart(replace(self.chart, palette=palette)))

    def select(self, box: Box | None) -> None:
        """Select a box of the visible chart."""
        self.selection = None if box is None else box.within(self.view.shape)

    def move_selection(self, rows: int, columns: int, *, keep: bool = False) -> None:
        """Move the selection, or copy it with ``keep``; the selected box moves too."""
        box = self._selected()
        self.edit(lambda chart: operations.move(chart, box, rows, columns, keep=keep))
        corner, end = (box.row + rows, box.column + columns), (box.row_end + rows, box.column_end + columns)
        inside = min(end) > 0 and corner[0] < self.view.shape[0] and corner[1] < self.view.shape[1]
        self.selection = Box(max(corner[0], 0), max(corner[1], 0), *end).within(self.view.shape) if inside else None

    def copy(self) -> None:
        """Keep a copy of the selection for ``paste``."""
        self._clipboard = operations.crop(self.view, self._selected())

    def paste(self) -> None:
        """Put the copy over the squares from the lower left corner of the selection, or the upper left one of a weave.

        Raises:
            ParameterError: nothing was copied, or the copy is from a chart of the other kind.
        """
        part, box = self._clipboard, self.selection or Box(0, 0, 1, 1)
        if part is None or not isinstance(part, type(self.chart)):
            raise ParameterError("chart: there is nothing to paste; select a box and copy it first")
        self.edit(lambda chart: operations.paste(chart, part, box.row, box.column))
        self.select(Box(box.row, box.column, box.row + part.shape[0], box.column + part.shape[1]))

    def clear_selection(self) -> None:
        """Replace the selection by plain squares."""
        box = self._selected()
        self.edit(lambda chart: chart.blanked(box))

    def mirror(self, *, upwards: bool) -> None:
        """Mirror the selection, or the whole chart if nothing is selected."""
        self.edit(lambda chart: operations.mirror(chart, upwards=upwards, box=self.selection))

    def repeat_selection(self) -> None:
        """Fill the chart with copies of the selection."""
        box = self._selected()
        self.edit(lambda chart: operations.repeat_box(chart, box))

    def crop(self) -> None:
        """Crop the chart to the selection."""
        box = self._selected()
        self.edit(lambda chart: operations.crop(chart, box))
        self.selection = None

    def set_repeat(self) -> None:
        """Repeat the columns of the selection, and make the others borders. Without a selection all columns repeat.

        Raises:
            ParameterError: the chart is a weave, which has no borders.
        """
        chart = self.chart
        if not isinstance(chart, KnitChart):
            raise ParameterError("chart of a weave: has no borders; crop it to the box that repeats")
        box = self.selection or Box(0, 0, *chart.shape)
        self._step(write_chart(replace(chart, left=box.column, right=chart.shape[1] - box.column_end)))

    def resize(self, rows: int, columns: int) -> None:
        """Give the chart another size."""
        self.edit(lambda chart: operations.resize(chart, rows, columns))
        self.selection = None

    def tile(self, rows: int, columns: int) -> None:
        """Put copies of the chart beside and above one another."""
        self.edit(lambda chart: operations.repeat(chart, rows, columns))

    def insert(self, axis: operations.Axis) -> None:
        """Insert a row or a column before the selection, or after the last one."""
        size = self.view.shape[axis == "columns"]
        before = size if self.selection is None else getattr(self.selection, "row" if axis == "rows" else "column")
        self.edit(lambda chart: operations.insert(chart, axis, before))

    def remove(self, axis: operations.Axis) -> None:
        """Remove the rows or columns of the selection."""
        box = self._selected()
        first, end = (box.row, box.row_end) if axis == "rows" else (box.column, box.column_end)
        self.edit(lambda chart: operations.remove(chart, axis, first, end))
        self.selection = None

    def edit_text(self, text: str) -> None:
        """Take another text; the chart follows it if it can be read."""
        if text == self.text:
            return
        self.text = text
        try:
            written = parse_chart(text, self.chart.name, digits_are_weave=isinstance(self.chart, WeaveChart))
        except StitchMeshError as error:
            self._note(error)
            return
        self._step(written)

    def restore(self, text: str) -> None:
        """Return to the text of an earlier board, readable or not. This is the first state, and no step."""
        self.edit_text(text)
        self.history = UndoHistory(self.history.present)
        self.brush = Brush()
        self._settle_brush()

    def show(self, written: ChartText) -> None:
        """Show another chart, as a step, with a brush for its kind."""
        self.layer, self.selection, self.brush = None, None, Brush()
        self._step(written)

    def begin(self, kind: NewChart, rows: int, columns: int) -> None:
        """Begin a new chart, as a step: knit stitches for a brush of stitches or of yarns, or a plain weave.

        Raises:
            ParameterError: the size is refused.
        """
        check_chart_shape((rows, columns))
        if kind == "Weave":
            squares = np.add.outer(np.arange(rows), np.arange(columns)) % 2
            self.show(write_chart(WeaveChart(squares, name="New weave")))
            return
        none = np.zeros((rows, columns), dtype=np.int64)
        self.show(write_chart(KnitChart(none, (PLAIN,), none, name="New chart")))
        if kind == "Colours":
            self.yarn, self.brush = 1, Brush(yarn=1)

    def show_layer(self, layer: int | None) -> None:
        """Show one layer of a weave, or all.

        Raises:
            ParameterError: the layer has no wefts or no warps.
        """
        chart = self.chart
        if layer is not None and isinstance(chart, WeaveChart):
            chart.layer_chart(layer)
        self.layer, self.selection = layer, None

    def layers(self) -> list[int]:
        """Return the layers that have wefts and warps, for a weave of several layers."""
        chart = self.chart
        if not isinstance(chart, WeaveChart) or chart.layer_count == 1:
            return []
        wefts, warps = ({thread.layer for thread in threads} for threads in (chart.wefts, chart.warps))
        return sorted(wefts & warps)

    def undo(self) -> None:
        """Return to the chart and the text before the last step; an unreadable text is dropped first."""
        if self.text == self.history.present.text:
            self.history = self.history.undo("chart: there is no step to undo; this is its first state")
        self._return()

    def redo(self) -> None:
        """Make the last undone step again, with its chart and its text."""
        self.history = self.history.redo("chart: there is no step to redo; this is its last state")
        self._return()

    def _return(self) -> None:
        self.text = self.history.present.text
        self._stroke += 1
        self._settle()

    def _step(self, written: ChartText, what: str = "") -> None:
        most = min(max(MOST_SQUARES // written.chart.squares.size, LEAST_STEPS), MOST_STEPS)
        self.history = self.history.do(written, what, most)
        self.text = written.text
        self._settle()

    def _settle(self) -> None:
        """Adapt the selection, the layer and the brush to the chart, and check the chart."""
        if self.layer is not None and self.layer not in self.layers():
            self.layer = None
        shape = self.view.shape
        if self.selection is not None and (self.selection.row_end > shape[0] or self.selection.column_end > shape[1]):
            self.selection = None
        self._settle_brush()
        self._check(self.history.present)

    def _settle_brush(self) -> None:
        woven = isinstance(self.chart, WeaveChart)
        if (self.brush.word is None and self.brush.yarn is None) or woven != (self.brush.word in WeaveChart.words):
            self.brush = self._first_brush()

    def _first_brush(self) -> Brush:
        """Return the brush for a chart: yarns for colours, stitches for other knits, warps over wefts for a weave."""
        if isinstance(self.chart, WeaveChart):
            return Brush("0")
        coloured = self.chart.yarn_count > 1 and not (self.chart.squares != self.chart.words.index(PLAIN)).any()
        self.yarn = 1 if coloured else 0
        return Brush(yarn=self.yarn) if coloured else Brush("p")

    def _check(self, written: ChartText) -> None:
        try:
            source = written.pattern()
            if isinstance(source, Pattern):
                check_closes(source)
        except StitchMeshError as error:
            self._note(error)
        else:
            self.source, self.fault, self.fault_line = source, "", None

    def _note(self, error: StitchMeshError) -> None:
        self.fault = str(error)
        self.fault_line = error.line if isinstance(error, PatternError) else None

    def _selected(self) -> Box:
        if self.selection is None:
            raise ParameterError("chart: nothing is selected; choose the tool Select and drag over a box")
        return self.selection

    def _with_layer(self, whole: WeaveChart, part: WeaveChart) -> WeaveChart:
        assert self.layer is not None
        if part.shape != self.view.shape:
            raise ParameterError("chart of a weave: one layer keeps its size; show all layers and resize the whole")
        return whole.with_layer(self.layer, part)


def open_board(source: Source | str) -> ChartBoard:
    """Return a board with a pattern, a weave or a text.

    Raises:
        StitchMeshError: the text cannot be read, or the chart is too large.
    """
    return ChartBoard(parse_chart(source) if isinstance(source, str) else write_chart(chart_of(source)))
