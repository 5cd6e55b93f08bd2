# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How many stitches each course has.

A course has as many stitches as fit on its line, unless its neighbour would differ by more than a row of stitches can
take. Then the counts of the whole tube change. Two functions have small enough steps: the smallest one above the
logarithms of the exact counts, and the largest one below them. The logarithm of each new count is the mean of the two.
This choice makes the largest factor between a count and the exact count as small as possible.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.shaping.level_lines import LevelLine, LevelLines
from stitchmesh.shaping.options import DEFAULT_PLACEMENT, Placement

SLACK = 0.7
"""Difference of a number of stitches from the exact one up to which the number of the course below is kept."""
SMALLEST_RING = 4
"""Stitches in the smallest round."""
SMALLEST_TIP = 5
"""Stitches in the smallest round at a tip; the drawn yarn does not pass well through fewer loops."""
LARGEST_FACTOR = 3.0
"""Factor by which neighbouring courses may differ: a stitch makes three loops of one loop, or one of three, at most."""
MOST_BESIDE = 0.5
"""An open course is short if it is below this part of the course beside it, as the course of a strap beside the
neck."""


@dataclass(frozen=True)
class StitchSize:
    """Size of the stitches, and the numbers that a pattern asks for."""

    width: float
    """Width of a stitch [cm]."""
    height: float
    """Height of a stitch [cm]."""
    multiple: int = 1
    """The number of stitches of each round is a multiple of this number."""
    most_shaping: float | None = None
    """Largest part of the stitches of a row that are increases or decreases; None for as many as the surface asks."""
    shaping: Placement = DEFAULT_PLACEMENT
    """Where increases and decreases stand."""

    @property
    def factor(self) -> float:
        """Factor by which neighbouring courses may differ."""
        return LARGEST_FACTOR if self.most_shaping is None else 1.0 + self.most_shaping

    def step(self, line: LevelLine) -> int:
        """The number of stitches of a line is a multiple of this number."""
        return self.multiple if line.closed else 1


def exact_counts(levels: LevelLines, size: StitchSize) -> FloatArray:
    """Return the number of stitches of each line, not rounded, with steps that rows can take, shape (lines,)."""
    count = np.array([max(line.length, 0.5 * size.width) / size.width for line in levels.lines])
    for tube in tubes(levels):
        count[tube] = _with_small_steps(count[tube], np.log(size.factor))
    return count


def rounded_count(line: LevelLine, exact: float, size: StitchSize, *, tip: bool = False) -> int:
    """Return the whole number of stitches of a line that is nearest to an exact one.

    Args:
        line: the line.
        exact: the exact number.
        size: size of the stitches.
        tip: whether the line is the first one of a closed limb.
    """
    step = size.step(line)
    # Rounding is done on a rounded number, so that equal limbs have equal numbers.
    count = step * int(np.floor(round(exact / step, 6) + 0.5))
    least = (SMALLEST_TIP if tip else SMALLEST_RING) if line.closed else 1
    return max(count, step * -(-least // step))


def count_beside(line: LevelLine, exact: float, other: int, size: StitchSize) -> int:
    """Return the number of stitches of a line, such that a row can join it to a course of ``other`` stitches.

    One increase or decrease, or one multiple, is always permitted, because a limb could not grow otherwise.
    """
    step = size.step(line)
    if other % step == 0 and abs(exact - other) <= SLACK * step:
        return other
    count = rounded_count(line, exact, size)
    least = min(np.ceil(other / size.factor - 1e-9), other - step)
    most = max(np.floor(other * size.factor + 1e-9), other + step)
    least, most = max(least, np.ceil(other / LARGEST_FACTOR)), min(most, LARGEST_FACTOR * other)
    lowest, highest = step * int(np.ceil(least / step)), step * int(np.floor(most / step))
    return min(max(count, lowest), highest) if lowest <= highest else count


def is_part_beside(one: LevelLine, other: LevelLine) -> bool:
    """Return whether one of two neighbouring lines is open and so short that a row joins it to a part of the other."""
    short, long = sorted((one, other), key=lambda line: line.length)
    return not short.closed and short.length < MOST_BESIDE * long.length


def tubes(levels: LevelLines) -> list[list[int]]:
    """Return the numbers of the lines of each tube, upwards: lines between which no limb joins or parts."""
    pairs = [(band.below[0], band.above[0]) for band in levels.bands if len(band.below) == len(band.above) == 1]
    above = {low: high for low, high in pairs if not is_part_beside(levels.lines[low], levels.lines[high])}
    followed = set(above.values())
    found = []
    for start in above:
        if start in followed:
            continue
        tube = [start]
        while tube[-1] in above:
            tube.append(above[tube[-1]])
        found.append(tube)
    return found


def _with_small_steps(count: FloatArray, step: float) -> FloatArray:
    """Return counts whose logarithms differ by at most a step from each to the next, shape (n,)."""
    place = step * np.arange(len(count))
    given = np.log(count)
    highest = np.maximum(
        np.maximum.accumulate(given + place) - place, np.maximum.accumulate((given - place)[::-1])[::-1] + place
    )
    lowest = np.minimum(
        np.minimum.accumulate(given - place) + place, np.minimum.accumulate((given + place)[::-1])[::-1] - place
    )
    # Counts that need no change keep their last bits.
    return np.where(highest - lowest > 1e-9, np.exp(0.5 * (highest + lowest)), count)
