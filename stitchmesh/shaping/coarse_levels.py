# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Fewer level lines: bands of several courses.

Between two places where limbs meet, or where rows begin or end, the bands of a limb follow one another. They are joined
to bands that are about equally high. A band in which limbs meet becomes part of the last rows of these limbs; its other
line stays, so that the graft through the saddle stays short. At the foot and at the head of a slit, the band becomes
part of the rows beside the slit, so that the slit keeps its length. The lines at which rows begin and end stay too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from stitchmesh.shaping.level_lines import Band, LevelLine, LevelLines


@dataclass(frozen=True)
class _Limb:
    """Lines that follow one another, with one band between each and the next."""

    lines: tuple[int, ...]
    """Numbers of the lines, upwards."""
    opens: bool
    """Whether the band below the first line belongs to this limb, so that the first line can be left out."""
    closes: bool
    """Whether the band above the last line belongs to this limb."""

    def left_out(self, courses: int) -> list[int]:
        """Return the lines that are left out if rows are some courses high."""
        high = len(self.lines) - 1 + self.opens + self.closes
        rows = max(round(high / courses), 1 + (self.opens and self.closes))
        kept = {round(high * row / rows) - self.opens for row in range(rows + 1)}
        return [line for place, line in enumerate(self.lines) if place not in kept]


def higher_bands(levels: LevelLines, courses: int) -> LevelLines:
    """Leave out lines, so that bands are about some courses high.

    Args:
        levels: the lines of all courses, and the bands.
        courses: courses in a band.
    """
    from scipy.cluster.hierarchy import DisjointSet

    left_out = {line for limb in _limbs(levels) for line in limb.left_out(courses)}
    groups = DisjointSet(range(len(levels.bands)))
    below, above = _bands_of_lines(levels)
    for line in left_out:
        groups.merge(below[line], above[line])
    bands: dict[int, Band] = {}
    for number, band in enumerate(levels.bands):
        joined = bands.setdefault(groups[number], Band())
        joined.below += [line for line in band.below if line not in left_out]
        joined.above += [line for line in band.above if line not in left_out]
    return LevelLines(levels.lines, tuple(sorted(bands.values(), key=lambda b: _level(levels, b))), levels.borders)


def facing_lines(levels: LevelLines, whole: int, others: Sequence[int], *, above: bool) -> list[LevelLine]:
    """Return, for each line at the other side of a joined band, the line of all courses that is next to a single line.

    Where limbs meet, their next lines say what each of them gets; lines several courses away do not.

    Args:
        levels: the lines of all courses, and the bands.
        whole: the line that is alone at its side of the joined band.
        others: lines at the other side.
        above: whether these are above the single line.
    """
    below_line, above_line = _bands_of_lines(levels)
    band_of, side = (above_line, "above") if above else (below_line, "below")
    found = {}
    for first in getattr(levels.bands[band_of[whole]], side):
        line = first
        while line not in others:
            line = getattr(levels.bands[band_of[line]], side)[0]
        found[line] = levels.lines[first]
    return [found[line] for line in others]


def _level(levels: LevelLines, band: Band) -> int:
    """The level up to which all must be knitted before a band."""
    below = [levels.lines[line].level for line in band.below]
    return max(below) if below else min(levels.lines[line].level for line in band.above) - 1


def _bands_of_lines(levels: LevelLines) -> tuple[dict[int, int], dict[int, int]]:
    """The numbers of the band below and of the band above each line."""
    below = {line: number for number, band in enumerate(levels.bands) for line in band.above}
    above = {line: number for number, band in enumerate(levels.bands) for line in band.below}
    return below, above


def _limbs(levels: LevelLines) -> Iterator[_Limb]:
    """Find the limbs; every line belongs to exactly one of them."""
    below, above = _bands_of_lines(levels)
    for first in sorted({*below, *above}):
        under = levels.bands[below[first]] if first in below else Band()
        if _is_plain(levels, under):
            continue
        lines, over = [first], levels.bands[above[first]] if first in above else Band()
        while _is_plain(levels, over):
            lines.append(over.above[0])
            over = levels.bands[above[lines[-1]]] if lines[-1] in above else Band()
        yield _Limb(
            lines=tuple(lines), opens=_is_part(levels, first, under.above, under.below),
            closes=_is_part(levels, lines[-1], over.below, over.above),
        )  # fmt: skip


def _is_plain(levels: LevelLines, band: Band) -> bool:
    """Whether a band is a part of one limb: between two rings, or between two open lines."""
    one_each = len(band.below) == len(band.above) == 1
    return one_each and levels.lines[band.below[0]].closed == levels.lines[band.above[0]].closed


def _is_part(levels: LevelLines, line: int, own: list[int], others: list[int]) -> bool:
    """Whether a band that is not plain belongs to the limb of one of its lines.

    Args:
        levels: the lines and the bands.
        line: the line.
        own: lines of the band at the side of this line.
        others: lines at its other side.
    """
    if len(own) == len(others) == 1:
        return not levels.lines[line].closed
    return len(own) > 1 and len(others) > 0
