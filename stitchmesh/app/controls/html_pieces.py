# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pieces of HTML that pages show: colour bars, tables of figures and boxes with a message.

Colours come from the theme of the browser, so that the pieces suit light and dark panels. A message has a mark besides
its colour, for users who do not see the colour.
"""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.mesh.palette import colour_text

GOOD, DOUBTFUL = "#1f77b4", "#d97706"
"""Blue and orange, which colour-blind people can tell apart, on light and on dark ground."""
Kind = Literal["good", "doubtful", "info"]
MARKS: dict[Kind, tuple[str, str]] = {
    "good": ("✓", GOOD), "doubtful": ("⚠", DOUBTFUL), "info": ("\N{INFORMATION SOURCE}", "#6b7280"),
}  # fmt: skip
"""Mark and colour of each kind of message."""
BOX = (
    "border-left:5px solid {colour};background:color-mix(in srgb, {colour} 12%, transparent);"
    "padding:.4em .6em;font-size:.92em"
)
"""Style of a box."""
SMALL = "font-size:.84em;line-height:1.45"


def colour_bar(colours: ArrayLike, marks: Iterable[str], title: str = "") -> str:
    """Return a bar of changing colours with texts below it, evenly spaced from the first colour to the last one.

    Args:
        colours: sRGB colours, shape (n, 3), from low to high.
        marks: texts from low to high.
        title: what the colours stand for.
    """
    stops = ",".join(colour_text(colour) for colour in np.asarray(colours))
    texts = "".join(f"<span>{escape(mark)}</span>" for mark in marks)
    bar = f'<div style="height:.8em;border-radius:3px;background:linear-gradient(90deg,{stops})"></div>'
    row = f'<div style="display:flex;justify-content:space-between;{SMALL}">{texts}</div>'
    return f'{section_title(title)}<div role="img" aria-label="{escape(title or "colour scale")}">{bar}{row}</div>'


def figures(rows: Iterable[tuple[str, str]], title: str = "") -> str:
    """Return a table of names and values."""
    lines = "".join(
        f'<tr><th scope="row" style="text-align:left;font-weight:400;padding:.1em .8em .1em 0">{escape(name)}</th>'
        f'<td style="text-align:right;font-variant-numeric:tabular-nums">{escape(value)}</td></tr>'
        for name, value in rows
    )
    table = f'<table style="width:100%;border-collapse:collapse;{SMALL}"><tbody>{lines}</tbody></table>'
    return section_title(title) + table


def message(text: str, kind: Kind) -> str:
    """Return a box with a sentence and the mark and colour of its kind."""
    mark, colour = MARKS[kind]
    style = BOX.format(colour=colour)
    return f'<div role="status" style="{style}"><span aria-hidden="true">{mark}</span> {escape(text)}</div>'


def section_title(title: str) -> str:
    """Return a title; an empty text for no title."""
    return f'<div style="font-weight:600;margin:.2em 0 .15em;{SMALL}">{escape(title)}</div>' if title else ""
