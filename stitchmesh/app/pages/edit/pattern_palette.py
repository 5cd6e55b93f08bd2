# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The palette of patterns: a button with a thumbnail for each pattern of the library and of the user.

The patterns of the library stand in families. A search keeps the patterns whose names hold its words.

A thumbnail takes some hundredths of a second. The palette therefore first appears with names alone. The thumbnails then
follow one after another, each in an event of its own, so that the page still answers.
"""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping
from functools import cache

from stitchmesh.app.controls.controls import Control, Controls
from stitchmesh.app.controls.html_pieces import action_button
from stitchmesh.markup import Markup, css_text, joined, markup
from stitchmesh.patterns.library import FAMILIES, family_of, pattern_names, read_pattern
from stitchmesh.patterns.pattern import Pattern
from stitchmesh.render.thumbnails.pattern_thumbnail import pattern_thumbnail

SIZE = 72
"""Width and height of a thumbnail [pixels]."""
OWN = "Your own"
"""Title of the patterns of the user."""
STYLE = markup("""<style>
.sm-patterns{display:flex;flex-wrap:wrap;gap:4px}
.sm-patterns button{width:96px;padding:3px;border:2px solid transparent;border-radius:6px;background:none;
 cursor:pointer;font:inherit;font-size:.7em;line-height:1.2;color:var(--mantine-color-text);overflow-wrap:anywhere}
.sm-patterns button:hover{border-color:var(--mantine-color-default-border)}
.sm-patterns button:focus-visible{outline:3px solid #e08a1e;outline-offset:1px}
.sm-patterns-title{margin:.3em 0 .15em;font-size:.8em;font-weight:600}
.sm-patterns .sm-picture{display:block;width:72px;height:72px;margin:0 auto 2px;border-radius:4px;
 background:#8886}
</style>""")
CHOSEN = (
    '<style>.sm-patterns button[data-value="{}"]{{border-color:#2f8fc4;background:#2f8fc433}}</style>'
)
"""Mark of the button of a pattern."""
_PICTURES: dict[str, str] = {}
"""Finished thumbnails, as sources of images, by the name of the pattern."""


class PatternPalette:
    """The buttons of the patterns."""

    def __init__(
        self, controls: Controls, chosen: Callable[[str], object], post: Callable[[Callable[[], object]], object],
        own: Mapping[str, Pattern],
    ) -> None:  # fmt: skip
        """Make the buttons.

        Args:
            controls: where they stand.
            chosen: called with the name of the pressed pattern.
            post: calls a function later, after other events.
            own: the patterns of the user, by the names of their buttons.
        """
        self._post, self._own, self._words = post, own, ""
        self._families = [(OWN, tuple(own)), *_families_of_library()]
        self._mark = controls.html(STYLE)
        hint = "Words in the names of the patterns that stay in the list"
        self._search = controls.text("Search", hint, "", self._find)
        self._blocks: list[Control] = [
            controls.html(self._block(number), lambda _, name: chosen(name)) for number in range(len(self._families))
        ]
        self._open, self._begun = True, False

    @property
    def visible(self) -> bool:
        """Whether the palette is shown."""
        return self._mark.visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        for control in (self._mark, self._search, *self._blocks):
            control.visible = visible
        if visible and not self._begun:
            self._begun = True
            self._post(lambda: self._draw(0))

    def show_own(self, own: Mapping[str, Pattern]) -> None:
        """Show other patterns of the user."""
        self._own, self._families[0] = own, (OWN, tuple(own))
        self._blocks[0].content = self._block(0)

    def show_chosen(self, name: str) -> None:
        """Mark the button of a pattern."""
        self._mark.content = STYLE + (markup(CHOSEN, css_text(name)) if name else Markup())

    def close(self) -> None:
        """Draw no further thumbnails."""
        self._open = False

    def _draw(self, block: int) -> None:
        """Draw one missing thumbnail, and the others in later events."""
        if not self._open or block >= len(self._families):
            return
        missing = [name for name in self._families[block][1] if name not in _PICTURES and name not in self._own]
        if missing:
            _PICTURES[missing[0]] = _source(read_pattern(missing[0]))
        if len(missing) <= 1:
            self._blocks[block].content = self._block(block)
            block += 1
        self._post(lambda: self._draw(block))

    def _find(self, words: str) -> None:
        """Show the patterns whose names hold all words."""
        self._words = words
        for number, block in enumerate(self._blocks):
            block.content = self._block(number)

    def _block(self, number: int) -> Markup:
        """Return the title and the buttons of a family; nothing if the search keeps none of them."""
        title, names = self._families[number]
        buttons = [self._button(name) for name in names if self._is_found(name)]
        if not buttons:
            return Markup()
        return markup(
            '<p class="sm-patterns-title">{}</p><div class="sm-patterns">{}</div>', title, joined(buttons)
        )

    def _is_found(self, name: str) -> bool:
        pattern = self._own.get(name) or read_pattern(name)
        text = f"{name} {pattern.name}".lower()
        return all(word in text for word in self._words.lower().split())

    def _button(self, name: str) -> Markup:
        pattern = self._own.get(name) or read_pattern(name)
        source = _source(pattern) if name in self._own else _PICTURES.get(name)
        picture = (
            markup('<img class="sm-picture" src="{}" alt="">', source)
            if source
            else markup('<span class="sm-picture"></span>')
        )
        words = f"{pattern.name}, {pattern.width} stitches by {pattern.height} rows"
        size = f"{pattern.width} x {pattern.height}"
        content = markup("{}{}<br>{}", picture, name.replace("-", " "), size)
        return action_button("pattern", name, content, name=words, hint=words)


@cache
def _families_of_library() -> list[tuple[str, tuple[str, ...]]]:
    """Return the families of the library with the names of their patterns, in order."""
    family = {name: family_of(read_pattern(name)) for name in pattern_names()}
    return [(title, tuple(name for name in family if family[name] == title)) for title in FAMILIES]


def _source(pattern: Pattern) -> str:
    return "data:image/png;base64," + base64.b64encode(pattern_thumbnail(pattern, SIZE)).decode("ascii")
