# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Twisted loops: the two legs of a loop on top of a face cross below the top side.

Without twist, the two legs at the same arc length below the side are at ``m - d`` and ``m + d``. With a twist t of 1 or
-1 they are at

    m -/+ (d cos a - t b n sin a),   a = pi at the side, 0 at the lower end of the turn and below,

where n is the normal of the face and b is half the distance of the legs where they cross. The legs make half a turn
around each other, so each leg arrives at the place of the other one (Yuksel et al. 2012, section 4.2, k1 and y-1 of
figures 4 and 5).
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.yarngen.templates.template import Crossing, Template, TemplatePart, top

LONGEST_TURN = 0.5
"""Largest arc length of the turn, from the top side down [stitch widths]."""
LARGEST_SHARE_OF_PART = 0.45
"""Largest fraction of a part that a turn uses; a part may have a turn at either end."""
HALF_GAP = 1.1
"""Distance of the crossing legs from their midline [radii]. At 1 they touch."""
TURN_POINTS = 80
"""Number of points along a turn."""


def twisted(template: Template, twists: tuple[int, ...]) -> Template:
    """The template with twisted loops on its top sides.

    Args:
        template: the template of a stitch with yarn on its top sides.
        twists: half turns of the loops from left to right, -1, 0 or 1. At 1 the leg from the left lies in front where
            the legs cross.
    """
    parts = list(template.parts)
    for loop, turn in enumerate(twists):
        if turn:
            slots = [top(template.n_bottom, template.n_top, loop, slot) for slot in (0, 1)]
            _twist_loop(parts, slots, turn)
    return Template(template.n_bottom, template.n_top, tuple(parts))


def _twist_loop(parts: list[TemplatePart], slots: list[Crossing], turn: int) -> None:
    """Turn the left and the right leg, which end at ``slots``, around each other; ``parts`` is changed in place."""
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
    """Angle of the turn at each fraction of its length [rad].

    It grows from zero at the lower end to pi, with zero slope at both ends.
    """
    return np.pi * share**2 * (3.0 - 2.0 * share)
