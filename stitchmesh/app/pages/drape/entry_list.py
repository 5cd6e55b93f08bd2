# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A list of what a scene has, as HTML: each entry can be chosen, and removed."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

STYLE = "list-style:none;margin:0;padding:0;font-size:.82em"
BUTTON = (
    "font:inherit;cursor:pointer;border-radius:6px;padding:.15em .5em;color:var(--mantine-color-text);"
    "border:1px solid var(--mantine-color-default-border);background:var(--mantine-color-default)"
)
CHOSEN = "border-left:4px solid #1f5673;padding-left:.4em;"


def entry_list(
    kind: str, entries: Iterable[str], *, chosen: int | None = None, choose: bool = False, rest: str = ""
) -> str:
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
        button = f'<button type="button" data-value="{number}" style="{BUTTON}" '
        buttons = f'{button} data-action="drop-{kind}" aria-label="Remove the {escape(text)}">Remove</button>'
        if choose:
            pressed = f'aria-pressed="{str(is_chosen).lower()}" aria-label="Change the {escape(text)}"'
            buttons = f'{button} data-action="choose-{kind}" {pressed}>Change</button>{buttons}'
        items.append(
            f'<li style="display:flex;gap:4px;align-items:center;margin:.2em 0;{CHOSEN if is_chosen else ""}">'
            f'<span style="flex:1 1 auto">{escape(text)}</span>{buttons}</li>'
        )
    if rest:
        items.append(f"<li>{escape(rest)}</li>")
    return f'<ul style="{STYLE}">{"".join(items)}</ul>' if items else ""
