# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitch templates: the yarn parts of one stitch face on a flat polygon.

A template lies in a trapezoid. Each bottom and top side is one stitch wide, and the wale sides are straight. A point is
(x, y) in stitch widths and a height in yarn radii; the height is positive towards the right side of the fabric. Yarn
crosses the sides of all faces at the same positions and at height zero, so that any two stitches fit together: course
sides at a quarter and at three quarters of their length, wale sides at a ninth of their length from below, where the
foot of a loop leads to the next stitch.

The two legs of a twisted loop on top of a face cross below the top side. Without twist, the two legs at the same arc
length below the side are at ``m - d`` and ``m + d``. With a twist t of 1 or -1 they are at

    m -/+ (d cos a - t b n sin a),   a = pi at the side, 0 at the lower end of the turn and below,

where n is the normal of the face and b is half the distance of the legs where they cross. The legs make half a turn
around each other, so each leg arrives at the place of the other one (Yuksel et al. 2012, section 4.2, k1 and y-1 of
figures 4 and 5).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from stitchmesh.mesh import FloatArray

STITCH_HEIGHT = 4.5 / (2 * np.pi)
"""Course spacing of the plain loop [stitch widths]."""
FOOT_SHARE = 0.5 / 4.5
"""Height at which the yarn of a row crosses a wale side, over the length of the side."""
RADIUS_OVER_WIDTH = 1 / 8
"""Yarn radius for which the heights of the templates are designed [stitch widths]."""
CURVE_POINTS = 200
"""Number of points of the dense curve of a part, before the part is resampled."""
LONGEST_TURN = 0.5
"""Largest arc length of the turn, from the top side down [stitch widths]."""
LARGEST_SHARE_OF_PART = 0.45
"""Largest fraction of a part that a turn uses; a part may have a turn at either end."""
HALF_GAP = 1.1
"""Distance of the crossing legs from their midline [radii]. At 1 the legs touch."""
TURN_POINTS = 80
"""Number of points along a turn."""


@dataclass(frozen=True)
class Crossing:
    """The place where a part crosses a side of its face."""

    place: int
    """Number of the side, counted from the lower left."""
    slot: int = 0
    """Slot of the crossing, counted along the direction of the side."""


@dataclass(frozen=True, eq=False)
class TemplatePart:
    """A piece of yarn between two crossings."""

    start: Crossing
    """Crossing at which the part starts."""
    end: Crossing
    """Crossing at which the part ends."""
    curve: FloatArray
    """Dense points (x, y, height) from the start to the end, shape (n, 3)."""
    is_head: bool
    """Whether the part belongs to the loop below (its head, or a leg that is slipped), and not to the row of the
    face."""

    @cached_property
    def _arc_lengths(self) -> FloatArray:
        """Arc length from the start to each point of the curve [stitch widths], shape (n,)."""
        steps = np.diff(self.curve * [1.0, 1.0, RADIUS_OVER_WIDTH], axis=0)
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps, axis=1))])

    @property
    def length(self) -> float:
        """Length in stitch widths."""
        return float(self._arc_lengths[-1])

    def resampled(self, count: int) -> FloatArray:
        """``count`` points at equal arc lengths, the first and the last half a step from the ends, shape (count, 3)."""
        return self._at((np.arange(count) + 0.5) / count * self.length)

    def end_stretch(self, crossing: Crossing, length: float, count: int) -> FloatArray:
        """The last stretch of the part before a crossing.

        Args:
            crossing: the start or the end of the part.
            length: arc length of the stretch [stitch widths].
            count: number of points.

        Returns:
            Points at equal arc lengths, the last one at the crossing, shape (count, 3).
        """
        arc_lengths = np.linspace(self.length - length, self.length, count)
        return self._at(arc_lengths if crossing == self.end else self.length - arc_lengths)

    def with_end_replaced(
        self, crossing: Crossing, length: float, end_stretch: FloatArray, to: Crossing
    ) -> TemplatePart:
        """The part with its last stretch before a crossing replaced.

        Args:
            crossing: the crossing at which the part ends before the replacement.
            length: arc length of the stretch that is replaced [stitch widths].
            end_stretch: points of the new stretch towards the crossing ``to``, shape (n, 3).
            to: the crossing at which the part ends afterwards.
        """
        if crossing == self.end:
            kept = self.curve[self._arc_lengths < self.length - length]
            return replace(self, end=to, curve=np.concatenate([kept, end_stretch]))
        kept = self.curve[self._arc_lengths > length]
        return replace(self, start=to, curve=np.concatenate([end_stretch[::-1], kept]))

    def _at(self, arc_lengths: FloatArray) -> FloatArray:
        """Points at the given arc lengths [stitch widths], shape (n, 3)."""
        return np.stack([np.interp(arc_lengths, self._arc_lengths, axis) for axis in self.curve.T], axis=1)


@dataclass(frozen=True, eq=False)
class Template:
    """All yarn parts of one kind of stitch face."""

    n_bottom: int
    """Number of bottom sides of the face."""
    n_top: int
    """Number of top sides of the face."""
    parts: tuple[TemplatePart, ...]
    """The yarn parts."""

    @cached_property
    def polygon(self) -> FloatArray:
        """Corners of the face from the lower left [stitch widths], shape (n_bottom + n_top + 2, 2)."""
        return trapezoid(self.n_bottom, self.n_top)


