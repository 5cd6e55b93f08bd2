# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The template table: the yarn of each kind of stitch.

A stitch has a drawing of its own, or its template is a drawn template that is mirrored, turned over, or both. A drawing
holds the waypoints of the yarn parts and is read from ``drawings.json``. If stitches are mirror images of each other,
or the same stitch turned over, only one of them is drawn. The heads of the loops below lie in the order that the code
of the stitch gives. The yarn of the stitch's own row runs from loop to loop:

- A knit loop comes through the head below from behind and passes in front of its top; a purl loop does the opposite.
- Between a knit and a purl loop of one stitch the yarn passes through the head and once around its top.
- A yarn-over lies outside the head, on the side on which the neighbouring loops enter the head.
- Loops that are knitted together lie in layers, each completely in front of the next, so they are not linked.
- The two legs of a slipped loop continue upwards. The yarn of the row passes behind them, or once around them.

The waypoints come from rough drawings (``assets/stitches/rough.json``). A program (``assets/stitches/refine.py``) moved
them apart in small steps that never let yarn pass through yarn.

Source: Yuksel et al. 2012, section 4.2, figures 4 and 5.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import cache, lru_cache
from importlib.resources import files
from typing import TypedDict

from stitchmesh.errors import YarnError
from stitchmesh.mesh import stitch as symmetry
from stitchmesh.mesh.own_stitch import OwnStitch, StitchType
from stitchmesh.mesh.stitch import CODES, SIDE_COUNTS, VOCABULARY, Making, Stitch
from stitchmesh.yarngen.templates.edge_templates import cast_on, draw_through
from stitchmesh.yarngen.templates.plain import knit
from stitchmesh.yarngen.templates.template import (
    Crossing,
    Template,
    bottom,
    left_wale,
    mirrored,
    right_wale,
    spline_part,
    top,
    turned_over,
    twisted,
)

Waypoint = tuple[float, float, float]
"""x in stitch widths, distance from the bottom over the height of the face, and height in yarn radii."""
SLOTS = {"left": 0, "right": 1}
"""Slot of a course side by its name in a drawing."""

_COURSE_CROSSING = re.compile(r"(bottom|top) (\d{1,2}) (left|right)")

# the functional form is needed because the keyword "from" cannot be a name in a class body
PartDrawing = TypedDict("PartDrawing", {"from": str, "to": str, "head": bool, "through": list[Waypoint]})
"""One yarn part: the crossings at its ends, whether it belongs to the loop below, and the waypoints between its
ends."""
ANY_SIDES: dict[Stitch, Callable[[int, int], Template]] = {
    Stitch.CAST_ON: cast_on,
    Stitch.BIND_OFF: draw_through,
    Stitch.DRAW_THROUGH: draw_through,
}
"""Stitches whose template is computed for the number of sides of their face."""


@cache
def drawings() -> dict[str, list[PartDrawing]]:
    """The drawn yarn parts of each stitch, by the code of the stitch."""
    text = files("stitchmesh.yarngen.templates").joinpath("drawings.json").read_text()
    rows: dict[str, list[PartDrawing]] = json.loads(text)
    return rows


def template_of_own(stitch: OwnStitch) -> Template:
    """The template of a stitch of the user's own.

    Raises:
        YarnError: a part names a crossing that the face does not have.
    """
    parts: list[PartDrawing] = [
        {"from": part.start, "to": part.end, "head": part.head, "through": list(part.through)} for part in stitch.parts
    ]
    return template_from_parts(stitch.making, parts)


def template_from_drawing(code: str, parts: list[PartDrawing]) -> Template:
    """The template that a drawing describes.

    Args:
        code: code of the stitch; it determines the number of sides of the face.
        parts: the drawn yarn parts.
    """
    return template_from_parts(VOCABULARY[CODES[code]], parts)


def template_from_parts(definition: Making, parts: list[PartDrawing]) -> Template:
    """The template of drawn yarn parts.

    Args:
        definition: how the stitch is made; it determines the number of sides of the face.
        parts: the drawn yarn parts.

    Raises:
        YarnError: a part names a crossing that the face does not have.
    """
    n = definition.n_bottom, definition.n_top
    shapes = [
        spline_part(*n, _crossing(n, part["from"]), _crossing(n, part["to"]), part["through"], is_head=part["head"])
        for part in parts
    ]
    return Template(*n, tuple(shapes))


def _crossing(n: tuple[int, int], name: str) -> Crossing:
    """The crossing called ``left wale``, ``right wale``, ``bottom 2 left``, ``top 1 right``, counted from the left."""
    if name == "left wale":
        return left_wale(*n)
    if name == "right wale":
        return right_wale(n[0])
    match = _COURSE_CROSSING.fullmatch(name)
    row, loop, slot = match.groups() if match else ("", "0", "")
    if not 1 <= int(loop) <= n[row == "top"]:
        loops = f"bottom 1 to {n[0]} and top 1 to {n[1]}, left or right, and left wale and right wale"
        raise YarnError(f"crossing {name!r}: the face has no such crossing; it has {loops}")
    if row == "bottom":
        return bottom(int(loop) - 1, SLOTS[slot])
    return top(*n, int(loop) - 1, SLOTS[slot])


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
