# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Panels between level lines: faces that are several stitches wide and several courses high.

The corners of panels stand at stitches of their course, so that ``tessellate`` finds the number of stitches of the
course again, although it rounds the length of each edge alone. Panels become narrower and wider from row to row, and
their number changes only where they would become too narrow or too wide. There is a corner where a course is divided
among limbs, and where it meets the end of a slit.

There are fewer level lines, so that each band has several courses. Between two places where limbs meet, or where rows
begin or end, the bands of a limb follow one another. They are joined to bands that are about equally high. A band in
which limbs meet becomes part of the last rows of these limbs; its other line stays, so that the graft through the
saddle stays short. At the foot and at the head of a slit, the band becomes part of the rows beside the slit, so that
the slit keeps its length. The lines at which rows begin and end stay too. The courses of panels are cut between the
limbs that divide a course, and at the ends of slits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.shaping.chains import Chain, owners
from stitchmesh.shaping.counts import StitchSize
from stitchmesh.shaping.level_lines import Band, LevelLine, LevelLines
from stitchmesh.shaping.plain_places import PlainPlaces
from stitchmesh.shaping.rows import MadeRows

SPREAD = 1.0 / 3.0
"""Part by which panels may be narrower or wider before their number changes. The widest panel is then twice the
narrowest one, so that the number need not change before the number of stitches has doubled or halved."""
MOST_CHANGE = 2
"""Largest factor by which the number of panels changes from course to course."""


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
        """Return the lines to leave out, so that each row is about ``courses`` courses high."""
        high = len(self.lines) - 1 + self.opens + self.closes
        rows = max(round(high / courses), 1 + (self.opens and self.closes))
        kept = {round(high * row / rows) - self.opens for row in range(rows + 1)}
        return [line for place, line in enumerate(self.lines) if place not in kept]


def higher_bands(levels: LevelLines, courses: int) -> LevelLines:
    """Leave out lines, so that each band is about ``courses`` courses high.

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
    """Return, for each line at the other side of a joined band, the line of its limb that is next to a single line.

    Where limbs meet, the lines next to the single line show which part of it each limb gets; lines several courses away
    do not.

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


@dataclass(frozen=True)
class Divisions:
    """How lines are divided among other lines.

    The keys are the number of a line, and whether the other lines are above it.
    """

    owner: dict[tuple[int, bool], IntArray] = field(default_factory=dict)
    """The line is divided into equal pieces; the place, among the other lines, of the line that gets each, shape
    (pieces,)."""
    places: dict[tuple[int, bool], FloatArray] = field(default_factory=dict)
    """Lengths along the line at which its course is cut [cm], shape (n,)."""

    def cuts(self, line: int) -> FloatArray:
        """Return the lengths along a line at which its course is cut on either side [cm], shape (n,)."""
        return np.concatenate([np.zeros(0), *(self.places.get((line, above), []) for above in (False, True))])


def divisions(courses: LevelLines, levels: LevelLines, width: float) -> Divisions:
    """Divide the lines at which limbs or the sides of a slit meet.

    Args:
        courses: the lines of all courses, and the bands.
        levels: the lines of some courses, and the bands.
        width: width of a stitch [cm].
    """
    found = Divisions()
    for band in levels.bands:
        for own, others, above in ((band.below, band.above, True), (band.above, band.below, False)):
            if len(own) != 1 or not others:
                continue
            line, beside = levels.lines[own[0]], facing_lines(courses, own[0], others, above=above)
            if len(others) > 1:
                pieces = _pieces(line, beside, width)
                found.owner[own[0], above] = pieces
                found.places[own[0], above] = _changes(pieces, closed=line.closed) * line.length
            elif line.closed and not beside[0].closed:
                middle = 0.5 * (beside[0].points[0] + beside[0].points[-1])
                found.places[own[0], above] = np.array([line.nearest(middle)[0]])
    return found


def _pieces(line: LevelLine, others: Sequence[LevelLine], width: float) -> IntArray:
    """Divide a line into equal pieces; return the place, among the others, of the line that gets each, shape (n,)."""
    # Number of equal pieces for each stitch, into which a line is divided; each piece goes to one limb.
    count = max(1, round(2 * line.length / width))
    middles = line.at(line.length * (np.arange(count) + 0.5) / count)
    return owners(middles, [other.points for other in others], line.closed)


def _changes(pieces: IntArray, *, closed: bool) -> FloatArray:
    """Places, over the length of the line, at which the owner of the pieces changes, shape (n,)."""
    changes = np.flatnonzero(pieces != np.roll(pieces, 1))
    return changes[closed | (changes > 0)] / len(pieces)


