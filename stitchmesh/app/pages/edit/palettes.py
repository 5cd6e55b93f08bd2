# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The left panel: the palette of stitches, of yarns, or of patterns, as the tool needs it.

The patterns of the library stand in families. A search keeps the patterns whose names hold its words. A thumbnail takes
some hundredths of a second. The palette of patterns therefore first appears with names alone. The thumbnails then
follow one after another, each in an event of its own, so that the page still answers.
"""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping
from functools import cache
from urllib.parse import quote

import numpy as np

from stitchmesh.app.controls.controls import Control, Controls
from stitchmesh.app.controls.html_pieces import action_button
from stitchmesh.app.pages.edit.brush_tools import PaintYarns
from stitchmesh.app.pages.edit.edit_session import EditSession, name_of
from stitchmesh.app.pages.edit.laying import LayPatterns
from stitchmesh.app.pages.edit.tool import Tool
from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting.words import stitch_named, stitch_word
from stitchmesh.markup import Markup, css_text, joined, markup
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.palette import LAST_YARN, check_yarn_number, colour_text, colours_of
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.patterns.language.writing import format_pattern
from stitchmesh.patterns.library import FAMILIES, family_of, pattern_names, read_pattern
from stitchmesh.patterns.pattern import Pattern
from stitchmesh.render.thumbnails.pattern_thumbnail import pattern_thumbnail
from stitchmesh.render.thumbnails.stitch_drawing import draw_stitch

STITCHES_BY_FAMILY: dict[str, str] = {
    "Plain, slipped, first and last": "k p y b f x cast-on draw-through",
    "Increases": "ky yk py yp kp pk kyk kpk yky pyp pkp ypy kpy ykp pky ypk",
    "Decreases of two": "d12k d21k d12p d21p",
    "Decreases of three": "d123k d132k d213k d231k d312k d321k d123p d132p d213p d231p d312p d321p",
    "Kept loops and tucks": "sk ks sp ps sy ys",
}
"""The stitches of the palette by family, as codes."""
STITCH_STYLE = markup("""<style>
.sm-palette{display:flex;flex-wrap:wrap;gap:3px;margin:0 0 .5em}
.sm-palette button{padding:2px;border:2px solid transparent;border-radius:6px;background:none;cursor:pointer;
 font:inherit;font-size:.68em;line-height:1.15;color:var(--mantine-color-text);min-width:48px}
