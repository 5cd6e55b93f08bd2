# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A list of what a scene has, as HTML: each entry can be chosen, and removed."""

from __future__ import annotations

from collections.abc import Iterable

from stitchmesh.app.controls.html_pieces import SMALL_BUTTON, action_button
from stitchmesh.markup import Markup, joined, markup

STYLE = "list-style:none;margin:0;padding:0;font-size:.82em"
CHOSEN = "border-left:4px solid #1f5673;padding-left:.4em;"


def entry_list(
    kind: str, entries: Iterable[str], *, chosen: int | None = None, choose: bool = False, rest: str = ""
) -> Markup:
    """Return the entries as a list; an empty text without any.

    The actions are ``drop-`` and ``choose-`` with the kind, and the number of the entry as their value.

    Args:
        kind: word for an entry.
        entries: texts of the entries.
        chosen: number of the entry that is marked as the chosen one.
        choose: whether entries can be chosen.
        rest: a last line that is no entry.
    """
    items = []
    for number, text in enumerate(entries):
        is_chosen = number == chosen
        buttons = action_button(f"drop-{kind}", number, "Remove", name=f"Remove the {text}", style=SMALL_BUTTON)
        if choose:
            change = action_button(
                f"choose-{kind}", number, "Change", name=f"Change the {text}", pressed=is_chosen, style=SMALL_BUTTON
            )
            buttons = change + buttons
        items.append(
            markup(
                '<li style="display:flex;gap:4px;align-items:center;margin:.2em 0;{}">'
                '<span style="flex:1 1 auto">{}</span>{}</li>',
                CHOSEN if is_chosen else "", text, buttons,
            )
        )
    if rest:
        items.append(markup("<li>{}</li>", rest))
    return markup('<ul style="{}">{}</ul>', STYLE, joined(items)) if items else Markup()
