# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pieces of HTML that pages show: buttons, colour bars, tables of figures and boxes with a message.

Colours come from the theme of the browser, so that the pieces suit light and dark panels. A message has a mark besides
its colour, for users who do not see the colour.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh.palette import colour_text

GOOD, DOUBTFUL = "#1f77b4", "#d97706"
"""Blue and orange, which colour-blind people can tell apart, on light and dark backgrounds."""
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
SMALL_BUTTON = (
    "font:inherit;cursor:pointer;border-radius:6px;padding:.15em .5em;color:var(--mantine-color-text);"
    "border:1px solid var(--mantine-color-default-border);background:var(--mantine-color-default)"
)
"""Style of a button in a line of a list."""
PLAIN_TEXT = "margin:0;font-size:.86em"
"""Style of a line of text."""
BUTTON = (
    "font:inherit;font-size:.95em;display:block;width:100%;text-align:left;margin:.15em 0;padding:.3em .4em;"
    "border-radius:6px;cursor:pointer;background:transparent;color:inherit;border:1px solid"
)
"""Style of a button of a list, up to the colour of its border."""


def action_button(
    action: str, value: object, content: object, *, name: object = "", hint: object = "", pressed: bool | None = None,
    disabled: bool = False, current: str = "", wide: bool = False, style: str = "",
) -> Markup:  # fmt: skip
    """Return a button that calls the action of its piece of HTML with a value.

    Args:
        action: name of the action.
        value: value with which the action is called.
        content: the content of the button.
        name: the text for a screen reader, if the content does not say it.
        hint: a line that appears beside the pointer.
        pressed: whether the button is the chosen one of several; None for a button that acts once.
        disabled: whether the button is disabled.
        current: ``page`` or ``true`` for the button of the thing that is shown now.
        wide: whether the button is as wide as its panel.
        style: its style.
    """
    attributes = {
        "aria-label": name, "title": hint, "aria-pressed": "" if pressed is None else str(pressed).lower(),
        "aria-current": current, "class": "wide" if wide else "", "style": style,
    }  # fmt: skip
    given = joined(markup(' {}="{}"', key, text) for key, text in attributes.items() if text)
    frame = '<button type="button" data-action="{}" data-value="{}"{}{}>{}</button>'
    return markup(frame, action, value, given, " disabled" if disabled else "", content)


def list_button(
    action: str, value: object, words: str, border: str = "var(--mantine-color-default-border)", *, hint: str = "",
    pressed: bool | None = None,
) -> Markup:  # fmt: skip
    """Return a button as wide as its list, with a border of a colour; other arguments as for ``action_button``."""
    return action_button(action, value, words, hint=hint, pressed=pressed, style=f"{BUTTON} {border}")


def colour_bar(colours: ArrayLike, marks: Iterable[str], title: str = "", spoken: str = "") -> Markup:
    """Return a bar of changing colours with texts below it, evenly spaced from the first colour to the last one.

    Args:
        colours: sRGB colours, shape (n, 3), from low to high.
        marks: texts from low to high.
        title: what the colours stand for.
        spoken: what a screen reader says; the title by default.
    """
    stops = ",".join(colour_text(colour) for colour in np.asarray(colours))
    texts = joined(markup("<span>{}</span>", mark) for mark in marks)
    bar = markup('<div style="height:.8em;border-radius:3px;background:linear-gradient(90deg,{})"></div>', stops)
    row = markup('<div style="display:flex;justify-content:space-between;{}">{}</div>', SMALL, texts)
    return markup(
        '{}<div role="img" aria-label="{}">{}{}</div>',
        section_title(title), spoken or title or "colour scale", bar, row,
    )


def figures(rows: Iterable[tuple[str, str]], title: str = "") -> Markup:
    """Return a table of names and values."""
    lines = joined(
        markup(
            '<tr><th scope="row" style="text-align:left;font-weight:400;padding:.1em .8em .1em 0">{}</th>'
            '<td style="text-align:right;font-variant-numeric:tabular-nums">{}</td></tr>',
            name, value,
        )
        for name, value in rows
    )
    table = markup(
        '<table style="width:100%;border-collapse:collapse;{}"><tbody>{}</tbody></table>',
        SMALL, lines,
    )
    return section_title(title) + table


def message(text: str, kind: Kind) -> Markup:
    """Return a box with a sentence and the mark and colour of its kind."""
    mark, colour = MARKS[kind]
    style = BOX.format(colour=colour)
    return markup('<div role="status" style="{}"><span aria-hidden="true">{}</span> {}</div>', style, mark, text)


def paragraph(text: str) -> Markup:
    """Return a text in letters of the size of the other controls; for an empty text, nothing."""
    return markup('<p style="margin:0;font-size:14px;line-height:1.45">{}</p>', text) if text else Markup()


def section_title(title: str) -> Markup:
    """Return a title; an empty text for no title."""
    return markup('<div style="font-weight:600;margin:.2em 0 .15em;{}">{}</div>', SMALL, title) if title else Markup()
