# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The left panel: the palette of stitches, of yarns, or of patterns, as the tool needs it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.html_pieces import action_button
from stitchmesh.app.pages.edit.brush_tools import PaintYarns
from stitchmesh.app.pages.edit.edit_session import EditSession
from stitchmesh.app.pages.edit.laying import LayPatterns
from stitchmesh.app.pages.edit.pattern_palette import PatternPalette
from stitchmesh.app.pages.edit.stitch_palette import chosen_stitch_html, stitch_palette_html
from stitchmesh.app.pages.edit.tool import Tool
from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting.words import stitch_named
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.palette import LAST_YARN, check_yarn_number, colour_text, colours_of
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns.language.writing import format_pattern
from stitchmesh.patterns.library import pattern_names

MOST_SHOWN = 64
"""Largest number of yarns in the palette."""


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
    count = min(max(int(fabric.yarn.max()) + 2, len(fabric.palette), chosen + 1, 4), LAST_YARN + 1, MOST_SHOWN)
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
