# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knitting charts of the editor as text, and back; both know the line of each row.

A chart is written in the shortest kind of text that can hold it: yarn numbers, letters, or words.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stitchmesh.mesh.palette import colour_text
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns.charts.grid import check_chart_shape
from stitchmesh.patterns.charts.knit_chart import COVERED, PLAIN, KnitChart, chart_of_written, knit_chart
from stitchmesh.patterns.language.parse import WrittenPattern, begins_with_statement, parse_written
from stitchmesh.patterns.language.rows import DescribedRow, finish_rows
from stitchmesh.patterns.language.text_charts import FIGURES, LETTERS, bare_chart_name, bare_chart_rows, holds_digits
from stitchmesh.patterns.language.tokens import TextPlace
from stitchmesh.patterns.language.writing import chart_word
from stitchmesh.patterns.pattern import Pattern

SIGNS = {word: sign for sign, word in LETTERS.items()}
"""Sign of each word in a chart of letters."""


@dataclass(frozen=True, eq=False)
class KnitChartText:
    """A chart with its text."""

    text: str
    chart: KnitChart
    places: tuple[TextPlace, ...]
    """Place of each row of the chart in the text, the lowest row first."""

    def pattern(self) -> Pattern:
        """Return the pattern of the chart.

        Raises:
            PatternError: the rows do not fit together; the message gives the line and the column.
        """
        return self.chart.pattern(self.places)


def write_knit_chart(chart: KnitChart) -> KnitChartText:
    """Write a chart as text that ``parse_knit_chart`` reads."""
    head = [f'pattern "{chart.name}"', f'source "{chart.source}"']
    if chart.palette:
        head.append(f'colours "{", ".join(map(colour_text, chart.palette))}"')
    kind, rows = _written_rows(chart)
    text = "\n".join([*head, f"chart{kind}:", *rows[::-1]]) + "\n"
    last = len(head) + 1 + len(rows)
    return KnitChartText(text, chart, tuple(TextPlace(chart.name, last - row, 1) for row in range(len(rows))))


def parse_knit_chart(text: str, name: str = "pattern") -> KnitChartText:
    """Read a chart from a text, whether or not its rows fit together.

    Args:
        text: a text in the language of ``docs/patterns.md``, or lines of tile codes or of yarn numbers alone.
        name: the name of the text in messages, and the name of the chart if the text gives none.

    Raises:
        PatternError: a word or a statement cannot be read; the message gives the line and the column.
        ParameterError: the chart is larger than ``grid.LONGEST_SIDE``.
    """
    written = _read(text, name)
    places = tuple(row.place for row in written.rows)
    # a short text can describe more stitches than the memory holds
    check_chart_shape((len(written.rows), max(len(row.pieces) for row in written.rows)))
    if _has_turned_tuck(written.rows):  # no word of a chart describes a tuck that was worked on the wrong side
        rows = finish_rows(written.rows)
        chart = knit_chart(Pattern(written.name, written.source, rows, written.palette))
    else:
        chart = chart_of_written(written.rows, written.name, written.source, written.palette)
    return KnitChartText(text, chart, places)


def _read(text: str, name: str) -> WrittenPattern:
    if begins_with_statement(text) or not text.strip():
        return parse_written(text, name)
    kind = "colours" if holds_digits(text) else "leaf"
    return WrittenPattern(bare_chart_name(name), "", (), tuple(bare_chart_rows(kind, text, name)))


def _has_turned_tuck(rows: tuple[DescribedRow, ...]) -> bool:
    return any(piece.tuck and piece.cells[0].stitch == Stitch.YS for row in rows for piece in row.pieces)


def _written_rows(chart: KnitChart) -> tuple[str, list[str]]:
    """Return the kind of the chart and its rows as text, the lowest row first."""
    used = {chart.words[number] for number in np.unique(chart.squares) if number != COVERED}
    yarns = np.unique(chart.yarns)
    if used == {PLAIN} and len(yarns) > 1 and yarns[-1] < len(FIGURES):
        return " colours", _signs(chart, np.array(list(FIGURES))[chart.yarns])
    if used <= set(SIGNS) and len(yarns) == 1:
        yarn = f" yarn {yarns[0]}" if yarns[0] else ""
        return f" letters{yarn}", _signs(chart, np.array([SIGNS.get(word, " ") for word in chart.words])[chart.squares])
    return "", _aligned([_words(chart, row) for row in range(chart.shape[0])], chart)


def _signs(chart: KnitChart, signs: np.ndarray) -> list[str]:
    """Return rows of one sign for each square, with the bars of the borders."""
    limits = [0, *_limits(chart), chart.shape[1]]
    rows = ["".join(row) for row in signs.tolist()]
    return ["|".join(row[start:end] for start, end in pairwise(limits)) for row in rows]


def _limits(chart: KnitChart) -> list[int]:
    return [chart.left, chart.shape[1] - chart.right] if chart.left or chart.right else []


def _words(chart: KnitChart, row: int) -> list[tuple[int, str]]:
    """Return the first column and the word of each stitch of a row."""
    starts = np.flatnonzero(chart.squares[row] != COVERED).tolist()
    return [(start, chart_word(piece)) for start, piece in zip(starts, chart.pieces(row), strict=True)]


def _aligned(rows: list[list[tuple[int, str]]], chart: KnitChart) -> list[str]:
    """Return rows of words with the columns of the chart below one another."""
    room = np.ones(chart.shape[1] + 1, dtype=np.int64)
    for row in rows:
        ends = [*(start for start, _ in row[1:]), chart.shape[1]]
        for (start, word), end in zip(row, ends, strict=True):
            each = -(-(len(word) + 1) // (end - start))
            room[start:end] = np.maximum(room[start:end], each)
    limits = set(_limits(chart))
    room[list(limits)] += 2
    at = np.concatenate([[0], np.cumsum(room)])
    return [_placed(row, at, limits, chart.shape[1]) for row in rows]


def _placed(row: list[tuple[int, str]], at: np.ndarray, limits: set[int], end: int) -> str:
    """Return the words of a row, each at the place of its column, and a bar before each column in ``limits``."""
    line = ""
    for start, word in row:
        bar = "| " if start in limits else ""
        line = line.ljust(int(at[start])) + bar + word
    return f"{line} |" if end in limits else line
