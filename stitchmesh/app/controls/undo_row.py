# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Undo and redo for any page: two buttons in a row, and keys for both."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.html_pieces import action_button
from stitchmesh.editing.undo_history import UndoHistory
from stitchmesh.markup import Markup, joined, markup

STYLE = markup("""<style>
.sm-undo{display:grid;grid-template-columns:1fr 1fr;gap:4px;margin:0}
.sm-undo button{font:inherit;font-size:.8em;line-height:1.2;padding:.45em .2em;border-radius:6px;cursor:pointer;
 border:1px solid var(--mantine-color-default-border);background:var(--mantine-color-default);
 color:var(--mantine-color-text)}
.sm-undo button:disabled{opacity:.45;cursor:default}
.sm-undo button:focus-visible{outline:3px solid #e08a1e;outline-offset:1px}
</style>""")


class UndoRow:
    """The buttons and keys of undo and redo."""

    def __init__(
        self, controls: Controls, undo: Callable[[], object], redo: Callable[[], object], what: str = "the last change"
    ) -> None:
        """Make the buttons and keys; ``what`` names what they undo and make again."""
        self._what = what
        self._row = controls.html(Markup(), lambda action, _: undo() if action == "undo" else redo())
        for label, key, modifier, act in (
            ("Undo", "Z", "ctrl", undo), ("Redo", "Y", "ctrl", redo), ("Redo also", "Z", "ctrl+shift", redo)
        ):  # fmt: skip
            controls.key(label, f"{label} {what}.", key, modifier, act)

    def show(self, history: UndoHistory[Any] | None, *, unfinished: bool = False) -> None:
        """Show whether a history has something to undo and to redo; an unfinished change can be undone too."""
        can_undo = (history is not None and bool(history.past)) or unfinished
        can_redo = history is not None and bool(history.future)
        buttons = joined([
            action_button("undo", "", "Undo", hint=f"Undo {self._what}: Ctrl+Z", disabled=not can_undo),
            action_button("redo", "", "Redo", hint="Make it again: Ctrl+Y", disabled=not can_redo),
        ])  # fmt: skip
        self._row.content = markup('{}<div class="sm-undo" role="group" aria-label="History">{}</div>', STYLE, buttons)
