# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Lists of the parts of a scene: the user can remove each entry, and choose one to change it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Generic, TypeVar

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.html_pieces import SMALL_BUTTON, action_button
from stitchmesh.app.pages.drape.drape_session import DrapeSession
from stitchmesh.errors import ParameterError
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mixed.scene.scene import Scene

T = TypeVar("T")


def entry_list(
    kind: str, entries: Iterable[str], *, chosen: int | None = None, choose: bool = False, rest: str = ""
) -> Markup:
    """Return the entries as a list; an empty text if there are none.

    The actions are ``drop-`` and ``choose-`` with the kind; their value is the number of the entry.

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
                "border-left:4px solid #1f5673;padding-left:.4em;" if is_chosen else "", text, buttons,
            )
        )
    if rest:
        items.append(markup("<li>{}</li>", rest))
    frame = '<ul style="list-style:none;margin:0;padding:0;font-size:.82em">{}</ul>'
    return markup(frame, joined(items)) if items else Markup()


class EntryList(Generic[T]):
    """The parts or the bodies of a scene as a list; the user can choose one to change it."""

    def __init__(
        self, session: DrapeSession, controls: Controls, kind: str, what: str, entries: Callable[[Scene], Sequence[T]],
        without: Callable[[Scene, int], Scene], changed: Callable[[], object],
    ) -> None:  # fmt: skip
        """Make the list.

        Args:
            session: the scene.
            controls: the place of the list.
            kind: word for an entry.
            what: the first words of messages.
            entries: returns the entries of a scene.
            without: returns a scene without the entry that has a number.
            changed: called after another entry is chosen.
        """
        self._session, self._kind, self._what = session, kind, what
        self._entries, self._without, self._changed = entries, without, changed
        self.chosen: int | None = None
        """Number of the chosen entry; a new entry may be missing for a while, because the worker thread makes the
        scene."""
        self._html = controls.html(Markup(), self._act)

    def show(self, scene: Scene, words: Iterable[str]) -> None:
        """Show the entries of a scene with their words."""
        entries = self._entries(scene)
        if self.chosen is not None and self.chosen >= len(entries) and not self._session.app.tasks.running:
            self.chosen = None
        self._html.content = entry_list(self._kind, words, chosen=self.chosen, choose=True)

    def entry(self) -> T | None:
        """Return the chosen entry; None if there is none."""
        opened = self._session.opened
        entries = () if opened is None else self._entries(opened.scene)
        return entries[self.chosen] if self.chosen is not None and self.chosen < len(entries) else None

    def choose(self, number: int | None) -> None:
        """Choose an entry, or none."""
        self.chosen = number
        self._changed()

    def chosen_entry(self) -> tuple[int, T]:
        """Return the number of the chosen entry, and the entry.

        Raises:
            ParameterError: no entry is chosen, or the chosen one is gone.
        """
        entries = self._entries(self._session.opened_for(self._what).scene)
        if self.chosen is None or self.chosen >= len(entries):
            raise ParameterError(f"{self._what}: no {self._kind} is chosen; choose one in the list")
        return self.chosen, entries[self.chosen]

    def _act(self, action: str, value: str) -> None:
        scene = self._session.opened_for(self._what).scene
        choose, drop = f"choose-{self._kind}", f"drop-{self._kind}"
        if action not in (choose, drop) or not value.isdecimal() or int(value) >= len(self._entries(scene)):
            raise ParameterError(f"{self._what}: the list has changed; look at it again")
        if action == choose:
            self.choose(int(value))
            return
        self.chosen = None
        self._session.change(self._without(scene, int(value)))


def with_entry(entries: tuple[T, ...], number: int, entry: T | None) -> tuple[T, ...]:
    """Return entries in which another entry replaces one of them; None removes it."""
    changed = () if entry is None else (entry,)
    return (*entries[:number], *changed, *entries[number + 1 :])
