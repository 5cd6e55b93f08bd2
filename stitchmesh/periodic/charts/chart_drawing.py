# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A chart as symbols on coloured squares, and the squares that differ between two drawings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh.palette import LAST_YARN, colour_text, filled_palette
from stitchmesh.patterns.charts.chart_symbols import WARP_OVER, WEFT_OVER, Symbol, chart_symbol
from stitchmesh.patterns.charts.knit_chart import KnitChart
from stitchmesh.periodic.charts.chart_files import Chart
from stitchmesh.periodic.weave.weave_chart import WeaveChart

COVERED = 65535
"""Number of a square that is covered by the cable on its left."""
MOST_CHANGES = 4000
"""Largest number of squares that are listed as changes."""


@dataclass(frozen=True, eq=False)
class ChartDrawing:
    """A chart as symbols on coloured squares."""

    squares: NDArray[np.uint16]
    """Number of the symbol of each square, or ``COVERED``, shape (rows, columns)."""
    fills: NDArray[np.uint16]
    """Number of the colour of each square, shape (rows, columns)."""
    words: tuple[str, ...]
    """The word of each symbol."""
    colours: tuple[str, ...]
    """Colours as ``#rrggbb``."""
    upwards: bool
    """Whether the first row stands at the bottom."""
    left: int = 0
    right: int = 0
    wefts: tuple[tuple[int, int], ...] = ()
    """Colour and layer of each weft; empty for a knit."""
    warps: tuple[tuple[int, int], ...] = ()
    """Colour and layer of each warp."""

    def changes_from(self, base: ChartDrawing) -> list[int] | None:
        """Return the index, the symbol and the colour of every square that differs from a base.

        Args:
            base: an earlier drawing.

        Returns:
            Three numbers for each square, one square after another; None if the drawings differ in more than squares,
            or in more than ``MOST_CHANGES`` squares.
        """
        frames = [(d.squares.shape, d.words, d.colours, d.left, d.right, d.wefts, d.warps) for d in (self, base)]
        if frames[0] != frames[1]:
            return None
        changed = np.flatnonzero((self.squares != base.squares) | (self.fills != base.fills))
        if len(changed) > MOST_CHANGES:
            return None
        return np.stack([changed, self.squares.flat[changed], self.fills.flat[changed]], axis=-1).ravel().tolist()

    @property
    def symbols(self) -> tuple[Symbol, ...]:
        """The symbol of each word."""
        return (WARP_OVER, WEFT_OVER) if self.warps else tuple(chart_symbol(word) for word in self.words)


def draw_chart(chart: Chart, words: Sequence[str] = (), yarns: int = 1) -> ChartDrawing:
    """Return the drawing of a chart.

    Args:
        chart: the chart.
        words: further words that need symbols, because a user can paint them next.
        yarns: the smallest number of yarns that have a colour.
    """
    return _draw_weave(chart, yarns) if isinstance(chart, WeaveChart) else _draw_knit(chart, words, yarns)


def palette_of(chart: Chart, count: int) -> tuple[str, ...]:
    """Return the colours of the yarns of a chart as ``#rrggbb``: all that are in use, and at least ``count``."""
    own = np.array(chart.palette, dtype=np.uint8).reshape(-1, 3)
    colours = filled_palette(own, max(min(chart.yarn_count, LAST_YARN + 1), count))
    return tuple(colour_text(colour) for colour in colours)


def _draw_knit(chart: KnitChart, words: Sequence[str], yarns: int) -> ChartDrawing:
    every = (*chart.words, *(word for word in words if word not in chart.words))
    squares = np.where(chart.squares < 0, COVERED, chart.squares).astype(np.uint16)
    fills = np.minimum(chart.yarns, LAST_YARN).astype(np.uint16)
    return ChartDrawing(squares, fills, every, palette_of(chart, yarns), True, chart.left, chart.right)


def _draw_weave(chart: WeaveChart, yarns: int) -> ChartDrawing:
    kinds = chart.wefts, chart.warps
    threads = [[(min(thread.colour, LAST_YARN), thread.layer) for thread in kind] for kind in kinds]
    colours = palette_of(chart, yarns)
    if chart.yarn_count == 1 and len(chart.palette) < 2:
        threads = [[(index, layer) for _, layer in kind] for index, kind in enumerate(threads)]
        # Colours of wefts and warps in a weave of one colour: light and dark, as on the point paper of weavers.
        colours = ("#f3ead8", "#3d4f63")
    weft, warp = (np.array([colour for colour, _ in kind]) for kind in threads)
    fills = np.where(chart.squares == 1, weft[:, None], warp[None, :]).astype(np.uint16)
    squares = chart.squares.astype(np.uint16)
    wefts, warps = (tuple(kind) for kind in threads)
    return ChartDrawing(squares, fills, chart.words, colours, False, wefts=wefts, warps=warps)
