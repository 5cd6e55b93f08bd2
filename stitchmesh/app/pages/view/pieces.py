# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pieces of HTML of the page: the list of results, legends, pictures, texts and the figures of drawing."""

from __future__ import annotations

import base64
from collections.abc import Sequence

from stitchmesh.app.controls.html_pieces import colour_bar
from stitchmesh.app.controls.legend import legend_of_key
from stitchmesh.app.pages.view.viewed import Viewed
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.render.colouring import Coloured

NOTHING = "There is nothing to see yet. Open a file, or make something on the other pages."
FRAMES = markup(
    '<div class="sm-frames" role="status" style="font-size:.86em;font-variant-numeric:tabular-nums"></div>'
)
"""The element that the script ``frame_rate.js`` fills."""


def list_of_results(names: Sequence[str], chosen: str) -> Markup:
    """Return the list of what can be shown, as buttons."""
    if not names:
        return markup('<p style="font-size:.86em;margin:.2em 0">{}</p>', NOTHING)
    buttons = joined(
        markup(
            '<button type="button" data-action="show" data-value="{}"{}>{}</button>',
            name, " aria-current=true" if name == chosen else "", name,
        )
        for name in names
    )
    return markup(
        '<nav class="sm-nav" style="flex-wrap:wrap" aria-label="What the scene shows">{}</nav>',
        buttons,
    )


def legend_of(coloured: Coloured) -> Markup:
    """Return the legend of colours as HTML: names, or a bar for numbers; an empty text where they need none."""
    if coloured.scale is None:
        return legend_of_key(coloured.key) if coloured.key else Markup()
    numbers, units = zip(*(text.split(" ", 1) for text, _ in reversed(coloured.key)), strict=True)
    return colour_bar(coloured.scale.table(9), numbers, units[0])


def shown_in_panel(viewed: Viewed) -> Markup:
    """Return a picture, or the text of a file, as HTML."""
    if viewed.picture:
        code = base64.b64encode(viewed.picture).decode("ascii")
        return markup('<img alt="{}" style="max-width:100%" src="data:image/png;base64,{}">', viewed.name, code)
    if viewed.text and viewed.thing is None:
        style = "font-size:.75em;max-height:24em;overflow:auto;white-space:pre-wrap"
        return markup('<pre tabindex="0" aria-label="{}" style="{}">{}</pre>', viewed.name, style, viewed.text)
    return Markup()


def status_line(text: str) -> Markup:
    """Return a line that a screen reader announces; an empty text for none."""
    return markup('<p role="status" style="font-size:.86em;margin:.3em 0">{}</p>', text) if text else Markup()
