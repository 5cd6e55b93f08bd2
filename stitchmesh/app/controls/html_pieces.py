# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pieces of HTML that pages show: buttons, legends, colour bars, tables of figures, verdicts and boxes with a message.

Colours come from the theme of the browser, so that the pieces suit light and dark panels. A mark and a word repeat the
meaning of a colour, for users who do not see it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.app.scene.drawing import Colour
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh.palette import colour_text
from stitchmesh.reporting.figures import Figure
from stitchmesh.reporting.verdict import Verdict

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


def message(text: str, kind: Kind, role: Literal["status", "alert"] = "status") -> Markup:
    """Return a box with a sentence and the mark and colour of its kind; a screen reader reads an alert out at once."""
    mark, colour = MARKS[kind]
    style = BOX.format(colour=colour)
    return markup('<div role="{}" style="{}"><span aria-hidden="true">{}</span> {}</div>', role, style, mark, text)


def paragraph(text: str) -> Markup:
    """Return a text in letters of the size of the other controls; for an empty text, nothing."""
    return markup('<p style="margin:0;font-size:14px;line-height:1.45">{}</p>', text) if text else Markup()


def status_line(text: object) -> Markup:
    """Return a line of text that a screen reader reads out after each change; nothing for an empty text."""
    return markup('<p role="status" style="{}">{}</p>', PLAIN_TEXT, text) if text else Markup()


def refusal(text: str) -> Markup:
    """Return a box with the reason why something is not possible."""
    return message(f"Not possible: {text}", "doubtful", "alert")


def section_title(title: str) -> Markup:
    """Return a title; an empty text for no title."""
    return markup('<div style="font-weight:600;margin:.2em 0 .15em;{}">{}</div>', SMALL, title) if title else Markup()


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


MOST = 4
"""Largest number of findings in a box, where the most important ones come first."""
LINK = "all:unset;vertical-align:top;cursor:pointer;text-decoration:underline dotted"
"""Style of a finding that the user can click."""


def verdict_html(verdict: Verdict, good: str, doubtful: str, *, action: str | None = None) -> Markup:
    """Return a box with a verdict.

    Args:
        verdict: the verdict.
        good: title of a good verdict, a clause.
        doubtful: title of another verdict, a clause.
        action: name of the action of a click on a finding, which gets its number; None for no action.
    """
    if verdict.good:
        return message(f"{good}: {verdict.praise}.", "good")
    shown = [_clickable(_sentence(str(found)), number, action) for number, found in enumerate(verdict.findings[:MOST])]
    if len(verdict.findings) > MOST:
        shown.append(markup("And {} more, which are less important.", len(verdict.findings) - MOST))
    items = joined(markup("<li>{}</li>", item) for item in shown)
    style = BOX.format(colour=DOUBTFUL)
    return markup(
        '<div role="status" style="{}"><b>&#9888; {}</b><ul style="{}">{}</ul></div>',
        style, doubtful, "margin:.3em 0 0;padding-left:1.1em", items,
    )


def range_html(verdict: Verdict, name: str = "") -> Markup:
    """Return a box that says whether figures were compared with measurements; ``name`` is that of their fabric."""
    of = f"{name}: " if name else ""
    return verdict_html(verdict, f"{of}Validated", f"{of}Not validated")


def figures_html(figures: Sequence[Figure]) -> Markup:
    """Return a table of figures, with the meaning of each below it."""
    rows = joined(
        markup(
            '<tr><th scope="row" style="text-align:left;font-weight:600;vertical-align:top">{}'
            "{}</th><td style='text-align:right;vertical-align:top'>{}</td></tr>"
            "<tr><td colspan='2' style='font-size:.82em;padding-bottom:.35em'>{}</td></tr>",
            _doubt(figure), figure.name, figure.value, figure.meaning,
        )
        for figure in figures
    )
    return markup('<table style="width:100%;border-collapse:collapse">{}</table>', rows)


def _sentence(clause: str) -> str:
    return f"{clause[0].upper()}{clause[1:]}."


def _doubt(figure: Figure) -> Markup:
    return Markup() if figure.good else markup('<span style="color:{}" title="not good">&#9888; </span>', DOUBTFUL)


def _clickable(text: str, number: int, action: str | None) -> Markup:
    if action is None:
        return markup("{}", text)
    return action_button(action, number, text, style=LINK)
