# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawings of stitches: waypoints of their yarn parts, read from ``drawings.json``.

Some stitches are mirror images of each other, or the same stitch turned over; one of them is drawn. The heads of the
loops below lie in the order that the code of the stitch gives. The yarn of the stitch's own row runs from loop to loop:

- A knit loop comes through the head below from behind and passes in front of its top; a purl loop does the opposite.
- Between a knit and a purl loop of one stitch the yarn passes through the head and once around its top.
- A yarn-over lies outside the head, on the side on which the neighbouring loops enter the head.
- Loops that are knitted together lie in layers, each completely in front of the next, so they are not linked.
- The two legs of a slipped loop continue upwards. The yarn of the row passes behind them, or once around them.

The waypoints come from rough drawings (``assets/stitches/rough.json``). A program (``assets/stitches/refine.py``) moved
them apart in small steps, none of which lets yarn pass through yarn.

Source: Yuksel et al. 2012, section 4.2, figures 4 and 5.
"""

from __future__ import annotations

import json
import re
from functools import cache
from importlib.resources import files
from typing import TypedDict

from stitchmesh.errors import YarnError
from stitchmesh.mesh.own_stitch import OwnStitch
from stitchmesh.mesh.stitch import CODES, VOCABULARY, Making
from stitchmesh.yarngen.templates.template import Crossing, Template, bottom, left_wale, right_wale, spline_part, top

Waypoint = tuple[float, float, float]
"""x in stitch widths, distance from the bottom over the height of the face, and height in yarn radii."""
SLOTS = {"left": 0, "right": 1}
"""Slot of a course side by its name in a drawing."""

_COURSE_CROSSING = re.compile(r"(bottom|top) (\d{1,2}) (left|right)")

# the functional form is needed because the keyword "from" cannot be a name in a class body
PartDrawing = TypedDict("PartDrawing", {"from": str, "to": str, "head": bool, "through": list[Waypoint]})
"""One yarn part: the crossings at its ends, whether it belongs to the loop below, and the waypoints between its
ends."""


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
