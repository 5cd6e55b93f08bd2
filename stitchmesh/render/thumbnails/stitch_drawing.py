# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Small drawings of stitches as SVG: the yarn of one stitch, and of the loops below and above it.

The curves are those from which yarns are generated (``yarngen.templates``), seen from the right side of the fabric.
They are cut into short strokes. The strokes that lie over no other yarn are drawn first. The others follow from the
rearmost to the foremost stroke, each with a margin in the colour of the ground, so that the front yarn visibly passes
over the yarn behind it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh import FloatArray
from stitchmesh.mesh.palette import colour_text, linear_colour
from stitchmesh.mesh.stitch import SIDE_COUNTS, Stitch
from stitchmesh.render.palette import stitch_colour
from stitchmesh.yarngen.templates.table import template
from stitchmesh.yarngen.templates.template import STITCH_HEIGHT, TemplatePart

OWN = "#1b1815"
"""Colour of the yarn of the stitch's own row, black."""
OTHER_ON_PALE, OTHER = "#8b5a2b", "#fffaf0"
"""Colours of the loops on which the stitch is worked: brown on a pale ground and white on others. Ground and yarns thus
differ in lightness, which does not depend on the perception of hues."""
STROKES_PER_WIDTH = 8.0
"""Number of strokes into which a curve of one stitch width is cut."""
THICKNESS = 0.19
"""Width of the yarn in the drawing; it is less than that of real yarn, so that the ground separates the strands."""
MARGIN = 0.06
"""Margin of a stroke on either side [stitch widths]."""
CROSSING = 0.6
"""Smallest difference of the heights of two strokes that cross [yarn radii]; with less, they are one continuous
strand."""
UNIT = 100
"""Units of the drawing in a stitch width; coordinates are whole numbers."""
BESIDE, BELOW, ABOVE = 0.12, 0.42, 0.62
"""Widths beside the stitch, and heights below and above it, that the drawing shows [stitch widths]."""
SIDES = {Stitch.CAST_ON: (0, 1), Stitch.DRAW_THROUGH: (1, 0), Stitch.BIND_OFF: (1, 0)}
"""Numbers of bottom and top sides in the drawing of stitches that may have any number."""


@dataclass(frozen=True, eq=False)
class _Stroke:
    """A short piece of a curve."""

    points: FloatArray
    """Points (x, y, height), shape (n, 3)."""
    is_own: bool
    """Whether the yarn belongs to the stitch's own row."""


@lru_cache(maxsize=128)
def draw_stitch(stitch: Stitch, size: int = 40) -> Markup:
    """Return a drawing of a stitch as the text of an SVG element, on a ground of the colour of the stitch.

    Args:
        stitch: a stitch that has yarn.
        size: width and height [pixels].

    Raises:
        ParameterError: the stitch is a panel, which has no yarn.
    """
    if stitch == Stitch.PANEL:
        raise ParameterError("draw_stitch: got a panel, which has no yarn; expected a stitch")
    low, high = SIDES.get(stitch) or SIDE_COUNTS[stitch]
    widest = max(low, high, 1)
    ground = colour_text(stitch_colour(stitch))
    other = OTHER_ON_PALE if _luminance(stitch_colour(stitch)) > 0.5 else OTHER
    extent = max(widest + 2 * BESIDE, STITCH_HEIGHT + BELOW + ABOVE)
    left, upper = widest / 2 - extent / 2, -(STITCH_HEIGHT + ABOVE - BELOW + extent) / 2
    x, y, side = (round(UNIT * value) for value in (left, upper, extent))
    return markup(
        '<svg xmlns="http://www.w3.org/2000/svg" width="{}" height="{}" viewBox="{} {} {} {}">'
        '<rect x="{}" y="{}" width="{}" height="{}" fill="{}"/>'
        '<g fill="none" stroke-linejoin="round" stroke-linecap="round" stroke-width="{}">{}</g></svg>',
        size, size, x, y, side, side, x, y, side, side, ground,
        f"{UNIT * THICKNESS:.0f}", _lines(_strokes(stitch, low, high), ground, other),
    )


