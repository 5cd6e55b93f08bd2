# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The template table: how the yarn runs in each kind of stitch. A new stitch is a new line here."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from stitchmesh.errors import YarnError
from stitchmesh.stitch import SIDE_COUNTS, Stitch
from stitchmesh.yarngen.decreases import decrease_centre, decrease_left, decrease_right
from stitchmesh.yarngen.edges import cast_on, draw_through
from stitchmesh.yarngen.increases import knit_yarnover, knit_yarnover_knit, yarnover_knit
from stitchmesh.yarngen.plain import knit, purl
from stitchmesh.yarngen.template import Template

FIXED: dict[Stitch, Callable[[], Template]] = {
    Stitch.KNIT: knit,
    Stitch.PURL: purl,
    Stitch.KY: knit_yarnover,
    Stitch.YK: yarnover_knit,
    Stitch.KYK: knit_yarnover_knit,
    Stitch.D12K: decrease_left,
    Stitch.D21K: decrease_right,
    Stitch.D213K: decrease_centre,
}
"""Stitches that fix the sides of their face."""

ANY_SIDES: dict[Stitch, Callable[[int, int], Template]] = {
    Stitch.CAST_ON: cast_on,
    Stitch.BIND_OFF: draw_through,
    Stitch.DRAW_THROUGH: draw_through,
}
"""Stitches drawn for the sides that their face has."""


@lru_cache(maxsize=256)
def template(stitch: Stitch, n_bottom: int, n_top: int) -> Template:
    """The yarn of a stitch on a face with these sides.

    Raises:
        YarnError: the stitch has no template, or not on such a face.
    """
    if stitch in ANY_SIDES:
        return ANY_SIDES[stitch](n_bottom, n_top)
    if stitch not in FIXED or SIDE_COUNTS[stitch] != (n_bottom, n_top):
        raise YarnError(
            f"stitch {stitch.name} on {n_bottom} bottom and {n_top} top sides: has no yarn; tessellate the mesh first, "
            "or choose a stitch that fits the face"
        )
    return FIXED[stitch]()
