# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Legends, which explain the colours and lines of a scene, as HTML for a panel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stitchmesh.app.controls.html_pieces import section_title
from stitchmesh.app.scene.drawing import Colour
from stitchmesh.markup import Markup, joined, markup

SQUARE = 14
"""Width and height of a coloured square [CSS pixels]."""
BORDER = "1px solid var(--mantine-color-default-border)"
"""Border of a mark, so that it can be seen on light and on dark panels."""


@dataclass(frozen=True)
class LegendEntry:
    """One line of a legend."""

    text: str
    """The meaning of the mark."""
    colours: tuple[Colour, ...]
    """Colour of the mark; several colours stand side by side."""
    line: bool = False
    """Whether the mark is a line instead of a square."""


def legend(entries: Sequence[LegendEntry], title: str = "") -> Markup:
    """Return a legend as an HTML list with one item for each entry; ``title`` says what the colours stand for."""
    items = joined(
        markup(
            '<li style="display:flex;align-items:center;gap:.5em;margin:.1em 0">{}<span>{}</span></li>',
            _mark(entry), entry.text,
        )
        for entry in entries
    )
    style = "list-style:none;margin:0;padding:0;font-size:.86em"
    return markup('{}<ul aria-label="Legend" style="{}">{}</ul>', section_title(title), style, items)


def legend_of_key(key: Sequence[tuple[str, Colour]], title: str = "") -> Markup:
    """Return the legend of texts that have one colour each, such as the key of a picture (``render.colouring``)."""
    return legend([LegendEntry(text, (colour,)) for text, colour in key], title)


def _mark(entry: LegendEntry) -> Markup:
    """The squares or the line of an entry; screen readers pass over them."""
    height = 6 if entry.line else SQUARE
    width = 2 * SQUARE if entry.line else SQUARE
    parts = joined(
        markup(
            '<span style="display:inline-block;width:{}px;height:{}px;border:{};background:rgb{}"></span>',
            width, height, BORDER, f"{colour!r}",
        )
        for colour in entry.colours
    )
    return markup('<span aria-hidden="true" style="flex:none;display:inline-flex">{}</span>', parts)
