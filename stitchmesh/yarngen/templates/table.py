# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The template table: how the yarn runs in each kind of stitch.

A stitch is drawn, or it is the mirror image of one that is, or that one turned over, or both.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache

from stitchmesh.errors import YarnError
from stitchmesh.mesh import stitch as symmetry
from stitchmesh.mesh.stitch import CODES, SIDE_COUNTS, VOCABULARY, Stitch
from stitchmesh.yarngen.templates.drawings import drawings, template_from_drawing
from stitchmesh.yarngen.templates.edges import cast_on, draw_through
from stitchmesh.yarngen.templates.plain import knit
from stitchmesh.yarngen.templates.template import Template, mirrored, turned_over
from stitchmesh.yarngen.templates.twists import twisted

ANY_SIDES: dict[Stitch, Callable[[int, int], Template]] = {
    Stitch.CAST_ON: cast_on,
    Stitch.BIND_OFF: draw_through,
    Stitch.DRAW_THROUGH: draw_through,
}
"""Stitches drawn for the sides that their face has."""


@lru_cache(maxsize=1024)
def template(stitch: Stitch, n_bottom: int, n_top: int, twists: tuple[int, ...] = ()) -> Template:
    """The yarn of a stitch on a face with these sides.

    Args:
        stitch: its type.
        n_bottom: bottom sides of the face.
        n_top: top sides of the face.
        twists: half turns of the loops on top, from left to right; none where shorter. Cast-on loops are twisted by
            nature, by 1 where not marked; what holds the last loops has none on top and leaves it unheeded.

    Raises:
        YarnError: the stitch has no template, or not on such a face.
    """
    if stitch == Stitch.CAST_ON:
        return cast_on(n_bottom, n_top, twists)
    if stitch in ANY_SIDES:
        return ANY_SIDES[stitch](n_bottom, n_top)
    if stitch not in VOCABULARY or SIDE_COUNTS[stitch] != (n_bottom, n_top):
        raise YarnError(
            f"stitch {stitch.name} on {n_bottom} bottom and {n_top} top sides: has no yarn; tessellate the mesh first, "
            "or choose a stitch that fits the face"
        )
    return twisted(_untwisted()[stitch], twists)


@cache
def _untwisted() -> dict[Stitch, Template]:
    """The template of every stitch whose face has fixed sides."""
    table = {Stitch.KNIT: knit()} | {
        CODES[code]: template_from_drawing(code, parts) for code, parts in drawings().items()
    }
    for stitch, shape in list(table.items()):
        table.setdefault(symmetry.mirrored(stitch), mirrored(shape))
    for stitch, shape in list(table.items()):
        table.setdefault(symmetry.turned_over(stitch), turned_over(shape))
    return table
