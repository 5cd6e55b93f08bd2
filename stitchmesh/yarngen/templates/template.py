# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a stitch template is: the yarn parts in one stitch face, on a flat polygon with heights.

A template lies in a trapezoid: each bottom and top side is one stitch wide, the wale sides are straight. Positions
are (x, y) in stitch widths and a height in yarn radii, positive towards the right side of the fabric. Yarn crosses
the sides of a face at common places and at height zero, so that any two stitches join: course sides a quarter and
three quarters along, wale sides a ninth of the way up, where a foot passes from stitch to stitch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from stitchmesh.mesh import FloatArray

STITCH_HEIGHT = 4.5 / (2 * np.pi)
"""Course spacing of the plain loop in stitch widths."""
FOOT_SHARE = 0.5 / 4.5
"""How far up its wale side a face is entered by its row."""
RADIUS_OVER_WIDTH = 1 / 8
"""Yarn radius in stitch widths for which the heights of the templates are drawn."""
CURVE_POINTS = 200
"""Points by which the course of a part is drawn before it is divided evenly."""


@dataclass(frozen=True)
class Crossing:
    """Where a part meets a side: its place counted from the lower left, and 0 or 1 along the side's direction."""

    place: int
    slot: int = 0


@dataclass(frozen=True, eq=False)
class Part:
    """A piece of yarn between two crossings."""

    start: Crossing
    end: Crossing
    curve: FloatArray
    """Dense points (x, y, height) from crossing to crossing, shape (n, 3)."""
    is_head: bool
    """Whether it is yarn of the loop below, its head or a leg that is slipped, rather than of the face's own row."""

    @cached_property
    def _arc_lengths(self) -> FloatArray:
        steps = np.diff(self.curve * [1.0, 1.0, RADIUS_OVER_WIDTH], axis=0)
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps, axis=1))])

    @property
    def length(self) -> float:
        """Length in stitch widths."""
        return float(self._arc_lengths[-1])

    def resampled(self, count: int) -> FloatArray:
        """``count`` points at even arc length, half a step from the ends, shape (count, 3)."""
        return self._at((np.arange(count) + 0.5) / count * self.length)

    def end_stretch(self, crossing: Crossing, length: float, count: int) -> FloatArray:
        """The last stretch towards one of its ends: ``count`` points at even arc length, shape (count, 3)."""
        arc_lengths = np.linspace(self.length - length, self.length, count)
        return self._at(arc_lengths if crossing == self.end else self.length - arc_lengths)

    def with_end_replaced(self, crossing: Crossing, length: float, end_stretch: FloatArray, to: Crossing) -> Part:
        """The part whose last stretch towards ``crossing`` is replaced by one that leads elsewhere."""
        if crossing == self.end:
            kept = self.curve[self._arc_lengths < self.length - length]
            return replace(self, end=to, curve=np.concatenate([kept, end_stretch]))
        kept = self.curve[self._arc_lengths > length]
        return replace(self, start=to, curve=np.concatenate([end_stretch[::-1], kept]))

    def _at(self, arc_lengths: FloatArray) -> FloatArray:
        """Points at these arc lengths [stitch widths], shape (n, 3)."""
        return np.stack([np.interp(arc_lengths, self._arc_lengths, axis) for axis in self.curve.T], axis=1)


@dataclass(frozen=True, eq=False)
class Template:
    """All yarn parts of one kind of stitch face."""

    n_bottom: int
    n_top: int
    parts: tuple[Part, ...]

    @cached_property
    def polygon(self) -> FloatArray:
        """Corners of the face from the lower left, shape (n_bottom + n_top + 2, 2)."""
        return trapezoid(self.n_bottom, self.n_top)


def trapezoid(n_bottom: int, n_top: int) -> FloatArray:
    """Corners of a flat face from the lower left; a side without loops is one corner."""
    widest = max(n_bottom, n_top)
    low = (widest - n_bottom) / 2 + np.arange(n_bottom + 1)
    high = ((widest - n_top) / 2 + np.arange(n_top + 1))[::-1]
    corners = [(x, 0.0) for x in low] + [(x, STITCH_HEIGHT) for x in high]
    return np.array(corners)


def bottom(loop: int, slot: int) -> Crossing:
    """Crossing of a bottom side, counted left to right; slot 0 is its left one."""
    return Crossing(loop, slot)


def top(n_bottom: int, n_top: int, loop: int, slot: int) -> Crossing:
    """Crossing of a top side, counted left to right; slot 0 is its left one (the side itself runs leftwards)."""
    return Crossing(n_bottom + n_top - loop, 1 - slot)


def right_wale(n_bottom: int) -> Crossing:
    """Crossing of the right wale side."""
    return Crossing(n_bottom)


def left_wale(n_bottom: int, n_top: int) -> Crossing:
    """Crossing of the left wale side."""
    return Crossing(n_bottom + n_top + 1)


def crossing_point(n_bottom: int, n_top: int, crossing: Crossing) -> tuple[float, float, float]:
    """Where a crossing lies: (x, y, 0)."""
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
) -> Part:  # fmt: skip
    """A part drawn smoothly through waypoints (x, share of the height, height in radii) between two crossings."""
    inner = [(x, v * STITCH_HEIGHT, h) for x, v, h in waypoints]
    ends = crossing_point(n_bottom, n_top, start), crossing_point(n_bottom, n_top, end)
    points = np.array([ends[0], *inner, ends[1]])
    arc_lengths = centripetal_parameters(points)
    curve = CubicSpline(arc_lengths, points, bc_type="natural")(np.linspace(0.0, arc_lengths[-1], CURVE_POINTS))
    return Part(start, end, curve, is_head)


def centripetal_parameters(points: FloatArray) -> FloatArray:
    """Centripetal parameters of a spline through (x, y, height) points, which makes no loops between them."""
    chord = np.linalg.norm(np.diff(points * [1.0, 1.0, RADIUS_OVER_WIDTH], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(chord**0.5)])


def mirrored(template: Template) -> Template:
    """The template seen in a mirror that swaps left and right; the row still runs from left to right."""
    nb, nt = template.n_bottom, template.n_top
    widest = max(nb, nt)
    parts = []
    for part in reversed(template.parts):
        ends = _mirror_crossing(part.start, nb, nt), _mirror_crossing(part.end, nb, nt)
        curve = part.curve * [-1.0, 1.0, 1.0] + [widest, 0.0, 0.0]
        if not (part.is_head and part.end.place > nb):  # the legs of a slipped loop still run upwards
            ends, curve = ends[::-1], curve[::-1]
        parts.append(Part(*ends, curve, part.is_head))
    return Template(nb, nt, tuple(parts))


def _mirror_crossing(crossing: Crossing, nb: int, nt: int) -> Crossing:
    if crossing.place == nb:
        return Crossing(left_wale(nb, nt).place, crossing.slot)
    if crossing.place == nb + nt + 1:
        return Crossing(right_wale(nb).place, crossing.slot)
    if crossing.place < nb:
        return Crossing(nb - 1 - crossing.place, 1 - crossing.slot)
    return Crossing(2 * nb + nt + 1 - crossing.place, 1 - crossing.slot)


def turned_over(template: Template) -> Template:
    """The template with its heights reversed: what is knit becomes purl."""
    parts = tuple(Part(part.start, part.end, part.curve * [1.0, 1.0, -1.0], part.is_head) for part in template.parts)
    return Template(template.n_bottom, template.n_top, parts)
