# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The palette of stitches: a button with a drawing for each stitch, in families."""

from __future__ import annotations

from functools import cache
from urllib.parse import quote

from stitchmesh.app.controls.html_pieces import action_button
from stitchmesh.hand_knitting.words import stitch_name, stitch_named, stitch_word
from stitchmesh.markup import Markup, css_text, joined, markup
from stitchmesh.mesh.own_stitch import OwnStitch, StitchType
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.render.thumbnails.stitch_drawing import draw_stitch

FAMILIES: dict[str, str] = {
    "Plain, slipped, first and last": "k p y b f x cast-on draw-through",
    "Increases": "ky yk py yp kp pk kyk kpk yky pyp pkp ypy kpy ykp pky ypk",
    "Decreases of two": "d12k d21k d12p d21p",
    "Decreases of three": "d123k d132k d213k d231k d312k d321k d123p d132p d213p d231p d312p d321p",
    "Kept loops and tucks": "sk ks sp ps sy ys",
}
"""The stitches of the palette by family, as codes."""
"""Names of the stitches without a code."""
SIZE = 40
"""Width and height of a drawing [pixels]."""
STYLE = markup("""<style>
.sm-palette{display:flex;flex-wrap:wrap;gap:3px;margin:0 0 .5em}
.sm-palette button{padding:2px;border:2px solid transparent;border-radius:6px;background:none;cursor:pointer;
 font:inherit;font-size:.68em;line-height:1.15;color:var(--mantine-color-text);min-width:48px}
.sm-palette button:hover{border-color:var(--mantine-color-default-border)}
.sm-palette button:focus-visible{outline:3px solid #e08a1e;outline-offset:1px}
.sm-palette img{display:block;margin:0 auto 1px;border-radius:4px}
.sm-palette-title{margin:.1em 0 .15em;font-size:.8em;font-weight:600}
</style>""")


def name_of(stitch: StitchType) -> str:
    """Return the name that edits use for a stitch: its code, ``cast-on`` or ``draw-through``."""
    if isinstance(stitch, OwnStitch):
        return stitch.code
    return VOCABULARY[stitch].code if stitch in VOCABULARY else stitch_name(stitch)


def described(stitch: Stitch) -> str:
    """Return how a stitch is made, in words."""
    if stitch in VOCABULARY:
        return VOCABULARY[stitch].instruction
    return {Stitch.CAST_ON: "cast on: loops without loops below", Stitch.DRAW_THROUGH: "draw the yarn through"}[stitch]


@cache
def stitch_palette_html() -> Markup:
    """Return the palette as HTML; the action is ``stitch`` with the name of the stitch."""
    parts = [STYLE]
    for family, names in FAMILIES.items():
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
    content = markup("{}{}", picture_of(stitch, SIZE), _short(word))
    return action_button("stitch", name, content, name=words, hint=words)