def _luminance(colour: tuple[int, int, int]) -> float:
    """Return the relative luminance of an sRGB colour, from 0 to 1 (IEC 61966-2-1)."""
    return float(linear_colour(np.asarray(colour) / 255) @ [0.2126, 0.7152, 0.0722])


def _strokes(stitch: Stitch, low: int, high: int) -> list[_Stroke]:
    """Return the strokes of a stitch: its own, those of the legs below it, and those of the heads above it."""
    widest = max(low, high)
    parts = [(part, 0.0, 0.0, not part.is_head) for part in template(stitch, low, high).parts]
    plain = template(Stitch.KNIT, 1, 1).parts
    for loop in range(low):
        parts += [(part, (widest - low) / 2 + loop, -STITCH_HEIGHT, False) for part in plain if not part.is_head]
    slipped = {part.end.place for part in template(stitch, low, high).parts if part.is_head and part.end.place > low}
    for loop in range(high):
        own = low + high - loop not in slipped
        parts += [(part, (widest - high) / 2 + loop, STITCH_HEIGHT, own) for part in plain if part.is_head]
    return [stroke for part, x, y, own in parts for stroke in _cut(part, np.array([x, y, 0.0]), own)]


def _cut(part: TemplatePart, offset: FloatArray, is_own: bool) -> list[_Stroke]:
    """Cut a part into strokes of about equal length; neighbouring strokes share a point."""
    count = max(round(part.length * STROKES_PER_WIDTH), 2)
    places = np.linspace(0, len(part.curve) - 1, 2 * count + 1).round().astype(np.int64)
    points = part.curve[places] + offset
    return [_Stroke(points[first : first + 3], is_own) for first in range(0, 2 * count, 2)]


def _lines(strokes: list[_Stroke], ground: str, other: str) -> Markup:
    """Return the lines of all strokes, from the rearmost to the foremost stroke."""
    height = np.array([stroke.points[:, 2].mean() for stroke in strokes])
    over = _lies_over(strokes, height)
    lines = [_core(np.concatenate(run), OWN if is_own else other) for run, is_own in _runs(strokes, ~over)]
    for number in np.argsort(height, kind="stable").tolist():
        if over[number]:
            stroke = strokes[number]
            margin = '<path d="{}" stroke="{}" stroke-width="{}" stroke-linecap="butt"/>'
            lines.append(markup(margin, _path(stroke.points), ground, f"{UNIT * (THICKNESS + 2 * MARGIN):.0f}"))
            lines.append(_core(stroke.points, OWN if stroke.is_own else other))
    return joined(lines)


def _lies_over(strokes: list[_Stroke], height: FloatArray) -> NDArray[np.bool_]:
    """Return whether each stroke covers a part of a stroke that lies clearly lower, shape (n,)."""
    middle = np.stack([stroke.points[1, :2] for stroke in strokes])
    apart = np.linalg.norm(middle[:, None] - middle[None], axis=2)
    near = apart < THICKNESS + MARGIN + 1.0 / STROKES_PER_WIDTH
    covers: NDArray[np.bool_] = (near & (height[:, None] - height[None] > CROSSING)).any(axis=1)
    return covers


def _runs(strokes: list[_Stroke], chosen: NDArray[np.bool_]) -> list[tuple[list[FloatArray], bool]]:
    """Return the points of the chosen strokes, joined where one continues another, and whose yarn each run is."""
    runs: list[tuple[list[FloatArray], bool]] = []
    for stroke, wanted in zip(strokes, chosen, strict=True):
        goes_on = runs and runs[-1][1] == stroke.is_own and np.array_equal(runs[-1][0][-1][-1], stroke.points[0])
        if wanted and goes_on:
            runs[-1][0].append(stroke.points[1:])
        elif wanted:
            runs.append(([stroke.points], stroke.is_own))
    return runs


def _core(points: FloatArray, ink: str) -> Markup:
    return markup('<path d="{}" stroke="{}"/>', _path(points), ink)


def _path(points: FloatArray) -> str:
    """Return the path of a polyline: its first point, and the step to each further point."""
    place = np.rint(points[:, :2] * [UNIT, -UNIT]).astype(np.int64)
    steps = "".join(f"l{x},{y}" for x, y in np.diff(place, axis=0).tolist())
    return f"M{place[0, 0]},{place[0, 1]}{steps}"
