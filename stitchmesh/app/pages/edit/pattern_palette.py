# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The palette of patterns: a button with a thumbnail for each pattern of the library.

A thumbnail takes some hundredths of a second. The palette therefore stands there at once with names. When it is
first shown, the thumbnails follow one after another, each in an event of its own, so that the page answers meanwhile.
"""

from __future__ import annotations

import base64
from collections.abc import Callable

from stitchmesh.app.controls.controls import Control, Controls
from stitchmesh.markup import Markup, css_text, joined, markup
from stitchmesh.patterns.library import pattern_names, read_pattern
from stitchmesh.render.thumbnails.pattern_thumbnail import pattern_thumbnail

SIZE = 72
"""Width and height of a thumbnail [pixels]."""
IN_BLOCK = 8
"""Number of patterns in a block of the palette; a block is sent again when its thumbnails are there."""
STYLE = markup("""<style>
.sm-patterns{display:flex;flex-wrap:wrap;gap:4px}
.sm-patterns button{width:96px;padding:3px;border:2px solid transparent;border-radius:6px;background:none;
 cursor:pointer;font:inherit;font-size:.7em;line-height:1.2;color:var(--mantine-color-text);overflow-wrap:anywhere}
.sm-patterns button:hover{border-color:var(--mantine-color-default-border)}
.sm-patterns button:focus-visible{outline:3px solid #e08a1e;outline-offset:1px}
.sm-patterns .sm-picture{display:block;width:72px;height:72px;margin:0 auto 2px;border-radius:4px;
 background:#8886}
</style>""")
CHOSEN = (
    '<style>.sm-patterns button[data-value="{}"]{{border-color:#2f8fc4;background:#2f8fc433}}</style>'
)
"""Mark of the button of a pattern."""
_PICTURES: dict[str, str] = {}
"""Thumbnails that are drawn already, as sources of images, by the name of the pattern."""


class PatternPalette:
    """The buttons of the patterns."""

    def __init__(
        self, controls: Controls, chosen: Callable[[str], object], post: Callable[[Callable[[], object]], object]
    ) -> None:
        """Make the buttons.

        Args:
            controls: where they stand.
            chosen: called with the name of the pattern that is pressed.
            post: calls a function later, after other events.
        """
        self._post = post
        self._names = _in_blocks(pattern_names())
        self._mark = controls.html(STYLE)
        self._blocks: list[Control] = [
            controls.html(_block(names), lambda _, name: chosen(name)) for names in self._names
        ]
        self._open, self._begun = True, False

    @property
    def visible(self) -> bool:
        """Whether the palette is shown."""
        return self._mark.visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        for control in (self._mark, *self._blocks):
            control.visible = visible
        if visible and not self._begun:
            self._begun = True
            self._post(lambda: self._draw(0))

    def show_chosen(self, name: str) -> None:
        """Mark the button of a pattern."""
        self._mark.content = STYLE + (markup(CHOSEN, css_text(name)) if name else Markup())

    def close(self) -> None:
        """Draw no further thumbnails."""
        self._open = False

    def _draw(self, block: int) -> None:
        """Draw one thumbnail that is missing, then the others in later events."""
        if not self._open or block >= len(self._names):
            return
        missing = [name for name in self._names[block] if name not in _PICTURES]
        if missing:
            _PICTURES[missing[0]] = _source(missing[0])
        if len(missing) <= 1:
            self._blocks[block].content = _block(self._names[block])
            block += 1
        self._post(lambda: self._draw(block))


def _in_blocks(names: tuple[str, ...]) -> list[tuple[str, ...]]:
    return [names[first : first + IN_BLOCK] for first in range(0, len(names), IN_BLOCK)]


def _source(name: str) -> str:
    return "data:image/png;base64," + base64.b64encode(pattern_thumbnail(read_pattern(name), SIZE)).decode("ascii")


def _block(names: tuple[str, ...]) -> Markup:
    return markup('<div class="sm-patterns">{}</div>', joined(map(_button, names)))


def _button(name: str) -> Markup:
    source = _PICTURES.get(name)
    picture = (
        markup('<img class="sm-picture" src="{}" alt="">', source)
        if source
        else markup('<span class="sm-picture"></span>')
    )
    pattern = read_pattern(name)
    words = f"{pattern.name}, {pattern.width} stitches by {pattern.height} rows"
    return markup(
        '<button type="button" data-action="pattern" data-value="{}" aria-label="{}" title="{}">{}{}</button>',
        name, words, words, picture, name.replace("-", " "),
    )
