# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Twisted loops: the two legs of a loop on top of a face cross below the top side.

At the same arc length below the side the legs run at ``m - d`` and ``m + d``. Twisted by t, 1 or -1, they run at

    m -/+ (d cos a - t b n sin a),   a = pi at the side, 0 at the end of the turn and below,

with n the normal of the face and b half their distance where they cross: half a turn about one another, by which
each leg arrives in the other's place (Yuksel et al. 2012, section 4.2, k1 and y-1 of figures 4 and 5).
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.yarngen.templates.template import Crossing, Part, Template, top

LONGEST_TURN = 0.5
"""Arc length of the turn, from the top side down [stitch widths]."""
LARGEST_SHARE_OF_PART = 0.45
"""A turn takes at most this share of a part, which may have one at either end."""
HALF_GAP = 1.1
"""Distance of the crossing legs from their midline [radii]; at 1 they touch."""
TURN_POINTS = 80
"""Points along a turn."""


def twisted(template: Template, twists: tuple[int, ...]) -> Template:
    """The template with the loops on its top sides twisted.

    Args:
        template: any stitch whose top sides yarn crosses.
        twists: half turns of the loops from left to right, -1, 0 or 1; at 1 the leg that comes from the left lies in
            front where the legs cross.
    """
    parts = list(template.parts)
    for loop, turn in enumerate(twists):
        if turn:
            slots = [top(template.n_bottom, template.n_top, loop, slot) for slot in (0, 1)]
            _twist_loop(parts, slots, turn)
    return Template(template.n_bottom, template.n_top, tuple(parts))


def _twist_loop(parts: list[Part], slots: list[Crossing], turn: int) -> None:
    """Turn the two legs that end in ``slots``, left and right, about one another."""
    left, right = ([slot in (part.start, part.end) for part in parts].index(True) for slot in slots)
    length = min(LONGEST_TURN, LARGEST_SHARE_OF_PART * parts[left].length, LARGEST_SHARE_OF_PART * parts[right].length)
    legs = (
        parts[left].end_stretch(slots[0], length, TURN_POINTS),
        parts[right].end_stretch(slots[1], length, TURN_POINTS),
    )
    share = np.linspace(0.0, 1.0, TURN_POINTS)[:, None]
    angle = turn_angle(share)
    middle, across = (legs[0] + legs[1]) / 2, (legs[1] - legs[0]) / 2
    offset = across * np.cos(angle) - turn * HALF_GAP * np.sin(angle) * [0.0, 0.0, 1.0]
    parts[left] = parts[left].with_end_replaced(slots[0], length, middle - offset, slots[1])
    parts[right] = parts[right].with_end_replaced(slots[1], length, middle + offset, slots[0])


def turn_angle(share: FloatArray) -> FloatArray:
    """Angle of a turn at each share of its length, from zero at its lower end to half a turn, level at both."""
    return np.pi * share**2 * (3.0 - 2.0 * share)
