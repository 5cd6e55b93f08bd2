# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The buttons beside a chart as HTML: tools, stitches and colours, each with a hint and a pressed state."""

from __future__ import annotations

import html
from collections.abc import Sequence

from stitchmesh.app.controls.chart_drawing import palette_of, symbol_svg
from stitchmesh.patterns.charts.chart_symbols import WARP_OVER, WEFT_OVER, chart_symbol, word_instruction
from stitchmesh.periodic.chart_files import Chart
from stitchmesh.periodic.weave.weave_chart import WeaveChart

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
"""Words that the palette of a knit offers; a text field takes all others."""
CROSSINGS = {"1": "weft over warp", "0": "warp over weft"}
_STYLE = (
    "border:2px solid {edge};border-radius:4px;padding:1px;margin:0 3px 3px 0;min-width:28px;min-height:28px;"
    "cursor:pointer;vertical-align:middle;font:12px sans-serif;{more}"
)
_RAISED = '<span style="vertical-align:super">{}</span>'
_PLAIN = "background:#fbfaf7;color:#1b1f24;"


def tool_buttons(chosen: str) -> str:
    """Return the buttons of the tools."""
    return _group("Tools of the chart", [
        _button("tool", name, hint, name == chosen, html.escape(name), _PLAIN + "padding:1px 8px;")
        for name, hint in TOOLS.items()
    ])  # fmt: skip


def stitch_buttons(chart: Chart, words: Sequence[str], chosen: str) -> str:
    """Return the buttons of stitches, or of the two crossings of a weave."""
    if isinstance(chart, WeaveChart):
        symbols = {"1": WEFT_OVER, "0": WARP_OVER}
        buttons = [
            _button("stitch", word, hint, word == chosen, f"{symbol_svg(symbols[word])} {_RAISED.format(hint)}", _PLAIN)
            for word, hint in CROSSINGS.items()
        ]
        return _group("What passes over", buttons)
    return _group("Stitches", [
        _button("stitch", word, f"{word}: {word_instruction(word)}", word == chosen, _square(word), _PLAIN)
        for word in words
    ])  # fmt: skip


def layer_buttons(layers: Sequence[int], shown: int | None) -> str:
    """Return the buttons of the layers of a weave; nothing if the weave has one layer."""
    if not layers:
        return ""
    buttons = [_button("layer", "", "Show the yarns of all layers", shown is None, "All layers", _PLAIN)]
    for layer in layers:
        hint = f"Show and paint layer {layer + 1} alone, counted from the front"
        buttons.append(_button("layer", str(layer), hint, layer == shown, f"Layer {layer + 1}", _PLAIN))
    return _group("Layers of the weave", buttons)


def colour_buttons(chart: Chart, count: int, chosen: int | None) -> str:
    """Return the buttons of the yarn colours, and one that adds a colour."""
    colours = palette_of(chart, count)
    what = "Colours of wefts and warps" if isinstance(chart, WeaveChart) else "Colours of yarns"
    buttons = [
        _button("yarn", str(number), f"yarn {number}, {colour}", number == chosen, str(number), _swatch(colour))
        for number, colour in enumerate(colours)
    ]
    buttons.append(_button("add-yarn", "", "Add a yarn of another colour", False, "+", _PLAIN))
    return _group(what, buttons)


def _square(word: str) -> str:
    label = f'<span style="font-size:10px;display:block;line-height:11px">{html.escape(word)}</span>'
    return symbol_svg(chart_symbol(word)) + label


def _swatch(colour: str) -> str:
    red, green, blue = (int(colour[place : place + 2], 16) for place in (1, 3, 5))
    ink = "#1b1f24" if 0.299 * red + 0.587 * green + 0.114 * blue > 140 else "#ffffff"
    return f"background:{colour};color:{ink};"


def _button(action: str, value: str, hint: str, pressed: bool, content: str, more: str) -> str:
    style = _STYLE.format(edge="#1f6fd1" if pressed else "#8b9097", more=more)
    mark = "outline:2px solid #f2b134;" if pressed else ""
    text = html.escape(hint, quote=True)
    return (
        f'<button type="button" data-action="{action}" data-value="{html.escape(value, quote=True)}" title="{text}" '
        f'aria-label="{text}" aria-pressed="{str(pressed).lower()}" style="{style}{mark}">{content}</button>'
    )


def _group(label: str, buttons: Sequence[str]) -> str:
    return f'<div role="group" aria-label="{label}">{"".join(buttons)}</div>'


