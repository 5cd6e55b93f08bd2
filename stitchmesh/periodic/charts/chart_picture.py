# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A picture of a chart with its symbols, to print or to show; the PNG also holds the text of the chart.

A pattern is written as text or as the picture of its chart; ``read_pattern`` reads both.
"""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.errors import check_kind
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.mesh.palette import parse_colour
from stitchmesh.patterns import Pattern, format_pattern
from stitchmesh.patterns.charts.chart_image import TEXT_KEY
from stitchmesh.patterns.charts.chart_symbols import DOT, RING, Mark
from stitchmesh.patterns.charts.knit_chart import knit_chart
from stitchmesh.periodic.charts.chart_drawing import COVERED, ChartDrawing, draw_chart
from stitchmesh.periodic.charts.chart_files import Chart, write_chart

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw

PICTURE_SUFFIX = ".chart.png"
LONGEST_SIDE = 4000
"""Largest width and height of the squares of a picture [pixels]."""
LARGEST_SQUARE = 32
LEAST_WITH_SYMBOLS = 8
"""Smallest size of a square on which symbols are drawn [pixels]."""
DARK, LIGHT, GREY, LINE = (27, 31, 36), (255, 255, 255), (150, 150, 150), (120, 120, 120)
MARGIN = 34
"""Room for the numbers of rows and columns [pixels]."""


def chart_picture(chart: Chart) -> bytes:
    """Return a chart as a PNG with symbols, numbers of rows and columns, and the text of the chart.

    ``read_chart`` reads the chart from it again.
    """
    from PIL.Image import new
    from PIL.PngImagePlugin import PngInfo

    drawing = draw_chart(chart)
    size = max(min(LARGEST_SQUARE, LONGEST_SIDE // max(drawing.squares.shape)), 1)
    rows, columns = drawing.squares.shape
    image = new("RGB", (columns * size + 2 * MARGIN, rows * size + 2 * MARGIN), LIGHT)
    _Painter(drawing, size, image).paint()
    held = PngInfo()
    held.add_itxt(TEXT_KEY, write_chart(chart).text)
    content = BytesIO()
    image.save(content, format="PNG", pnginfo=held)
    return content.getvalue()


class _Painter:
    """Draws a chart square by square."""

    def __init__(self, drawing: ChartDrawing, size: int, image: Image) -> None:
        from PIL.ImageDraw import Draw

        self.drawing, self.size, self.image, self.draw = drawing, size, image, Draw(image)
        self.papers = [tuple(parse_colour(colour).tolist()) for colour in drawing.colours]
        self.symbols = drawing.symbols
        self.tiles: dict[tuple[int, int], Image] = {}

    def paint(self) -> None:
        """Draw squares, lines, symbols and numbers."""
        rows, columns = self.drawing.squares.shape
        for row in range(rows):
            for column in range(columns):
                self._square(row, column)
        if self.size >= LEAST_WITH_SYMBOLS:
            for row, column in np.argwhere(self.drawing.squares != COVERED).tolist():
                self._symbol(row, column)
        self._numbers(rows, columns)

    def _corner(self, row: int, column: int) -> tuple[int, int]:
        """Return the upper left corner of a square."""
        rows = self.drawing.squares.shape[0]
        line = rows - 1 - row if self.drawing.upwards else row
        return MARGIN + column * self.size, MARGIN + line * self.size

    def _square(self, row: int, column: int) -> None:
        x, y = self._corner(row, column)
        line = LINE if self.size >= LEAST_WITH_SYMBOLS else None
        paper = self.papers[self.drawing.fills[row, column]]
        self.draw.rectangle((x, y, x + self.size, y + self.size), fill=paper, outline=line)

    def _symbol(self, row: int, column: int) -> None:
        number, fill = int(self.drawing.squares[row, column]), int(self.drawing.fills[row, column])
        if self.symbols[number].marks:
            x, y = self._corner(row, column)
            self.image.paste(self._tile(number, fill), (x + 1, y + 1))

    def _tile(self, number: int, fill: int) -> Image:
        """Return a symbol on a tile of its own, so that the symbol stays inside its squares."""
        from PIL.Image import new
        from PIL.ImageDraw import Draw

        if (number, fill) not in self.tiles:
            symbol, paper = self.symbols[number], self.papers[fill]
            tile = new("RGB", (symbol.columns * self.size - 1, self.size - 1), paper)
            for mark in symbol.marks:
                self._mark(Draw(tile), mark, paper)
            self.tiles[number, fill] = tile
        return self.tiles[number, fill]

    def _mark(self, draw: ImageDraw, mark: Mark, paper: tuple[int, ...]) -> None:
        size, ink = self.size, _ink(paper)
        points = [(across * size, (1.0 - up) * size) for across, up in mark.points]
        if mark.kind == "shade":
            draw.rectangle((0, 0, size, size), fill=GREY)
        elif mark.kind == "strand":
            for colour, width in ((paper, 0.5), (ink, 0.34), (paper, 0.2)):
                draw.line(points, fill=colour, width=max(round(width * size), 1))
        elif mark.kind == "line":
            draw.line(points, fill=ink, width=max(round(0.08 * size), 1), joint="curve")
        else:
            (x, y), radius = points[0], (RING if mark.kind == "ring" else 1.2 * DOT) * size
            paint = ink if mark.kind == "dot" else None
            box = (x - radius, y - radius, x + radius, y + radius)
            draw.ellipse(box, fill=paint, outline=ink, width=max(round(size / 12), 1))

    def _numbers(self, rows: int, columns: int) -> None:
        """Number the rows at the right and the columns below, so that the numbers do not touch."""
        every = next(step for step in (1, 2, 5, 10, 50, 100) if step * self.size >= 14)
        for row in range(rows):
            if (row + 1) % every == 0 or row == 0:
                x, y = self._corner(row, columns)
                self.draw.text((x + 5, y + self.size / 2), str(row + 1), fill=DARK, anchor="lm")
        lowest = 0 if self.drawing.upwards else rows - 1
        every = next(step for step in (1, 2, 5, 10, 50, 100) if step * self.size >= 24)
        for column in range(columns):
            if (column + 1) % every == 0 or column == 0:
                x, y = self._corner(lowest, column)
                self.draw.text((x + self.size / 2, y + self.size + 4), str(column + 1), fill=DARK, anchor="ma")


def _ink(paper: tuple[int, ...]) -> tuple[int, int, int]:
    """Return the colour of symbols that can be seen on a paper."""
    return DARK if 0.299 * paper[0] + 0.587 * paper[1] + 0.114 * paper[2] > 140 else LIGHT


PATTERN_TEXT, PATTERN_PICTURE = ".knit", ".png"


def pattern_content(pattern: Pattern, suffix: str) -> bytes:
    """Return the content of the file of a pattern.

    Args:
        pattern: the pattern.
        suffix: ``.knit`` for text, or ``.png`` for a picture of its chart, which holds the text too.

    Raises:
        ParameterError: the chart is larger than ``grid.LONGEST_SIDE``.
    """
    return format_pattern(pattern).encode() if suffix == PATTERN_TEXT else chart_picture(knit_chart(pattern))


def write_pattern(path: FilePath, pattern: Pattern) -> None:
    """Write a pattern as text (``.knit``), or as the picture of its chart with its text (``.png``).

    ``read_pattern`` reads both. The file is written atomically.

    Raises:
        FileError: the file has another suffix, or it cannot be written.
        ParameterError: the chart is larger than ``grid.LONGEST_SIDE``.
    """
    check_kind("write_pattern", pattern, Pattern)
    write_bytes(path, pattern_content(pattern, suffix_of(path, (PATTERN_TEXT, PATTERN_PICTURE))))
