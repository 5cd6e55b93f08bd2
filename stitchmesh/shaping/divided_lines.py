# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the courses of panels are cut: between the limbs that divide a course, and at the ends of slits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.shaping.chains import owners
from stitchmesh.shaping.coarse_levels import facing_lines
from stitchmesh.shaping.level_lines import LevelLine, LevelLines

PIECES_OF_STITCH = 2
"""Pieces of a line, for each stitch, that are given to limbs."""


@dataclass(frozen=True)
class Divisions:
    """The divisions of lines, by the number of the line and whether the other lines are above it."""

    owner: dict[tuple[int, bool], IntArray] = field(default_factory=dict)
    """Place, among the other lines, of the one that gets each of equal pieces of the line, shape (pieces,)."""
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
    """Place, among some lines, of the one that gets each of equal pieces of another line, shape (n,)."""
    count = max(1, round(PIECES_OF_STITCH * line.length / width))
    middles = line.at(line.length * (np.arange(count) + 0.5) / count)
    return owners(middles, [other.points for other in others], line.closed)


def _changes(pieces: IntArray, *, closed: bool) -> FloatArray:
    """Places at which a piece has another owner than the piece before, over the length of the line, shape (n,)."""
    changes = np.flatnonzero(pieces != np.roll(pieces, 1))
    return changes[closed | (changes > 0)] / len(pieces)
