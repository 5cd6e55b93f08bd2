# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A chart as HTML: its drawing for the script in the browser, and the buttons beside it."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.app.controls.html_pieces import action_button
from stitchmesh.hand_knitting.words import NAMED
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh.stitch import CODES
from stitchmesh.patterns.charts.chart_symbols import WARP_OVER, WEFT_OVER, Symbol, chart_symbol, word_instruction
from stitchmesh.periodic.charts.chart_drawing import ChartDrawing, palette_of
from stitchmesh.periodic.charts.chart_files import Chart
from stitchmesh.periodic.weave.weave_chart import WeaveChart


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


TOOLS = {
    "Paint": "Paint squares: press and drag (key P)",
    "Fill": "Fill equal squares that touch (key F)",
    "Box": "Paint all squares of a box: drag from corner to corner (key B)",
    "Select": "Select a box: drag; drag the selection to move it, with Alt to copy it (key S)",
}
"""Tools and their hints."""
STITCHES = (
    "k", "p", "yo", "k2tog", "ssk", "s2kp", "p2tog", "ktbl", "b", "f", "t", "kfb", "none",
    "1/1lc", "1/1rc", "c4f", "c4b", "c6f", "c6b", "t3f", "t3b",
)  # fmt: skip
"""Words in the palette of a knit; a text field takes all other words."""
_STYLE = (
    "border:2px solid {edge};border-radius:4px;padding:1px;margin:0 3px 3px 0;min-width:28px;min-height:28px;"
    "cursor:pointer;vertical-align:middle;font:12px sans-serif;{more}"
)
_RAISED = '<span style="vertical-align:super">{}</span>'
_PLAIN = "background:#fbfaf7;color:#1b1f24;"

_WORD = _PLAIN + "padding:1px 7px;"


def tool_buttons(chosen: str, *, can_undo: bool, can_redo: bool) -> Markup:
    """Return the buttons of the tools, and of undo and redo."""
    buttons = [
        _button("tool", name, hint, name, _WORD, pressed=name == chosen) for name, hint in TOOLS.items()
    ]
    buttons.append(markup('<span style="display:inline-block;width:8px"></span>'))
    buttons.append(_button("undo", "", "Undo the last step (Ctrl+Z)", "Undo", _WORD, disabled=not can_undo))
    buttons.append(_button("redo", "", "Redo the step that was undone (Ctrl+Y)", "Redo", _WORD, disabled=not can_redo))
    return _group("Tools of the chart", buttons)


def stitch_buttons(chart: Chart, words: Sequence[str], chosen: str) -> Markup:
    """Return the buttons of stitches, or of the two crossings of a weave."""
    if isinstance(chart, WeaveChart):
        symbols = {"1": WEFT_OVER, "0": WARP_OVER}
        buttons = []
        for word, hint in {"1": "weft over warp", "0": "warp over weft"}.items():
            content = markup("{} {}", symbol_svg(symbols[word]), markup(_RAISED, hint))
            buttons.append(_button("stitch", word, f"Paint {hint}", content, _PLAIN, pressed=word == chosen))
        return _group("What passes over", buttons)
    return _group("Stitches", [
        _button("stitch", word, f"{word}: {word_instruction(word)}", _square(word), _PLAIN, pressed=word == chosen)
        for word in words
    ])  # fmt: skip


def layer_buttons(layers: Sequence[int], shown: int | None) -> Markup:
    """Return the buttons of the layers of a weave; nothing if the weave has one layer."""
    if not layers:
        return Markup()
    buttons = [_button("layer", "", "Show the yarns of all layers", "All layers", _WORD, pressed=shown is None)]
    for layer in layers:
        hint = f"Show and paint layer {layer + 1} alone, counted from the front"
        buttons.append(_button("layer", str(layer), hint, f"Layer {layer + 1}", _WORD, pressed=layer == shown))
    return _group("Layers of the weave", buttons)


def colour_buttons(chart: Chart, count: int, chosen: int | None) -> Markup:
    """Return the buttons of the yarn colours, and a button that adds a colour."""
    what = "Colours of wefts and warps" if isinstance(chart, WeaveChart) else "Colours of yarns"
    buttons = []
    for number, colour in enumerate(palette_of(chart, count)):
        hint = f"{number}: yarn number {number}, {colour}"
        buttons.append(_button("yarn", str(number), hint, str(number), _swatch(colour), pressed=number == chosen))
    buttons.append(_button("add-yarn", "", "Add a yarn of another colour", "+ colour", _WORD))
    return _group(what, buttons)


def _square(word: str) -> Markup:
    known = CODES.get(word)
    name = word if known is None else NAMED.get(known, word)
    label = markup('<span style="font-size:10px;display:block;line-height:11px">{}</span>', name)
    return symbol_svg(chart_symbol(word)) + label


def _swatch(colour: str) -> str:
    red, green, blue = (int(colour[place : place + 2], 16) for place in (1, 3, 5))
    ink = "#1b1f24" if 0.299 * red + 0.587 * green + 0.114 * blue > 140 else "#ffffff"
    return f"background:{colour};color:{ink};"


def _button(
    action: str, value: str, hint: str, content: str, look: str, *, pressed: bool | None = None, disabled: bool = False
) -> Markup:
    """Return a button; ``pressed`` is None for a button without a state, which acts once."""
    style = _STYLE.format(edge="#1f6fd1" if pressed else "#8b9097", more=look)
    style += "outline:2px solid #f2b134;" if pressed else ""
    style += "opacity:0.5;cursor:default;" if disabled else ""
    name = "" if look == _WORD else hint  # A visible word already is the name.
    return action_button(
        action, value, content, name=name, hint=hint, pressed=pressed, disabled=disabled, style=style
    )


def _group(label: str, buttons: Sequence[Markup]) -> Markup:
    return markup('<div role="group" aria-label="{}">{}</div>', label, joined(buttons))
