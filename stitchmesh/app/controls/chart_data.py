# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The drawing of a chart for the script in the browser: values that JSON can hold, in hidden elements."""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.markup import Markup, joined, markup
from stitchmesh.patterns.charts.chart_symbols import Symbol
from stitchmesh.periodic.charts.chart_drawing import ChartDrawing


def base_values(drawing: ChartDrawing, version: int) -> dict[str, Any]:
    """Return a whole drawing as values that JSON can hold."""
    return {
        "version": version, "rows": drawing.squares.shape[0], "columns": drawing.squares.shape[1],
        "squares": _text(drawing.squares), "fills": _text(drawing.fills), "words": drawing.words,
        "symbols": [_symbol(symbol) for symbol in drawing.symbols], "colours": drawing.colours,
        "upwards": drawing.upwards, "left": drawing.left, "right": drawing.right,
        "wefts": drawing.wefts, "warps": drawing.warps,
    }  # fmt: skip


def data_element(name: str, chart: str, values: dict[str, Any]) -> Markup:
    """Return a hidden element of HTML that holds values for the script of the chart."""
    text = json.dumps(values, separators=(",", ":"))
    return markup('<div hidden data-chart-{}="{}" data-json="{}"></div>', name, chart, text)


def symbol_svg(symbol: Symbol, fill: str = "none", size: int = 22) -> Markup:
    """Return a symbol as a picture of SVG, in the colour of the text around it."""
    parts = []
    for mark in symbol.marks:
        points = " ".join(f"{20 * x:.1f},{20 - 20 * y:.1f}" for x, y in mark.points)
        x, y = points.split(" ")[0].split(",") if points else ("0", "0")
        parts.append({
            "line": markup('<polyline points="{}" class="sm-line"/>', points),
            "strand": markup(
                '<polyline points="{}" class="sm-under"/><polyline points="{}" class="sm-strand"/>',
                points, points,
            ),
            "ring": markup('<circle cx="{}" cy="{}" r="4" class="sm-line"/>', x, y),
            "dot": markup('<circle cx="{}" cy="{}" r="2.4" class="sm-dot"/>', x, y),
            "shade": markup('<rect width="20" height="20" class="sm-shade"/>'),
        }[mark.kind])  # fmt: skip
    width = 20 * symbol.columns
    shown = size * (1.0 + 0.35 * (symbol.columns - 1))
    drawing = joined(parts)
    return markup(
        '<svg viewBox="0 0 {} 20" width="{}" height="{}" preserveAspectRatio="none" '
        'aria-hidden="true" style="background:{}">{}</svg>',
        width, f"{shown:g}", size, fill, drawing,
    )


def _symbol(symbol: Symbol) -> list[Any]:
    return [symbol.columns, [[mark.kind, [value for point in mark.points for value in point]] for mark in symbol.marks]]


def _text(array: NDArray[np.uint16]) -> str:
    return base64.b64encode(array.astype("<u2").tobytes()).decode("ascii")
