# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Legends: what the colours and lines of a scene mean, as HTML for a panel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from stitchmesh.app.controls.html_pieces import section_title
from stitchmesh.app.scene.drawing import Colour

SQUARE = 14
"""Width and height of a coloured square [CSS pixels]."""
BORDER = "1px solid var(--mantine-color-default-border)"
"""Border of a mark, so that it can be seen on light and on dark panels."""


@dataclass(frozen=True)
class LegendEntry:
    """One line of a legend."""

    text: str
    """What the mark means."""
    colours: tuple[Colour, ...]
    """Colour of the mark; several colours stand side by side."""
    line: bool = False
    """Whether the mark is a line instead of a square."""


def legend(entries: Sequence[LegendEntry], title: str = "") -> str:
    """Return a legend as HTML, a list with one item for each entry; ``title`` says what the colours stand for."""
    items = "".join(
        f'<li style="display:flex;align-items:center;gap:.5em;margin:.1em 0">{_mark(entry)}'
        f"<span>{escape(entry.text)}</span></li>"
        for entry in entries
    )
    style = "list-style:none;margin:0;padding:0;font-size:.86em"
    return f'{section_title(title)}<ul aria-label="Legend" style="{style}">{items}</ul>'


def legend_of_key(key: Sequence[tuple[str, Colour]], title: str = "") -> str:
    """Return the legend of texts with one colour each, such as the key of a picture (``render.colouring``)."""
    return legend([LegendEntry(text, (colour,)) for text, colour in key], title)


def _mark(entry: LegendEntry) -> str:
    """The squares or the line of an entry; screen readers pass over them."""
    height = 6 if entry.line else SQUARE
    width = 2 * SQUARE if entry.line else SQUARE
    parts = "".join(
        f'<span style="display:inline-block;width:{width}px;height:{height}px;border:{BORDER};'
        f'background:rgb{colour!r}"></span>'
        for colour in entry.colours
    )
    return f'<span aria-hidden="true" style="flex:none;display:inline-flex">{parts}</span>'
