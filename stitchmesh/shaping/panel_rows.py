# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Panels between level lines: faces that are several stitches wide and several courses high.

The corners of panels stand at stitches of their course, so that ``tessellate`` finds the number of stitches of the
course again, although it rounds the length of each edge alone. Panels become narrower and wider from row to row, and
their number changes only where they would become too narrow or too wide. There is a corner where a course is divided
among limbs, and where it meets the end of a slit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.shaping.chains import Chain
from stitchmesh.shaping.coarse_levels import higher_bands
from stitchmesh.shaping.counts import StitchSize
from stitchmesh.shaping.divided_lines import divisions
from stitchmesh.shaping.level_lines import LevelLine, LevelLines
from stitchmesh.shaping.plain_places import PlainPlaces
from stitchmesh.shaping.rows import MadeRows

SPREAD = 1.0 / 3.0
"""Part by which panels may be narrower or wider before their number changes. The widest panel is then twice the
narrowest one, so that the number need not change before the number of stitches has doubled or halved."""
FEWEST_PANELS = 6
"""Panels in the smallest round. Straight edges are shorter than a round: those of six panels by a twentieth, which is
a third of a stitch in six and is lost in rounding; with fewer panels ``tessellate`` would find fewer stitches."""
MOST_CHANGE = 2
"""Largest factor by which the number of panels changes from course to course."""


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
        """Start without a course; the arguments are those of ``panels_between``."""
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
        """Place, among some lines, of the line that gets each panel of the course on another one, shape (edges,)."""
        line = self.levels.lines[whole]
        pieces = self.divisions.owner[whole, self.levels.lines[limbs[0]].level > line.level]
        stitches = np.array([self.stitches[edge] for edge in self.course[whole].edges])
        middle = (np.cumsum(stitches) - 0.5 * stitches) / stitches.sum() + self.started[whole] / line.length
        owner: IntArray = pieces[np.floor(np.mod(middle, 1.0) * len(pieces)).astype(np.int64)]
        return owner

    def _panels(self, stitches: int, before: int | None, closed: bool) -> int:
        """Number of panels of a course, near that of the course below."""
        least, most = stitches / (self.across * (1.0 + SPREAD)), stitches / (self.across * (1.0 - SPREAD))
        panels = round(stitches / self.across) if before is None or not least <= before <= most else before
        panels = max(panels, FEWEST_PANELS if closed else 1)
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