.sm-palette button:hover{border-color:var(--mantine-color-default-border)}
.sm-palette button:focus-visible{outline:3px solid #e08a1e;outline-offset:1px}
.sm-palette img{display:block;margin:0 auto 1px;border-radius:4px}
.sm-palette-title{margin:.1em 0 .15em;font-size:.8em;font-weight:600}
</style>""")


def described(stitch: Stitch) -> str:
    """Return how a stitch is made, in words."""
    if stitch in VOCABULARY:
        return VOCABULARY[stitch].instruction
    return {Stitch.CAST_ON: "cast on: loops without loops below", Stitch.DRAW_THROUGH: "draw the yarn through"}[stitch]


@cache
def stitch_palette_html() -> Markup:
    """Return the palette as HTML; the action is ``stitch`` with the name of the stitch."""
    parts = [STITCH_STYLE]
    for family, names in STITCHES_BY_FAMILY.items():
        buttons = joined(_button(name) for name in names.split())
        parts.append(markup('<p class="sm-palette-title">{}</p><div class="sm-palette">{}</div>', family, buttons))
    return joined(parts)


def chosen_stitch_html(stitch: Stitch) -> Markup:
    """Return the chosen stitch with a larger drawing, and mark its button in the palette."""
    words = markup("<b>{}</b><br>{}", stitch_word(stitch, right_side=True), described(stitch))
    row = "display:flex;gap:.6em;align-items:center;font-size:.85em;line-height:1.3;margin:0 0 .3em"
    return markup(
        '<style>.sm-palette button[data-value="{}"]{{border-color:#2f8fc4;background:#2f8fc433}}</style>'
        '<div style="{}" role="status">{}<span>{}</span></div>',
        css_text(name_of(stitch)), row, picture_of(stitch, 56), words,
    )


@cache
def picture_of(stitch: Stitch, size: int) -> Markup:
    """Return the drawing of a stitch as an image, because an image is one node of the page for all its lines."""
    data = quote(draw_stitch(stitch), safe="/:=<>' ")
    source = f"data:image/svg+xml,{data}".replace("<", "%3C").replace(">", "%3E")
    return markup('<img src="{}" width="{}" height="{}" alt="">', source, size, size)


def _short(word: str) -> str:
    """Return the abbreviation of a stitch for the space under its drawing."""
    return word.removesuffix(" in 1 st").strip("()").replace(", ", " ")


def _button(name: str) -> Markup:
    stitch = stitch_named(name)
    word = stitch_word(stitch, right_side=True)
    words = f"{word}: {described(stitch)}"
    content = markup("{}{}", picture_of(stitch, 40), _short(word))
    return action_button("stitch", name, content, name=words, hint=words)


OWN = "Your own"
"""Title of the patterns of the user."""
PATTERN_STYLE = markup("""<style>
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
        """Make the buttons; ``post`` calls a function after other events, and ``chosen`` gets the name of a pattern."""
        self._post, self._own, self._words = post, own, ""
        self._families = [(OWN, tuple(own)), *_families_of_library()]
        self._mark = controls.html(PATTERN_STYLE)
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
        self._mark.content = PATTERN_STYLE + (markup(CHOSEN, css_text(name)) if name else Markup())

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
    family = {name: family_of(read_pattern(name)) for name in pattern_names()}
    return [(title, tuple(name for name in family if family[name] == title)) for title in FAMILIES]


def _source(pattern: Pattern) -> str:
    return "data:image/png;base64," + base64.b64encode(pattern_thumbnail(pattern, 72)).decode("ascii")




class Palettes:
    """Shows one of the three palettes."""

    def __init__(
        self, session: EditSession, controls: Controls, take_stitch: Callable[[Stitch], object],
        take_yarn: Callable[[int], object], laying: Tool,
    ) -> None:  # fmt: skip
        """Make the palettes; each function is called with the user's choice."""
        self._session, self._take_stitch, self._take_yarn = session, take_stitch, take_yarn
        self._stitch = controls.html(Markup())
        self._stitches = controls.html(stitch_palette_html(), lambda _, name: self._stitch_taken(name))
        self._yarns = controls.html(Markup(), lambda _, number: self._yarn_taken(number))
        colour = yarn_colour(session.fabric, session.state.yarn)
        self._colour = controls.colour("Colour of the yarn", "Colour that the chosen yarn gets", colour)
        self._recolour = controls.button("Set the colour", "Give the chosen yarn this colour everywhere",
                                         self._set_colour)  # fmt: skip
        assert isinstance(laying, LayPatterns)
        self._laying = laying
        self._patterns = PatternPalette(controls, self._pattern_taken, session.app.post, session.patterns.all)
        session.patterns.on_change = lambda: self._patterns.show_own(session.patterns.all)
        self.refresh()

    def show_for(self, tool: str) -> None:
        """Show the palette that a tool needs."""
        yarns, patterns = tool == PaintYarns.name, tool == LayPatterns.name
        for control in (self._yarns, self._colour, self._recolour):
            control.visible = yarns
        self._patterns.visible = patterns
        self._stitch.visible = self._stitches.visible = not (yarns or patterns)
        self.refresh()

    def refresh(self) -> None:
        """Show the choices, and the yarns of the fabric."""
        session = self._session
        self._stitch.content = chosen_stitch_html(session.state.stitch)
        self._yarns.content = yarn_palette_html(session.fabric, session.state.yarn)
        self._patterns.show_chosen(self._laying.pattern if "\n" not in self._laying.pattern else "")

    def close(self) -> None:
        """Stop drawing thumbnails."""
        self._patterns.close()

    def _stitch_taken(self, name: str) -> None:
        self._take_stitch(stitch_named(name))
        self.refresh()

    def _yarn_taken(self, number: str) -> None:
        if not number.isdecimal():
            raise ParameterError(f"yarn: got {number[:40]!r}; expected the number of a yarn")
        self._take_yarn(check_yarn_number(int(number)))
        self._colour.value = yarn_colour(self._session.fabric, self._session.state.yarn)
        self.refresh()

    def _pattern_taken(self, name: str) -> None:
        # A browser must not make the server read a file by its name.
        own = self._session.patterns.all
        if name not in own and name not in pattern_names():
            raise ParameterError(f"pattern {name[:40]!r}: is not in the library; choose one of the palette")
        self._laying.choose(format_pattern(own[name]) if name in own else name)
        self.refresh()

    def _set_colour(self) -> None:
        self._session.edit("recolour", {"yarn": self._session.state.yarn, "colour": str(self._colour.value)})


def yarn_colour(fabric: StitchMesh, yarn: int) -> str:
    """Return the colour of a yarn as ``#rrggbb``."""
    return colour_text(colours_of(np.array([yarn]), fabric.palette)[0])


def yarn_palette_html(fabric: StitchMesh, chosen: int) -> Markup:
    """Return the palette as HTML; the action is ``yarn`` with the number of the yarn."""
    count = min(max(int(fabric.yarn.max()) + 2, len(fabric.palette), chosen + 1, 4), LAST_YARN + 1, 64)
    used = np.bincount(fabric.yarn, minlength=count)
    buttons = joined(_yarn_button(fabric, yarn, int(used[yarn]), yarn == chosen) for yarn in range(count))
    return markup('<div style="display:flex;flex-wrap:wrap;gap:4px">{}</div>', buttons)


def _yarn_button(fabric: StitchMesh, yarn: int, used: int, chosen: bool) -> Markup:
    colour = yarn_colour(fabric, yarn)
    words = f"Yarn {yarn}, {colour}, {used} stitches"
    border = "3px solid #2f8fc4" if chosen else "1px solid var(--mantine-color-default-border)"
    swatch = markup(
        '<span style="display:block;width:34px;height:22px;border-radius:4px;background:{}"></span>',
        colour,
    )
    style = (
        f"padding:2px;border:{border};border-radius:6px;background:none;cursor:pointer;font:inherit;font-size:.75em;"
        "color:var(--mantine-color-text)"
    )
    content = markup("{}{}", swatch, yarn)
    return action_button("yarn", yarn, content, name=words, hint=words, pressed=chosen, style=style)
