# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Increases and decreases that are stacked at seams, where makers put them.

A seam is a line along the fabric. On both of its sides one stitch is plain, and an increase or a decrease stands beside
this stitch. The two sides mirror each other, so that the wales of a gore, the part between two seams, stay parallel.
Both ends of a flat row are seams. A tube has

- four seams where three limbs become one: the raglan lines, from the ends of the two grafts upwards;
- elsewhere, where limbs meet, one seam for each other limb beside it: the underarms of a body and of sleeves, the inner
  leg;
- else two seams, at its left and at its right side.

Rows with increases or decreases follow one another in a rhythm that is as steady as the exact numbers of stitches
(``counts``) allow: each number differs from the exact number by at most ``SLACK`` of a change.

The wales at the ends of a gore lean by half of the difference in length between the row and the row below. Where they
would be stretched by more than a fifth, or where a change is too coarse for a narrow round, increases and decreases are
spread over the row (``wales``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.arrays import runs_of
from stitchmesh.shaping.chains import owners
from stitchmesh.shaping.counts import SLACK, StitchSize, tubes
from stitchmesh.shaping.level_lines import LevelLine, LevelLines
from stitchmesh.shaping.wales import Wales

PLAIN_AT_SEAM = 1
"""Plain stitches between a seam and the increase or decrease beside it."""
NARROWEST_GORE = 2 * (PLAIN_AT_SEAM + 2) + 1
"""Stitches of the narrowest gore that has a decrease at each of its ends, with one between them."""
MOST_SEAMS = 4
"""Largest number of seams of a tube."""
SAMPLES = 4.0
"""Points along a line for each stitch width, where it is divided among limbs."""


@dataclass(frozen=True)
class Gore:
    """The stitches of a row between two seams."""

    count: int
    """Stitches of the course below."""
    left: int = 0
    """Change of this number at the left end: -1, 0 or 1."""
    right: int = 0
    """The same at the right end."""

    @property
    def above(self) -> int:
        """Stitches of the course above."""
        return self.count + self.left + self.right

    @property
    def possible(self) -> bool:
        """Whether there is room for the increases and decreases."""
        return not (self.left or self.right) or self.count >= NARROWEST_GORE


@dataclass
class ShapedRows:
    """Where each row has its increases and decreases."""

    at_seams: list[bool] = field(default_factory=list)
    """Whether each row, in the order in which rows are made, has them at seams."""
    along: list[bool] = field(default_factory=list)
    """Whether each row has them all along."""

    def add(self, wales: Wales, *, stacked: bool) -> None:
        """Take a row."""
        shaped = bool((np.diff(wales.below) != 1).any() or (np.diff(wales.above) != 1).any())
        self.at_seams.append(shaped and stacked)
        self.along.append(shaped and not stacked)

    @property
    def stacked(self) -> int:
        """Number of rows that have them at seams."""
        return sum(self.at_seams)

    @property
    def spread(self) -> int:
        """Number of rows that have them all along."""
        return sum(self.along)

    def leaning(self, tube_of_row: Sequence[int]) -> NDArray[np.bool_]:
        """Return whether each row lies from the first to the last row of its tube with shaping at seams.

        The wales of these rows lean beside the seams.
        """
        tube, stacked = np.array(tube_of_row), np.array(self.at_seams, dtype=bool)
        leaning = np.zeros(len(tube), dtype=bool)
        for number in np.unique(tube[stacked]):
            rows = np.flatnonzero(tube == number)
            shaped = np.flatnonzero(stacked[rows])
            leaning[rows[shaped[0] : shaped[-1] + 1]] = True
        return leaning


def stacked_wales(gores: Sequence[Gore]) -> tuple[Wales, NDArray[np.bool_]]:
    """Return the wale edges of a row, and whether each of its stitches is in the left half of its gore, shape (W - 1,).

    Args:
        gores: the gores from left to right; each of them is possible.
    """
    loops, made, left = [np.zeros(1, dtype=np.int64)], [np.zeros(1, dtype=np.int64)], []
    for gore in gores:
        number = gore.count - (gore.left < 0) - (gore.right < 0)
        low, high = np.ones(number, dtype=np.int64), np.ones(number, dtype=np.int64)
        for change, end, inwards in ((gore.left, 0, 1), (gore.right, number - 1, -1)):
            if change < 0:
                low[end + inwards * PLAIN_AT_SEAM] = 2
            elif change > 0:
                high[end] = 2  # the new loop is on the inner side of the plain one
        loops.append(low)
        made.append(high)
        left.append(2 * np.arange(number) < number)
    return Wales(np.cumsum(np.concatenate(loops)), np.cumsum(np.concatenate(made))), np.concatenate(left)


def halves(wales: Wales) -> NDArray[np.bool_]:
    """Return whether each stitch of a row is in its left half, shape (W - 1,)."""
    left: NDArray[np.bool_] = 2 * np.arange(len(wales.below) - 1) < len(wales.below)
    return left


def steady_counts(exact: FloatArray, step: int, *, to_and_fro: bool = False) -> IntArray:
    """Return numbers that change by a step in as steady a rhythm as the exact ones allow, shape (n,).

    Args:
        exact: the exact numbers, shape (n,); the first one is 0.
        step: by how much the number changes at once.
        to_and_fro: whether rows are knitted to and fro: numbers then change at even places, which are rows on the right
            side if the first one is cast on, unless they change too fast.
    """
    changes = np.zeros(len(exact), dtype=np.int64)
    windows = _windows(exact, step)
    last, done = 0, 0
    while done < len(windows):
        first, apart, times = _longest_rhythm(windows[done:], last + 1, to_and_fro)
        for place in range(first, first + apart * times, apart):
            if place < len(exact):
                changes[place] = windows[done][2] * step
        last, done = first + apart * (times - 1), done + times
    counts: IntArray = np.cumsum(changes)
    return counts


_Window = tuple[int, int, int]
"""First and last place at which a number may change, and 1 or -1 for its sign."""


def _windows(exact: FloatArray, step: int) -> list[_Window]:
    """Return where each change may be, so that no number differs from the exact one by more than ``SLACK`` steps."""
    most, count, last = SLACK * step + 1e-6, 0, 1
    found: list[_Window] = []
    while len(beyond := np.flatnonzero(np.abs(exact[last:] - count) > most)):
        last += int(beyond[0])
        sign = 1 if exact[last] > count else -1
        count += sign * step
        before = np.flatnonzero(np.abs(exact[1 : last + 1] - count) > most)
        found.append((min(int(before[-1]) + 2 if len(before) else 1, last), last, sign))
    return found


def _longest_rhythm(windows: Sequence[_Window], least: int, to_and_fro: bool) -> tuple[int, int, int]:
    """Return the longest sequence of changes at equal distances: its first place, the distance and its length.

    Args:
        windows: where each change may be.
        least: the first place that is free.
        to_and_fro: whether numbers change at even places, as in ``steady_counts``.
    """
    # If changes are at least this number of rows apart, they are on one side of a fabric that is knitted to and
    # fro.
    step = 2 if to_and_fro and windows[-1][1] - windows[0][0] >= 3 * (len(windows) - 1) else 1
    start, end = _multiples(max(windows[0][0], least), windows[0][1], step)
    if start > end:
        return max(windows[0][1], least), 1, 1
    best = ((start + end) // (2 * step) * step, 1, 1)
    for apart in range(step, windows[1][1] - start + 1 if len(windows) > 1 else 1, step):
        low, high, times = start, end, 1
        for number, (first, last, sign) in enumerate(windows[1:], start=1):
            lowest, highest = _multiples(max(low, first - number * apart), min(high, last - number * apart), step)
            if lowest > highest or sign != windows[0][2]:
                break
            low, high, times = lowest, highest, number + 1
        if times > best[2]:
            best = (-(-(low + high) // (2 * step)) * step, apart, times)
    return best


def _multiples(low: int, high: int, step: int) -> tuple[int, int]:
    """The first and the last multiple of a step between two places; the first one is larger if there is none."""
    return -(-low // step) * step, high // step * step


@dataclass(frozen=True)
class RowChange:
    """How a row changes the number of stitches of each gore: -1, 0 or 1 at an end of it."""

    inner: int = 0
    """At both sides of each seam."""
    left: int = 0
    """At the left end of an open row."""
    right: int = 0
    """At its right end."""

    def gores(self, counts: Sequence[int], closed: bool) -> list[Gore]:
        """Return the gores of a row.

        Args:
            counts: stitches of each gore in the course below.
            closed: whether the row is a round.
        """
        left, right = (self.inner, self.inner) if closed else (self.left, self.right)
        ends = [left, *[self.inner] * (2 * len(counts) - 2), right]
        return [Gore(count, *ends[2 * place : 2 * place + 2]) for place, count in enumerate(counts)]


@dataclass(frozen=True, eq=False)
class SeamPlan:
    """Where all rows of a surface have their increases and decreases at seams."""

    starts: dict[int, FloatArray]
    """The seams of each tube or flat part on the line where they begin [cm], in their order along it, shape (n, 3). The
    ends of flat rows are not among them."""
    changes: dict[int, RowChange]
    """Change of the row below a line; none for rows whose increases and decreases are spread."""


def seam_plan(levels: LevelLines, exact: FloatArray, size: StitchSize) -> SeamPlan:
    """Plan the seams of a surface.

    Args:
        levels: the lines and the bands.
        exact: number of stitches of each line, not rounded, shape (lines,).
        size: size of the stitches.
    """
    known = _at_joins(levels, size.width)
    plan = SeamPlan({}, {})
    for tube in tubes(levels):
        cuts = [place for place, (one, other) in enumerate(pairwise(tube), start=1)
                if levels.lines[one].closed != levels.lines[other].closed]  # fmt: skip
        for first, last in pairwise([0, *cuts, len(tube)]):
            numbers = tube[first:last]
            lines = [levels.lines[line] for line in numbers]
            starts = _met_seams(levels, numbers, known)
            seams = (2 if lines[0].closed else 0) if starts is None else len(starts)
            found = _steady_changes(lines, seams, exact[numbers], size)
            if any(found):
                begin = 0 if starts is not None else next(place for place, change in enumerate(found) if change)
                points = starts if starts is not None else _sides(lines[begin])
                along = [lines[begin].nearest(point)[0] for point in points]
                plan.starts[numbers[begin]] = points[np.argsort(along, kind="stable")]
                plan.changes.update((line, change) for line, change in zip(numbers[1:], found, strict=True) if change)
    return plan


def _met_seams(
    levels: LevelLines, lines: Sequence[int], known: dict[tuple[int, bool], FloatArray]
) -> FloatArray | None:
    """The seams on the first line of a tube or a flat part that follow from where limbs meet, shape (n, 3), or None."""
    above, below = known.get((lines[-1], True)), known.get((lines[0], False))
    if below is not None and (above is None or len(below) > len(above)):
        return below
    return None if above is None else _traced(levels, lines[::-1], above)


def _steady_changes(
    tube: Sequence[LevelLine], seams: int, exact: FloatArray, size: StitchSize
) -> list[RowChange | None]:
    """The changes of the rows between neighbouring lines that are all rings or all open, upwards.

    At each end of an open row as many stitches come or go as the end moves along the course. The rest of the difference
    in length changes both sides of all seams, or both ends of a row without seams.

    Args:
        tube: the lines.
        seams: number of seams, without the ends of open rows.
        exact: number of stitches of each line, not rounded, shape (lines,).
        size: size of the stitches.

    Returns:
        None for a row that changes too fast, or by too large a part of its stitches at once.
    """
    moved = np.zeros((len(tube) - 1, 2))
    if not tube[0].closed:
        moved = np.array([_ends_moved(low, high) for low, high in pairwise(tube)]).reshape(-1, 2) / size.width
    within = np.diff(exact) - moved.sum(axis=1)
    # Largest tangent of the angle by which wales at a seam lean: they are stretched by a fifth, sqrt(1 + 0.66^2) =
    # 1.2, as the edges of a single increase are.
    steady = np.abs(within) * size.width / (2.0 * max(seams, 1) * size.height) <= 0.66
    # Largest part of the stitches of a round by which it may change at once.
    steady &= (2 * seams <= 0.1 * exact[1:]) & (exact[1:] >= NARROWEST_GORE)
    if not seams:
        moved += 0.5 * within[:, None]
    steady &= (np.abs(moved) <= 1.0).all(axis=1)
    found: list[RowChange | None] = [None] * len(moved)
    for first, last in runs_of(steady):
        # Ends that mirror each other change in the same rows, whatever the rounding of their positions.
        columns = [within[first:last] * (seams > 0), moved[first:last, 0], moved[first:last, 1]]
        begin = first % 2  # A row more, so that even places stay even.
        place = [np.concatenate([np.zeros(1 + begin), np.cumsum(column)]).round(6) for column in columns]
        changes = [
            np.diff(steady_counts(one, step, to_and_fro=not tube[0].closed))[begin:] // step
            for one, step in zip(place, (2 * max(seams, 1), 1, 1), strict=True)
        ]
        # A short run without a change does not keep a number of stitches that does not fit.
        if last - first == len(steady) or np.any(changes):
            found[first:last] = [RowChange(*row) for row in np.stack(changes, axis=1).tolist()]
    return found


def _nearest_on(line: LevelLine, point: FloatArray) -> FloatArray:
    """The point of a line nearest to a point [cm], shape (3,)."""
    return line.at(np.array([line.nearest(point)[0]]))[0]


def _at_joins(levels: LevelLines, width: float) -> dict[tuple[int, bool], FloatArray]:
    """The seams on each line beside a place where limbs meet, by its number, and whether limbs meet above it."""
    known: dict[tuple[int, bool], FloatArray] = {}
    by_end = {tube[-1]: tube for tube in tubes(levels)}
    by_start = {tube[0]: tube for tube in by_end.values()}
    meeting = [
        band for band in levels.bands
        if min(len(band.below), len(band.above)) == 1 and len(band.below) != len(band.above)
    ]  # fmt: skip
    for band in meeting[::-1]:
        joins = len(band.above) == 1
        limbs, (whole,) = (band.below, band.above) if joins else (band.above, band.below)
        lines = [levels.lines[limb] for limb in limbs]
        # A second sleeve may join a row above the first one; the body below both has a seam for each.
        tube = by_start.get(whole, [whole])
        # Largest number of courses between two sleeves that join a body at the same height.
        later = known.get((tube[-1], True)) if joins and len(tube) <= 4 else None
        others = np.zeros((0, 3)) if later is None else _traced(levels, tube[::-1], later)
        for limb, points in _beside_limbs(lines, others, width).items():
            known[limbs[limb], joins] = points
    for band in meeting:
        joins = len(band.above) == 1
        limbs, (whole,) = (band.below, band.above) if joins else (band.above, band.below)
        # The raglan lines of the first sleeve go on.
        older = [known.get((by_end.get(limb, [limb])[0], False), np.zeros((0, 3))) for limb in limbs if joins]
        lines = [levels.lines[limb] for limb in limbs]
        raglan = _between_limbs(levels.lines[whole], lines, np.concatenate([np.zeros((0, 3)), *older]), width)
        if 0 < len(raglan) <= MOST_SEAMS:
            known[whole, not joins] = raglan
    return known


def _traced(levels: LevelLines, lines: Sequence[int], points: FloatArray) -> FloatArray:
    """Follow points from line to line, each time to the nearest point [cm], shape (n, 3)."""
    for line in lines:
        points = np.array([_nearest_on(levels.lines[line], point) for point in points])
    return points


def _beside_limbs(limbs: list[LevelLine], others: FloatArray, width: float) -> dict[int, FloatArray]:
    """The point of each limb that is nearest to each of its neighbours [cm]; the nearest limbs are neighbours.

    Two neighbours that are both open meet at their ends, and have none. Further points belong to the nearest limb.
    """
    from scipy.sparse.csgraph import minimum_spanning_tree
    from scipy.spatial import cKDTree

    points = [limb.at(np.arange(0.0, limb.length, width / SAMPLES)) for limb in limbs]
    apart = [[cKDTree(other).query(one)[0] for other in points] for one in points]
    nearest = np.array([[away.min() for away in row] for row in apart])
    tree = minimum_spanning_tree(np.maximum(nearest, np.finfo(np.float64).tiny)).toarray() > 0.0
    found: dict[int, list[FloatArray]] = {}
    for one, other in np.argwhere(tree | tree.T).tolist():
        if limbs[one].closed or limbs[other].closed:
            # Take the middle of all places that are nearly as near, so that rounding does not choose between equal
            # places.
            near = apart[one][other] < nearest[one, other] + 0.5 * width
            found.setdefault(one, []).append(_nearest_on(limbs[one], points[one][near].mean(axis=0)))
    for point in others:
        closest = int(np.argmin([limb.nearest(point)[1] for limb in limbs]))
        found.setdefault(closest, []).append(_nearest_on(limbs[closest], point))
    inner = {one: _off_the_ends(limbs[one], np.array(places), width) for one, places in found.items()}
    return {one: places for one, places in inner.items() if 0 < len(places) <= MOST_SEAMS}


def _off_the_ends(line: LevelLine, points: FloatArray, width: float) -> FloatArray:
    """The points of a line [cm], shape (n, 3), that leave room for a gore between them and the ends of an open line."""
    along, room = np.array([line.nearest(point)[0] for point in points]), NARROWEST_GORE * width
    return points[np.full(len(along), line.closed) | ((along >= room) & (along <= line.length - room))]


def _between_limbs(whole: LevelLine, limbs: list[LevelLine], older: FloatArray, width: float) -> FloatArray:
    """The points at which a line is divided among limbs, and the points nearest to older seams [cm], shape (n, 3).

    Two limbs that are about equally wide, such as legs, leave no points: their tube is shaped at its sides. Limbs that
    are all open, such as the parts beside a neck, leave none either.
    """
    lengths = sorted(limb.length for limb in limbs)
    # The shorter of two limbs that meet is a sleeve if its length, over the length of the longer one, is at most
    # this.
    if (len(limbs) == 2 and lengths[0] > 0.75 * lengths[1]) or not any(limb.closed for limb in limbs):
        return older
    count = max(int(SAMPLES * whole.length / width), len(limbs))
    step = float(whole.length / count)
    places: FloatArray = np.arange(count, dtype=np.float64) * step
    beside = [limb.at(np.arange(0.0, limb.length, step)) for limb in limbs]
    owner = owners(whole.at(places + 0.5 * step), beside, whole.closed)
    before = np.roll(owner, 1) if whole.closed else np.append(owner[:1], owner[:-1])
    points = np.concatenate([whole.at(places[owner != before]), older])
    return _off_the_ends(whole, np.array([_nearest_on(whole, point) for point in points]).reshape(-1, 3), width)


def _sides(ring: LevelLine) -> FloatArray:
    """The two sides of a ring [cm], shape (2, 3), where its middle plane cuts it; an open line has none.

    The axis to the sides is the first of x, z and y along which the ring is about as wide as along any of them.
    """
    if not ring.closed:
        return np.zeros((0, 3))
    points = np.concatenate([ring.points, ring.points[:1]])
    step = np.diff(points, axis=0)
    length = np.linalg.norm(step, axis=1)
    middle = np.average(points[:-1] + 0.5 * step, axis=0, weights=length)
    normal = np.cross(points[:-1] - middle, step).sum(axis=0)
    axes = np.eye(3)[[0, 2, 1]]
    wide = np.ptp(points @ axes.T, axis=0)
    # An axis leads to the sides of a round if the width along it, over the largest width, is at least this.
    axis = axes[int(np.argmax(wide >= 0.9 * wide.max()))]
    aside = (points - middle) @ np.cross(axis, normal)
    crossed = np.flatnonzero((aside[:-1] > 0.0) != (aside[1:] > 0.0))
    share = (aside[crossed] / (aside[crossed] - aside[crossed + 1]))[:, None]
    cut = points[crossed] + share * step[crossed]
    return cut[[int(np.argmin(cut @ axis)), int(np.argmax(cut @ axis))]]


def _ends_moved(low: LevelLine, high: LevelLine) -> tuple[float, float]:
    """How far the left and the right end of a line reach beyond the ends of the line below, along the lines [cm]."""
    one, other = (
        line if line.flat is None else LevelLine(0, np.pad(line.flat, ((0, 0), (0, 1))), closed=False)
        for line in (low, high)
    )
    left = other.nearest(one.points[0])[0] - one.nearest(other.points[0])[0]
    right_of_high = other.length - other.nearest(one.points[-1])[0]
    right_of_low = one.length - one.nearest(other.points[-1])[0]
    return left, right_of_high - right_of_low