def panels_between(
    courses: LevelLines, saddles: FloatArray, size: StitchSize, plain: PlainPlaces, stitches: int,
    report_part: Callable[[float], None],
) -> StitchMesh:  # fmt: skip
    """Make panels between some of the lines of a surface.

    Args:
        courses: the lines of all courses, and the bands between them.
        saddles: points at which limbs meet [cm], shape (n, 3).
        size: size of the stitches.
        plain: places from which increases and decreases are kept away.
        stitches: stitches along a panel, and courses in a row.
        report_part: called at intervals with the part of the bands that is done, from 0 to 1.

    Raises:
        TessellationError: as for ``stitches_between``.
    """
    made = _PanelRows(courses, saddles, size, plain, stitches).knitted(report_part)
    return replace(made, stitch=np.full(made.face_count, Stitch.PANEL))


class _PanelRows(MadeRows):
    """Courses and rows of panels made so far."""

    faces_are = "panels"
    edge_vertices = 0  # shaping is within panels

    def __init__(
        self, courses: LevelLines, saddles: FloatArray, size: StitchSize, plain: PlainPlaces, stitches: int
    ) -> None:
        """Start without a course; the arguments are the same as for ``panels_between``."""
        super().__init__(higher_bands(courses, stitches), saddles, size, plain)
        self.across = stitches
        self.face_width = stitches * size.width
        self.divisions = divisions(courses, self.levels, size.width)
        self.started: dict[int, float] = {}

    def _start(self, line: int, below: Sequence[int]) -> float:
        """Length along a line at which its course starts [cm]: as for stitches, or at the nearest cut of a ring."""
        start, target, cuts = super()._start(line, below), self.levels.lines[line], self.divisions.cuts(line)
        if not target.closed or not len(cuts):
            return start
        away = (cuts - start) / target.length
        return float(cuts[np.abs(away - np.rint(away)).argmin()])

    def _turns(self, target: LevelLine, count: int, below: Chain) -> bool:
        """Panels keep their lines: no round moves."""
        return False

    def _edges_along(self, line: int, start: float, count: int, below: Chain | None) -> IntArray:
        """Number of stitches along each panel of the course on a line, shape (edges,)."""
        target = self.levels.lines[line]
        panels = self._panels(count, None if below is None else len(below.edges), target.closed)
        self.started[line] = start
        share = np.mod(self.divisions.cuts(line) - start, target.length) / target.length
        marks = np.unique([0, *np.rint(share * count).astype(np.int64), count])
        parts = [evenly(part, max(1, round(part * panels / count))) for part in np.diff(marks).tolist()]
        return np.concatenate(parts)

    def _owners(self, whole: int, limbs: Sequence[int]) -> IntArray:
        """Place, in ``limbs``, of the line that gets each panel of the course on ``whole``, shape (edges,)."""
        line = self.levels.lines[whole]
        pieces = self.divisions.owner[whole, self.levels.lines[limbs[0]].level > line.level]
        stitches = np.array([self.stitches[edge] for edge in self.course[whole].edges])
        middle = (np.cumsum(stitches) - 0.5 * stitches) / stitches.sum() + self.started[whole] / line.length
        owner: IntArray = pieces[np.floor(np.mod(middle, 1.0) * len(pieces)).astype(np.int64)]
        return owner

    def _panels(self, stitches: int, before: int | None, closed: bool) -> int:
        """Number of panels of a course, near the number of the course below."""
        least, most = stitches / (self.across * (1.0 + SPREAD)), stitches / (self.across * (1.0 - SPREAD))
        panels = round(stitches / self.across) if before is None or not least <= before <= most else before
        # Panels in the smallest round. The straight edges of six panels are shorter than the round by a twentieth.
        # This is a third of a stitch in six and is lost in rounding; with fewer panels ``tessellate`` would find
        # fewer stitches.
        panels = max(panels, 6 if closed else 1)
        if before is not None:
            panels = min(max(panels, -(-before // MOST_CHANGE)), MOST_CHANGE * before)
        return min(panels, stitches)

    def _edges_of_graft(self, count: int) -> IntArray:
        """Number of stitches along each edge of a graft with some stitches."""
        return evenly(count, max(1, round(count / self.across)))


def evenly(total: int, parts: int) -> IntArray:
    """Divide a number into parts that differ by at most one, and spread the larger ones, shape (parts,)."""
    # Halves are rounded up, so that each part is the same whatever the rounding of quotients.
    marks = (2 * total * np.arange(parts + 1) + parts) // (2 * parts)
    return np.asarray(np.diff(marks), dtype=np.int64)
