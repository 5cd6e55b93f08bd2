# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The palette of yarns: a button with the colour of each yarn of the fabric, and of one yarn more."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.controls.html_pieces import action_button
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.palette import LAST_YARN, colour_text, colours_of

MOST_SHOWN = 64
"""Largest number of yarns in the palette."""


def yarn_colour(fabric: StitchMesh, yarn: int) -> str:
    """Return the colour of a yarn as ``#rrggbb``."""
    return colour_text(colours_of(np.array([yarn]), fabric.palette)[0])


def yarn_palette_html(fabric: StitchMesh, chosen: int) -> Markup:
    """Return the palette as HTML; the action is ``yarn`` with the number of the yarn."""
    count = min(max(int(fabric.yarn.max()) + 2, len(fabric.palette), chosen + 1, 4), LAST_YARN + 1, MOST_SHOWN)
    used = np.bincount(fabric.yarn, minlength=count)
    buttons = joined(_button(fabric, yarn, int(used[yarn]), yarn == chosen) for yarn in range(count))
    return markup('<div style="display:flex;flex-wrap:wrap;gap:4px">{}</div>', buttons)


def _button(fabric: StitchMesh, yarn: int, used: int, chosen: bool) -> Markup:
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
