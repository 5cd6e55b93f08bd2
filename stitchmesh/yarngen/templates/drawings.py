# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawings of stitches: waypoints of their yarn parts, read from ``drawings.json``.

Of stitches that are mirror images of one another, or one another turned over, one is drawn. Its heads lie in the
order of its code; the yarn of its own row hooks from loop to loop:

- A knit loop comes through the head below from behind and passes in front of its top, a purl loop the other way.
- Between knit and purl the yarn goes through the head and once around its top.
- A yarn-over lies outside the head, on the side where the loops beside it go in.
- Loops knitted together lie in layers, one wholly in front of the other, so that they are not linked.
- A slipped loop's two legs go on upwards; the row's yarn passes behind them, or once around them.

The waypoints come from rough drawings (``assets/stitches/rough.json``), moved apart in small steps, none of which
lets yarn pass through yarn (``assets/stitches/refine.py``).

Source: Yuksel et al. 2012, section 4.2, figures 4 and 5.
"""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import TypedDict

from stitchmesh.mesh.stitch import CODES, VOCABULARY
from stitchmesh.yarngen.templates.template import Crossing, Template, bottom, left_wale, right_wale, spline_part, top

Waypoint = tuple[float, float, float]
"""x in stitch widths, share of the height, height in radii."""
SLOTS = {"left": 0, "right": 1}

# "from" is no name that a class body can hold
PartDrawing = TypedDict("PartDrawing", {"from": str, "to": str, "head": bool, "through": list[Waypoint]})
"""A part: its crossings, whether it is yarn of the loop below, and its waypoints in between."""


@cache
def drawings() -> dict[str, list[PartDrawing]]:
    """The drawn parts of each stitch by its code."""
    text = files("stitchmesh.yarngen.templates").joinpath("drawings.json").read_text()
    rows: dict[str, list[PartDrawing]] = json.loads(text)
    return rows


def template_from_drawing(code: str, parts: list[PartDrawing]) -> Template:
    """The template that a drawing describes.

    Args:
        code: of the stitch, which says how many sides its face has.
        parts: its drawn parts.
    """
    definition = VOCABULARY[CODES[code]]
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
    row, loop, slot = name.split()
    if row == "bottom":
        return bottom(int(loop) - 1, SLOTS[slot])
    return top(*n, int(loop) - 1, SLOTS[slot])