def trapezoid(n_bottom: int, n_top: int) -> FloatArray:
    """Corners of a flat face from the lower left [stitch widths], shape (n_bottom + n_top + 2, 2).

    A course without loops is a single corner.
    """
    widest = max(n_bottom, n_top)
    low = (widest - n_bottom) / 2 + np.arange(n_bottom + 1)
    high = ((widest - n_top) / 2 + np.arange(n_top + 1))[::-1]
    corners = [(x, 0.0) for x in low] + [(x, STITCH_HEIGHT) for x in high]
    return np.array(corners)


def bottom(loop: int, slot: int) -> Crossing:
    """Crossing of a bottom side. Loops are counted from left to right; slot 0 is the left crossing of the side."""
    return Crossing(loop, slot)


def top(n_bottom: int, n_top: int, loop: int, slot: int) -> Crossing:
    """Crossing of a top side. Loops are counted from left to right; slot 0 is the left crossing of the side.

    The side itself runs from right to left, so its slots in ``Crossing`` are exchanged.
    """
    return Crossing(n_bottom + n_top - loop, 1 - slot)


def right_wale(n_bottom: int) -> Crossing:
    """Crossing of the right wale side."""
    return Crossing(n_bottom)


def left_wale(n_bottom: int, n_top: int) -> Crossing:
    """Crossing of the left wale side."""
    return Crossing(n_bottom + n_top + 1)


def crossing_point(n_bottom: int, n_top: int, crossing: Crossing) -> tuple[float, float, float]:
    """Position (x, y, 0) of a crossing [stitch widths]."""
    corners = trapezoid(n_bottom, n_top)
    start, end = corners[crossing.place], corners[(crossing.place + 1) % len(corners)]
    if crossing.place == n_bottom:
        share = FOOT_SHARE
    elif crossing.place == n_bottom + n_top + 1:
        share = 1.0 - FOOT_SHARE
    else:
        share = 0.25 + 0.5 * crossing.slot
    x, y = start + share * (end - start)
    return float(x), float(y), 0.0


def spline_part(
    n_bottom: int, n_top: int, start: Crossing, end: Crossing, waypoints: Sequence[tuple[float, float, float]],
    *, is_head: bool = False,
) -> TemplatePart:  # fmt: skip
    """A part along a natural cubic spline through waypoints between two crossings.

    Args:
        n_bottom: bottom sides of the face.
        n_top: top sides of the face.
        start: crossing at the start.
        end: crossing at the end.
        waypoints: x in stitch widths, distance from the bottom over the height of the face, height in yarn radii.
        is_head: whether the part belongs to the loop below.
    """
    inner = [(x, v * STITCH_HEIGHT, h) for x, v, h in waypoints]
    ends = crossing_point(n_bottom, n_top, start), crossing_point(n_bottom, n_top, end)
    points = np.array([ends[0], *inner, ends[1]])
    arc_lengths = centripetal_parameters(points)
    curve = CubicSpline(arc_lengths, points, bc_type="natural")(np.linspace(0.0, arc_lengths[-1], CURVE_POINTS))
    return TemplatePart(start, end, curve, is_head)


def centripetal_parameters(points: FloatArray) -> FloatArray:
    """Centripetal parameters, shape (n,), of a spline through (x, y, height) points; they prevent extra loops."""
    chord = np.linalg.norm(np.diff(points * [1.0, 1.0, RADIUS_OVER_WIDTH], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(chord**0.5)])


def mirrored(template: Template) -> Template:
    """The template mirrored from left to right. The row of the mirrored template still runs from left to right."""
    nb, nt = template.n_bottom, template.n_top
    widest = max(nb, nt)
    parts = []
    for part in reversed(template.parts):
        ends = _mirror_crossing(part.start, nb, nt), _mirror_crossing(part.end, nb, nt)
        curve = part.curve * [-1.0, 1.0, 1.0] + [widest, 0.0, 0.0]
        if not (part.is_head and part.end.place > nb):  # the legs of a slipped loop keep their upward direction
            ends, curve = ends[::-1], curve[::-1]
        parts.append(TemplatePart(*ends, curve, part.is_head))
    return Template(nb, nt, tuple(parts))


def _mirror_crossing(crossing: Crossing, nb: int, nt: int) -> Crossing:
    """The crossing at the mirrored place of a face with ``nb`` bottom and ``nt`` top sides."""
    if crossing.place == nb:
        return Crossing(left_wale(nb, nt).place, crossing.slot)
    if crossing.place == nb + nt + 1:
        return Crossing(right_wale(nb).place, crossing.slot)
    if crossing.place < nb:
        return Crossing(nb - 1 - crossing.place, 1 - crossing.slot)
    return Crossing(2 * nb + nt + 1 - crossing.place, 1 - crossing.slot)


def turned_over(template: Template) -> Template:
    """The template with reversed heights, which turns knit into purl."""
    turned = [1.0, 1.0, -1.0]
    parts = tuple(TemplatePart(part.start, part.end, part.curve * turned, part.is_head) for part in template.parts)
    return Template(template.n_bottom, template.n_top, parts)


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
