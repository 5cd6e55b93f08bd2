# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A pattern to take home: a PDF with a picture, the finished measures, the yarn, charts and written instructions.

The pages are A4. Matplotlib draws them, with text that can be searched; the same pattern gives the same bytes.
"""

from __future__ import annotations

import logging
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting.chart import PieceChart, piece_charts
from stitchmesh.hand_knitting.pieces import Piece, find_pieces
from stitchmesh.hand_knitting.rows import CableCrossings
from stitchmesh.hand_knitting.text import knitting_instructions
from stitchmesh.hand_knitting.yarn_amounts import YarnAmount, yarn_amounts, yarn_lengths
from stitchmesh.io.atomic import atomic_path
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.mesh import TOP, FloatArray, StitchMesh
from stitchmesh.patterns import Pattern, pattern_mesh
from stitchmesh.patterns.charts.chart_symbols import word_instruction
from stitchmesh.periodic.charts.chart_drawing import draw_chart
from stitchmesh.periodic.charts.chart_files import chart_of, write_chart
from stitchmesh.periodic.charts.chart_picture import LARGEST_SQUARE as CHART_SQUARE
from stitchmesh.periodic.charts.chart_picture import chart_picture
from stitchmesh.periodic.resolve_pattern import Source
from stitchmesh.render.plots.plot_file import own_settings
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.stitch_size import fabric_gauge
from stitchmesh.yarn.yarn_presets import CENTIMETRES_PER_INCH, Gauge, Yarn, yarn_for_gauge

if TYPE_CHECKING:
    from matplotlib.backends.backend_pdf import PdfPages

SUFFIX = ".pdf"
PAGE = (8.27, 11.69)
"""Width and height of A4 [inch]."""
MARGIN = 0.75
"""Margin around a page [inch]."""
POINTS = 72.0
"""Points in an inch."""
LINE_CHARACTERS = 96
"""Characters of a line of text; 9 points of DejaVu Sans are 5.1 points wide on average, and the page has 487."""
LARGEST_SQUARE, SMALLEST_SQUARE = 0.2, 0.03
"""Bounds of the width of a square of a chart [inch]; a chart that is too wide for the smallest square is written as
text only."""
LINE_HEIGHT = 1.35 * 9.0 / POINTS
"""Height of a line of text [inch]."""
INK, LINE = "#26241f", "#b9b3a6"


@dataclass(frozen=True)
class ChartPicture:
    """A chart that is already a picture."""

    title: str
    png: bytes
    legend: tuple[tuple[str, str], ...]
    """Words of the chart, each with its meaning."""


@dataclass(frozen=True)
class PatternSheet:
    """The content of a pattern to take home."""

    title: str
    picture: bytes | None
    """A PNG; None for no picture."""
    facts: tuple[tuple[str, str], ...]
    """Names and values of measures, gauge, needle and yarn."""
    amounts: tuple[YarnAmount, ...]
    charts: tuple[PieceChart | ChartPicture, ...]
    text: str
    """The written instructions."""


def garment_sheet(
    fabric: StitchMesh, yarns: YarnSet | None = None, *, title: str, yarn: Yarn | None = None,
    picture: bytes | None = None,
) -> PatternSheet:  # fmt: skip
    """Return the pattern of a garment.

    Args:
        fabric: the stitch mesh after mesh relaxation, so that its lengths are the lengths of the garment.
        yarns: its yarns; without them the lengths follow from the loop length at the gauge.
        title: name of the garment.
        yarn: the yarn that the user has named; by default the named yarn that is usual at the gauge.
        picture: a PNG.

    Raises:
        ParameterError, LabelError: an error of ``knitting_instructions``.
    """
    gauge = fabric_gauge(fabric)
    known = yarn or yarn_for_gauge(gauge)
    pieces, crossings = find_pieces(fabric), CableCrossings.of(fabric)
    facts = [("Finished size", _finished_size(np.ptp(fabric.vertices, axis=0), gauge))]
    facts += [(f"Piece {number}", _piece_size(fabric, piece)) for number, piece in enumerate(pieces, start=1)]
    facts += [*_knitted_at(gauge, known), ("Stitches", f"{fabric.face_count:,} in {len(np.unique(fabric.row)):,} rows")]
    lengths = _loop_lengths(fabric, gauge) if yarns is None else yarn_lengths(yarns)
    return PatternSheet(
        title=title,
        picture=picture,
        facts=tuple(facts),
        amounts=yarn_amounts(lengths, fabric.palette, known.grams_per_metre),
        charts=tuple(chart for piece in pieces for chart in piece_charts(fabric, piece, crossings)),
        text=knitting_instructions(fabric, charts=False),
    )


def swatch_sheet(
    source: Source, yarns: YarnSet, gauge: Gauge, *, yarn: Yarn | None = None, picture: bytes | None = None
) -> PatternSheet:
    """Return the pattern of one repeat of a swatch.

    Args:
        source: the pattern or the weave.
        yarns: the relaxed yarns of one repeat on their lattice.
        gauge: stitches and rows in 10 cm of the swatch.
        yarn: the yarn that the user has named; by default the named yarn that is usual at the gauge.
        picture: a PNG.
    """
    assert yarns.lattice is not None
    known, chart = yarn or yarn_for_gauge(gauge), chart_of(source)
    counts = (source.width, source.height) if isinstance(source, Pattern) else (len(source.warps), len(source.wefts))
    size = [float(np.linalg.norm(period)) for period in yarns.lattice.periods]
    words = draw_chart(chart).words if isinstance(source, Pattern) else ()
    return PatternSheet(
        title=source.name or "Swatch",
        picture=picture,
        facts=(
            ("One repeat", f"{counts[0]} stitches by {counts[1]} rows, {_size(size)}"),
            *_knitted_at(gauge, known),
            ("Yarn below", "for one repeat"),
        ),
        amounts=yarn_amounts(yarn_lengths(yarns), yarns.palette, known.grams_per_metre),
        charts=(ChartPicture("Chart", chart_picture(chart), tuple((word, word_instruction(word)) for word in words)),),
        text=written_repeat(source, gauge),
    )


def written_repeat(source: Source, gauge: Gauge) -> str:
    """Return the rows of one repeat in words, or the text of the chart for a weave or rows that do not close.

    Args:
        source: the pattern or the weave.
        gauge: stitches and rows in 10 cm, with which the instructions begin.
    """
    if not isinstance(source, Pattern) or not source.closes:
        return write_chart(chart_of(source)).text
    width, height = gauge.stitch_width, gauge.stitch_height
    return knitting_instructions(pattern_mesh(source, stitch_width=width, stitch_height=height), charts=False)


def write_pattern_sheet(path: FilePath, sheet: PatternSheet) -> None:
    """Write a pattern as a PDF; the file is written atomically.

    Raises:
        FileError: the suffix is not ``.pdf``, or the file cannot be written.
        ParameterError: the picture is no PNG.
    """
    from matplotlib.backends.backend_pdf import PdfPages

    suffix_of(path, (SUFFIX,))
    with own_settings(), atomic_path(path) as temporary:
        import matplotlib

        matplotlib.rcParams["pdf.fonttype"] = 42  # Text in an embedded font can be searched and copied.
        logging.getLogger("fontTools").setLevel(logging.WARNING)  # It would report every glyph that it embeds.
        facts = {"Title": sheet.title, "Creator": "StitchMesh", "CreationDate": None}
        with PdfPages(temporary, metadata=facts) as pages:
            paper = _Paper(pages)
            _write(paper, sheet)


def _size(lengths: list[float]) -> str:
    """Return lengths [cm] in centimetres and inches."""
    metric = " x ".join(f"{length:.3g}" for length in lengths)
    imperial = " x ".join(f"{length / CENTIMETRES_PER_INCH:.3g}" for length in lengths)
    return f"{metric} cm ({imperial} in)"


def _finished_size(extents: FloatArray, gauge: Gauge) -> str:
    """Return the extents of a garment along its axes; a flat piece is no thicker than a stitch is wide."""
    names = "wide", "high", "deep"
    return ", ".join(
        f"{_size([extent])} {name}"
        for extent, name in zip(extents.tolist(), names, strict=True)
        if extent > gauge.stitch_width
    )


def _piece_size(fabric: StitchMesh, piece: Piece) -> str:
    """Return the widths of a piece and its height, which is the sum of the mean heights of its rows."""
    width, height = [], []
    for row in piece.rows:
        sides = fabric.sides_of(np.array(row.faces))
        width.append(float(fabric.side_length[sides[fabric.side_role[sides] == TOP]].sum()))
        height.append(float(fabric.side_length[sides[fabric.is_wale[sides]]].mean()))
    around = "around" if piece.in_rounds else "wide"
    widths = f"{_size([width[0]])} {around} at the first row, {_size([max(width)])} at most"
    return f"{widths}, {_size([sum(height)])} high"


def _knitted_at(gauge: Gauge, yarn: Yarn) -> list[tuple[str, str]]:
    needle = f"{yarn.needle[0]:g} to {yarn.needle[1]:g} mm, or the size that gives the gauge"
    return [("Gauge", str(gauge)), ("Yarn", f"{yarn.name}, {100.0 / yarn.grams_per_metre:.0f} m in 100 g"),
            ("Needle", needle)]  # fmt: skip


def _loop_lengths(fabric: StitchMesh, gauge: Gauge) -> dict[int, float]:
    """Return the length of each yarn number of a fabric whose yarns are not known [cm]."""
    numbers, counts = np.unique(fabric.yarn, return_counts=True)
    return dict(zip(numbers.tolist(), (gauge.loop_length * counts).tolist(), strict=True))


def _write(paper: _Paper, sheet: PatternSheet) -> None:
    """Write title, picture, facts and yarns, then the charts; the text follows on pages of its own."""
    paper.text(sheet.title, size=20.0)
    paper.space(0.1)
    if sheet.picture is not None:
        paper.picture(sheet.picture, height=4.2)
    for name, value in sheet.facts:
        paper.text(f"{name}: {value}", size=10.0)
    paper.space(0.1)
    for amount in sheet.amounts:
        paper.swatch_of_colour(amount.colour)
        paper.text(f"      Yarn {amount.letter} ({amount.colour}): {amount.metres:,.3g} m, about {amount.grams:,.2g} g",
                   size=10.0)  # fmt: skip
    paper.space(0.3)
    for chart in sheet.charts:
        paper.chart(chart, {one.letter: one.colour for one in sheet.amounts})
    paper.written(sheet.text.splitlines())
    paper.finish()


def _folded(line: str, width: int) -> list[str]:
    """Return a line in pieces of at most ``width`` characters; later pieces are indented."""
    indent = " " * (len(line) - len(line.lstrip()) + 2)
    return textwrap.wrap(line, width, subsequent_indent=indent, replace_whitespace=False) or [""]


class _Paper:
    """Pages that are filled from the top down."""

    def __init__(self, pages: PdfPages) -> None:
        self._pages = pages
        self._begin()

    def _begin(self) -> None:
        from matplotlib.figure import Figure

        self._figure = Figure(figsize=PAGE)
        self._y = PAGE[1] - MARGIN  # height of the free room above the lower edge [inch]
        self._empty = True
        self._explained: set[tuple[str, str]] = set()  # entries of legends on the page

    def turn(self) -> None:
        """Begin a page, unless the present one is empty."""
        if not self._empty:
            self._pages.savefig(self._figure)
            self._begin()

    def finish(self) -> None:
        """Write the last page."""
        self._pages.savefig(self._figure)

    def space(self, height: float) -> None:
        """Leave room [inch]."""
        self._y -= height

    def written(self, lines: list[str]) -> None:
        """Write a text: on the present page if all of it fits there, otherwise on pages of its own."""
        folded = sum(len(_folded(line, LINE_CHARACTERS)) for line in lines)
        if self._y - (folded + 1) * LINE_HEIGHT < MARGIN:
            self.turn()
        for line in lines:
            self.text(line)

    def text(self, line: str, size: float = 9.0) -> None:
        """Write a line of text, folded to the width of the page."""
        for part in _folded(line, int(LINE_CHARACTERS * 9.0 / size)):
            self._make_room(1.35 * size / POINTS)
            self._y -= 1.35 * size / POINTS
            # A dollar sign would begin a formula.
            self._figure.text(MARGIN / PAGE[0], self._y / PAGE[1], part, fontsize=size, color=INK, parse_math=False)
            self._empty = False

    def swatch_of_colour(self, colour: str) -> None:
        """Draw a square of a colour at the place of the next line."""
        from matplotlib.patches import Rectangle

        self._make_room(0.2)
        corner = MARGIN / PAGE[0], (self._y - 0.2) / PAGE[1]
        self._figure.add_artist(Rectangle(corner, 0.16 / PAGE[0], 0.14 / PAGE[1], facecolor=colour, edgecolor=LINE))

    def picture(self, png: bytes, height: float) -> None:
        """Show a picture over the width of the page, at most ``height`` [inch] high."""
        from PIL import Image, UnidentifiedImageError

        try:
            pixels = np.asarray(Image.open(BytesIO(png), formats=["PNG"]).convert("RGB"))
        except (UnidentifiedImageError, OSError) as error:
            raise ParameterError(f"picture: is not a whole PNG ({error}); expected a PNG") from error
        width = PAGE[0] - 2 * MARGIN
        scale = min(width / pixels.shape[1], height / pixels.shape[0])
        across, high = scale * pixels.shape[1], scale * pixels.shape[0]
        self._make_room(high)
        self._y -= high
        axes = self._figure.add_axes((MARGIN / PAGE[0], self._y / PAGE[1], across / PAGE[0], high / PAGE[1]))
        axes.imshow(pixels, aspect="auto", interpolation="antialiased")
        axes.set_axis_off()
        self._y -= 0.15
        self._empty = False

    def chart(self, chart: PieceChart | ChartPicture, colours: dict[str, str]) -> None:
        """Draw a chart with its title and its legend on one page, where it fits."""
        from PIL import Image

        if isinstance(chart, ChartPicture):
            below = 0.5 + LINE_HEIGHT * len(chart.legend)
            largest = Image.open(BytesIO(chart.png)).height * LARGEST_SQUARE / CHART_SQUARE
            height = min(largest, PAGE[1] - 2 * MARGIN - 0.5 - below)
            self._make_room(height + below)
            self.text(chart.title, size=10.0)
            self.picture(chart.png, height)
            self._legend(chart.legend, ": ")
            return
        rows, columns = len(chart.symbols), len(chart.symbols[0])
        room = PAGE[0] - 2 * MARGIN - 0.7, PAGE[1] - 2 * MARGIN - 0.6 - 0.2 * len(chart.legend)
        square = min(LARGEST_SQUARE, room[0] / columns, room[1] / rows)
        if square < SMALLEST_SQUARE:
            return
        self._make_room(rows * square + 0.6 + 0.2 * len(chart.legend))
        self.text(chart.title, size=10.0)
        self._squares(chart, square, colours)
        self._legend(chart.legend, "  ")
        self.space(0.2)

    def _legend(self, legend: Sequence[tuple[str, str]], between: str) -> None:
        """Write the entries of a legend that the page has not explained yet."""
        for symbol, meaning in legend:
            if (symbol, meaning) not in self._explained:
                self.text(f"{symbol}{between}{meaning}")
                self._explained.add((symbol, meaning))

    def _squares(self, chart: PieceChart, square: float, colours: dict[str, str]) -> None:
        """Draw the squares of a chart, the symbols of stitches on them, and the numbers of rows where they begin."""
        rows, columns = len(chart.symbols), len(chart.symbols[0])
        self._y -= rows * square + 0.08
        bounds = (MARGIN + 0.35) / PAGE[0], self._y / PAGE[1], columns * square / PAGE[0], rows * square / PAGE[1]
        axes = self._figure.add_axes(bounds, xlim=(0, columns), ylim=(0, rows))
        axes.set_xticks(range(columns + 1), labels=[])
        axes.set_yticks(range(rows + 1), labels=[])
        axes.grid(True, color=LINE, linewidth=0.4)
        axes.tick_params(length=0)
        size = POINTS * square * 0.62
        if chart.what == "colours":
            papers = sorted({symbol for row in chart.symbols for symbol in row})
            from matplotlib.colors import ListedColormap

            number = np.array([[papers.index(symbol) for symbol in row] for row in chart.symbols])
            shades = ListedColormap([colours.get(letter, "#ffffff") for letter in papers])
            axes.pcolormesh(number, cmap=shades, vmin=-0.5, vmax=len(papers) - 0.5, edgecolors=LINE, linewidth=0.4)
        else:
            for height, symbols in enumerate(chart.symbols):
                for column, symbol in enumerate(symbols):
                    axes.text(column + 0.5, height + 0.5, symbol, fontsize=size, ha="center", va="center", color=INK,
                              parse_math=False)  # fmt: skip
        for height, (count, right) in enumerate(zip(chart.rows, chart.from_right, strict=True)):
            place, side = (columns + 0.3, "left") if right else (-0.3, "right")
            axes.text(place, height + 0.5, str(count), fontsize=min(size, 7.0), ha=side, va="center", color=INK)
        self._y -= 0.1
        self._empty = False

    def _make_room(self, height: float) -> None:
        """Begin a page if the present one has less free height [inch]."""
        if self._y - height < MARGIN:
            self.turn()
