# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pieces of HTML that pages show: legends, colour bars, tables of figures and verdicts.

Colours come from the theme of the browser, so that the pieces suit light and dark panels. A verdict has a sign and a
word besides its colour, for users who do not see the colour.
"""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.mesh.palette import colour_text

Grade = Literal["good", "fair", "bad"]
SIGNS: dict[Grade, tuple[str, str]] = {"good": ("✓", "#2b7bb9"), "fair": ("!", "#e08a1e"), "bad": ("✕", "#b0304f")}
"""Sign and colour of each grade; the colours differ in brightness too."""
SMALL = "font-size:.84em;line-height:1.45"


def legend(entries: Iterable[tuple[str, ArrayLike]], title: str = "") -> str:
    """Return a legend.

    Args:
        entries: text and sRGB colour of each entry.
        title: what the colours stand for.
    """
    items = "".join(
        f'<li style="display:inline-flex;align-items:center;gap:.4em;margin:0 .9em .15em 0">{_patch(colour)}'
        f"{escape(text)}</li>"
        for text, colour in entries
    )
    return f'{_title(title)}<ul style="list-style:none;margin:0;padding:0;{SMALL}">{items}</ul>'


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
    return f'{_title(title)}<div role="img" aria-label="{escape(title or "colour scale")}">{bar}{row}</div>'


def figures(rows: Iterable[tuple[str, str]], title: str = "") -> str:
    """Return a table of names and values."""
    lines = "".join(
        f'<tr><th scope="row" style="text-align:left;font-weight:400;padding:.1em .8em .1em 0">{escape(name)}</th>'
        f'<td style="text-align:right;font-variant-numeric:tabular-nums">{escape(value)}</td></tr>'
        for name, value in rows
    )
    return f'{_title(title)}<table style="width:100%;border-collapse:collapse;{SMALL}"><tbody>{lines}</tbody></table>'


def verdict(grade: Grade, text: str) -> str:
    """Return a sentence with the sign and the colour of a grade."""
    sign, colour = SIGNS[grade]
    mark = f'<span aria-hidden="true" style="font-weight:700;color:{colour};margin-right:.5em">{sign}</span>'
    style = f"border-left:4px solid {colour};padding:.3em .6em;margin:.2em 0;{SMALL}"
    return f'<div role="status" style="{style}">{mark}{escape(text)}</div>'


def _patch(colour: ArrayLike) -> str:
    style = f"width:.95em;height:.95em;border-radius:3px;border:1px solid #0004;background:{colour_text(colour)}"
    return f'<span aria-hidden="true" style="{style};flex:none"></span>'


def _title(title: str) -> str:
    return f'<div style="font-weight:600;margin:.2em 0 .15em;{SMALL}">{escape(title)}</div>' if title else ""
