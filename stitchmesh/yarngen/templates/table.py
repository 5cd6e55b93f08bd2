# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The template table: the yarn of each kind of stitch.

A stitch has a drawing of its own, or its template is the mirror image of a drawn one, a drawn one turned over, or both.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache

from stitchmesh.errors import YarnError
from stitchmesh.mesh import stitch as symmetry
from stitchmesh.mesh.own_stitch import OwnStitch, StitchType
from stitchmesh.mesh.stitch import CODES, SIDE_COUNTS, VOCABULARY, Stitch
from stitchmesh.yarngen.templates.drawings import drawings, template_from_drawing, template_of_own
from stitchmesh.yarngen.templates.edges import cast_on, draw_through
from stitchmesh.yarngen.templates.plain import knit
from stitchmesh.yarngen.templates.template import Template, mirrored, turned_over
from stitchmesh.yarngen.templates.twists import twisted

ANY_SIDES: dict[Stitch, Callable[[int, int], Template]] = {
    Stitch.CAST_ON: cast_on,
    Stitch.BIND_OFF: draw_through,
    Stitch.DRAW_THROUGH: draw_through,
}
"""Stitches whose template is computed for the number of sides of their face."""


@lru_cache(maxsize=1024)
def template(stitch: StitchType, n_bottom: int, n_top: int, twists: tuple[int, ...] = ()) -> Template:
    """The yarn of a stitch on a face with the given numbers of sides.

    Args:
        stitch: type of the stitch.
        n_bottom: bottom sides of the face.
        n_top: top sides of the face.
        twists: half turns of the loops on top, from left to right; loops beyond the end of the tuple have none. Cast-on
            loops always cross, as at 1 if they have no mark. A yarn drawn through loops has no loops on top and ignores
            the twists.

    Raises:
        YarnError: the stitch has no template for such a face.
    """
    if isinstance(stitch, OwnStitch):
        return twisted(template_of_own(stitch), twists)
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
    """The template of every stitch whose face has a fixed number of sides, without twists."""
    table = {Stitch.KNIT: knit()} | {
        CODES[code]: template_from_drawing(code, parts) for code, parts in drawings().items()
    }
    for stitch, shape in list(table.items()):
        table.setdefault(symmetry.mirrored(stitch), mirrored(shape))
    for stitch, shape in list(table.items()):
        table.setdefault(symmetry.turned_over(stitch), turned_over(shape))
    return table
