# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Verdicts and figures as HTML. A mark and a word say what the colour says, so that the colour is not needed."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from stitchmesh.app.controls.html_pieces import BOX, DOUBTFUL, message
from stitchmesh.reporting.figures import Figure
from stitchmesh.reporting.verdict import Verdict

MOST = 4
"""Largest number of findings in a box; the first ones are the most important."""
LIST = "margin:.3em 0 0;padding-left:1.1em"
LINK = "all:unset;vertical-align:top;cursor:pointer;text-decoration:underline dotted"
"""Style of a finding that can be clicked."""


def verdict_html(verdict: Verdict, good: str, doubtful: str, *, action: str | None = None) -> str:
    """Return a box with a verdict.

    Args:
        verdict: the verdict.
        good: title of a good verdict, a clause.
        doubtful: title of another verdict, a clause.
        action: name of the action that a click on a finding calls with the number of the finding; None for none.
    """
    if verdict.good:
        return message(f"{good}: {verdict.praise}.", "good")
    shown = [_clickable(_sentence(str(found)), number, action) for number, found in enumerate(verdict.findings[:MOST])]
    if len(verdict.findings) > MOST:
        shown.append(f"And {len(verdict.findings) - MOST} more, which are less important.")
    items = "".join(f"<li>{item}</li>" for item in shown)
    style = BOX.format(colour=DOUBTFUL)
    return f'<div role="status" style="{style}"><b>&#9888; {escape(doubtful)}</b><ul style="{LIST}">{items}</ul></div>'


def figures_html(figures: Sequence[Figure]) -> str:
    """Return a table of figures; the meaning of each stands under it."""
    rows = "".join(
        f'<tr><th scope="row" style="text-align:left;font-weight:600;vertical-align:top">{_mark(figure)}'
        f"{escape(figure.name)}</th><td style='text-align:right;vertical-align:top'>{escape(figure.value)}</td></tr>"
        f"<tr><td colspan='2' style='font-size:.82em;padding-bottom:.35em'>{escape(figure.meaning)}</td></tr>"
        for figure in figures
    )
    return f'<table style="width:100%;border-collapse:collapse">{rows}</table>'


def _sentence(clause: str) -> str:
    return f"{clause[0].upper()}{clause[1:]}."


def _mark(figure: Figure) -> str:
    return "" if figure.good else f'<span style="color:{DOUBTFUL}" title="not good">&#9888; </span>'


def _clickable(text: str, number: int, action: str | None) -> str:
    if action is None:
        return escape(text)
    attributes = f'data-action="{escape(action)}" data-value="{number}"'
    return f'<button type="button" {attributes} style="{LINK}">{escape(text)}</button>'
