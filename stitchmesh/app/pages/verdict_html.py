# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Verdicts and figures as HTML.

A mark and a word repeat the meaning of the colour, so that no user needs the colour.
"""

from __future__ import annotations

from collections.abc import Sequence

from stitchmesh.app.controls.html_pieces import BOX, DOUBTFUL, action_button, message
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.reporting.figures import Figure
from stitchmesh.reporting.verdict import Verdict

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


def figures_html(figures: Sequence[Figure]) -> Markup:
    """Return a table of figures, with the meaning of each below it."""
    rows = joined(
        markup(
            '<tr><th scope="row" style="text-align:left;font-weight:600;vertical-align:top">{}'
            "{}</th><td style='text-align:right;vertical-align:top'>{}</td></tr>"
            "<tr><td colspan='2' style='font-size:.82em;padding-bottom:.35em'>{}</td></tr>",
            _mark(figure), figure.name, figure.value, figure.meaning,
        )
        for figure in figures
    )
    return markup('<table style="width:100%;border-collapse:collapse">{}</table>', rows)


def _sentence(clause: str) -> str:
    return f"{clause[0].upper()}{clause[1:]}."


def _mark(figure: Figure) -> Markup:
    return Markup() if figure.good else markup('<span style="color:{}" title="not good">&#9888; </span>', DOUBTFUL)


def _clickable(text: str, number: int, action: str | None) -> Markup:
    if action is None:
        return markup("{}", text)
    return action_button(action, number, text, style=LINK)
