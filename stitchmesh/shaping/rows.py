# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches between level lines.

Each line becomes a course of equally wide stitches, each band a row, or one row for each of the limbs that meet in it.
The last course before a tip is left open: yarn generation draws a yarn through its loops. Rows are numbered tube by
tube: first those that begin at the longest line, such as the hem, then all rows of one sleeve, those of the other one,
and those of the body above them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stitchmesh.errors import TessellationError
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.connectivity import find_fans, next_sides
from stitchmesh.shaping.chains import Chain, Grafts, divide, owners
from stitchmesh.shaping.counts import StitchSize, count_beside, exact_counts, rounded_count
from stitchmesh.shaping.level_lines import Band, LevelLine, LevelLines
from stitchmesh.shaping.plain_places import PlainPlaces
from stitchmesh.shaping.wales import ABOVE, join_courses
from stitchmesh.tessellate.panel import StitchFaces, stitch_for
from stitchmesh.tessellate.tessellate import twins_of_edges, with_cast_on

LARGEST_TIP = 20
"""Stitches in the largest round below the last one at a tip whose stitches are all plain: the yarn that is drawn
through the last loops does not pass well through a decrease and its neighbours."""
FADING = 0.8
"""Part of the mark of an increase or a decrease that stays from row to row, so that the next one stands elsewhere."""
KEPT_AWAY = 1000.0
"""Cost of an increase or a decrease in a plain place, in squared stitch widths; wales lean rather than pay it."""
BANDS_OF_REPORT = 20
"""Bands from one report of the progress to the next."""


def stitches_between(
    levels: LevelLines, saddles: FloatArray, size: StitchSize, plain: PlainPlaces, report_part: Callable[[float], None]
) -> StitchMesh:
    """Knit all bands.

    Args:
        levels: the lines and the bands.
        saddles: points at which limbs meet [cm], shape (n, 3); grafts run through them.
        size: size of the stitches.
        plain: places from which increases and decreases are kept away.
        report_part: called at intervals with the part of the bands that is knitted, from 0 to 1.

    Raises:
        TessellationError: limbs join and part within one band, or neighbouring courses differ too much.
    """
    rows = _Rows(levels, saddles, size, plain)
    for number, band in enumerate(levels.bands):
        if number % BANDS_OF_REPORT == 0:
            report_part(number / len(levels.bands))
        rows.knit(band)
    return rows.stitch_mesh()


class _Rows:
    """Courses and rows made so far."""

    def __init__(self, levels: LevelLines, saddles: FloatArray, size: StitchSize, plain: PlainPlaces) -> None:
        self.levels, self.saddles, self.size, self.plain = levels, saddles, size, plain
        self.exact = exact_counts(levels, size)
        self.points: list[FloatArray] = []
        self.course: dict[int, Chain] = {}
        self.recent: list[float] = []
        self.edges = 0
        self.faces = StitchFaces()
        self.tube: dict[int, int] = {}
        self.tubes = 0
        self.begun: dict[int, float] = {}
        self.tube_of_row: list[int] = []
        ends = {band.below[0] for band in levels.bands if not band.above and len(band.below) == 1}
        self.last_courses = ends - levels.borders

    def knit(self, band: Band) -> None:
        """Add the rows of a band."""
        if not band.below or not band.above:
            self._finish(band)
            return
        below = [self.course[line] for line in band.below]
        above = [self._course_above(line, band) for line in band.above]
        if len(below) > 1 and len(above) > 1:
            place = self.levels.lines[band.below[0]].points.mean(axis=0).round(1).tolist()
            raise TessellationError(
                f"near {place} cm: limbs join and part within one row; choose a smaller stitch, or mark other ends"
            )
        if len(above) == 1:
            self._join(band, below, above[0])
        else:
            self._part(band, below[0], above)

    def _join(self, band: Band, below: list[Chain], above: Chain) -> None:
        """Add the rows from one or several courses to the one above them."""
        self.tube[band.above[0]] = self.tube[band.below[0]] if len(below) == 1 else self._new_tube()
        for line, low, high in zip(band.below, below, self._divided(above, below), strict=True):
            if high is not None:
                self._add_row(low, high, self.tube[line])

    def _part(self, band: Band, below: Chain, above: list[Chain]) -> None:
        """Add the rows from a course to several ones above it."""
        for line, low in zip(band.above, self._divided(below, above), strict=True):
            self.tube[line] = self._new_tube()
            if low is not None:
                self._fit_to(line, band, len(low.edges))
                self._add_row(low, self.course[line], self.tube[line])

    def _new_tube(self) -> int:
        """Number of a further tube; a tube that continues others has a larger number than they have."""
        self.tubes += 1
        return self.tubes - 1

    def _finish(self, band: Band) -> None:
        """Begin the courses above a place where rows begin; nothing is knitted above courses that end."""
        for line in band.above:
            tip = line not in self.levels.borders
            self.tube[line] = self._new_tube()
            self.begun[self.tube[line]] = self.levels.lines[line].length
            count = rounded_count(self.levels.lines[line], self.exact[line], self.size, tip=tip)
            self.course[line] = self._new_course(line, 0.0, count)

    def _course_above(self, line: int, band: Band) -> Chain:
        """Make the course on a line above a band; a round starts above the start of the nearest course below."""
        below = self.course[band.below[0]]
        if len(band.below) == len(band.above) == 1:
            count = self._count_above(line, len(below.edges))
        else:
            count = rounded_count(self.levels.lines[line], self.exact[line], self.size)
        self.course[line] = self._new_course(line, self._start(line, band), count)
        return self.course[line]

    def _start(self, line: int, band: Band) -> float:
        """Length along a line above a band at which its course starts [cm]."""
        target = self.levels.lines[line]
        if not target.closed:
            return 0.0
        found = [target.nearest(self.points[self.course[number].vertices[0]]) for number in band.below]
        return min(found, key=lambda pair: pair[1])[0]

    def _count_above(self, line: int, below: int) -> int:
        """Number of stitches of a course above a single one.

        A course that is plain all along keeps the stitches of the course below, as does the last one before a tip.
        """
        target = self.levels.lines[line]
        is_tip = line in self.last_courses and below <= LARGEST_TIP
        if is_tip or (below % self.size.step(target) == 0 and self.plain.hold(target.points).all()):
            return below
        return count_beside(target, self.exact[line], below, self.size)

    def _fit_to(self, line: int, band: Band, below: int) -> None:
        """Make the course of a limb anew if no row joins it to its part of the course below."""
        made = len(self.course[line].edges)
        if max(made, below) > self.size.factor * min(made, below):
            count = count_beside(self.levels.lines[line], made, below, self.size)
            self.course[line] = self._new_course(line, self._start(line, band), count)

    def _new_course(self, line: int, start: float, count: int) -> Chain:
        """Make a course of some stitches on a line."""
        target = self.levels.lines[line]
        place = start + target.length * np.arange(count if target.closed else count + 1) / count
        vertices = self._new_vertices(target.at(place))
        return Chain((*vertices, *vertices[:1]) if target.closed else vertices, self._new_edges(count))

    def _new_vertices(self, points: FloatArray) -> tuple[int, ...]:
        first = len(self.points)
        self.points.extend(points)
        self.recent.extend([0.0] * len(points))
        return tuple(range(first, len(self.points)))

    def _new_edges(self, count: int) -> tuple[int, ...]:
        first, self.edges = self.edges, self.edges + count
        return tuple(range(first, self.edges))

    def _divided(self, course: Chain, others: list[Chain]) -> list[Chain | None]:
        """Divide a course among the courses at the other side of its band."""
        if len(others) == 1:
            return [self._opened(course, others[0])]
        position = np.array([self.points[vertex] for vertex in course.vertices])
        middles = 0.5 * (position[1:] + position[:-1])
        lines = [np.array([self.points[vertex] for vertex in other.vertices]) for other in others]
        owner = owners(middles, lines, course.closed)
        return divide(course, owner, [other.closed for other in others], Grafts(self._graft))

    def _opened(self, course: Chain, other: Chain) -> Chain:
        """Cut a ring that faces an open course, at the foot or the head of a slit."""
        if not course.closed or other.closed:
            return course
        ends = 0.5 * (self.points[other.vertices[0]] + self.points[other.vertices[-1]])
        points = np.array([self.points[vertex] for vertex in course.vertices[:-1]])
        return course.turned(int(np.linalg.norm(points - ends, axis=1).argmin()))

    def _graft(self, first: int, last: int) -> Chain:
        """Make a graft from one vertex through the nearest saddle to another one."""
        ends = np.array([self.points[first], self.points[last]])
        path = ends
        if len(self.saddles):
            detour = np.linalg.norm(self.saddles[:, None] - ends, axis=2).sum(axis=1)
            path = np.array([ends[0], self.saddles[detour.argmin()], ends[1]])
        line = LevelLine(0, path, closed=False)
        count = max(1, round(line.length / self.size.width))
        inner = self._new_vertices(line.at(line.length * np.arange(1, count) / count))
        return Chain((first, *inner, last), self._new_edges(count))

    def _add_row(self, low: Chain, high: Chain, tube: int) -> None:
        """Add the stitches between two chains of a tube."""
        if low.closed and high.closed:
            low, high = self._aligned(low, high)
        below, above = (np.array([self.points[vertex] for vertex in chain.vertices]) for chain in (low, high))
        recent = np.array([self.recent[vertex] for vertex in low.vertices])
        penalty = ABOVE * recent + KEPT_AWAY * self.plain.hold(below)
        wales = join_courses(below, above, self.size.width, penalty)
        if wales is None:
            raise TessellationError(
                f"near {below.mean(axis=0).round(1).tolist()} cm: {len(low.edges)} stitches below and "
                f"{len(high.edges)} above one row; a stitch changes the number of loops by at most a factor of 3: "
                "choose a smaller stitch"
            )
        self._add_faces(low, high, wales.below, wales.above)
        self._mark(low, high, wales.below, wales.above)
        self.tube_of_row.append(tube)

    def _aligned(self, low: Chain, high: Chain) -> tuple[Chain, Chain]:
        """Turn two rings so that they start at vertices near each other."""
        below, above = (np.array([self.points[v] for v in chain.vertices[:-1]]) for chain in (low, high))
        apart = np.linalg.norm(below[:, None] - above[None], axis=2)
        if apart[0, 0] <= 1.2 * apart.min():
            return low, high
        one, other = np.unravel_index(apart.argmin(), apart.shape)
        return low.turned(int(one)), high.turned(int(other))

    def _add_faces(self, low: Chain, high: Chain, below: IntArray, above: IntArray) -> None:
        """Add the faces between neighbouring wale edges."""
        closed = low.closed and high.closed
        wale = [*self._new_edges(len(below) - 1)]
        wale.append(wale[0] if closed else self._new_edges(1)[0])
        for place in range(len(below) - 1):
            b, t = slice(below[place], below[place + 1]), slice(above[place], above[place + 1])
            bottom, top = low.edges[b], high.edges[t]
            corners = [*low.vertices[b.start : b.stop + 1], *high.vertices[t.start : t.stop + 1][::-1]]
            self.faces.corners.append(list(corners))
            self.faces.edges.append([*bottom, wale[place + 1], *top[::-1], wale[place]])
            self.faces.n_bottom.append(len(bottom))
            self.faces.n_top.append(len(top))
            self.faces.stitch.append(stitch_for(len(bottom), len(top), 2 * place < len(below)))
            self.faces.row.append(len(self.tube_of_row))

    def _mark(self, low: Chain, high: Chain, below: IntArray, above: IntArray) -> None:
        """Mark the loops above increases and decreases, and let the marks of the rows before fade."""
        old = np.array([self.recent[vertex] for vertex in low.vertices])[below] * FADING
        mark = np.interp(np.arange(len(high.vertices)), above, old)
        shaped = np.flatnonzero((np.diff(below) != 1) | (np.diff(above) != 1))
        for place in shaped:
            away = np.abs(np.arange(len(mark)) - 0.5 * (above[place] + above[place + 1]))
            mark = np.maximum(mark, 1.0 - away / 5.0)
        for vertex, value in zip(high.vertices, mark, strict=True):
            self.recent[vertex] = float(value)

    def stitch_mesh(self) -> StitchMesh:
        """Join all faces to a stitch mesh."""
        faces = self.faces
        corner = np.concatenate(faces.corners)
        start = np.concatenate([[0], np.cumsum([len(corners) for corners in faces.corners])])
        twin = twins_of_edges(np.concatenate(faces.edges))
        n_bottom = np.array(faces.n_bottom)
        fan = _fans(start, twin)
        shown = np.zeros(fan.max() + 1, dtype=np.int64)
        shown[fan] = corner
        return StitchMesh(
            vertices=np.array(self.points)[shown],
            face_start=start,
            face_vertex=fan,
            twin=twin,
            n_bottom=n_bottom,
            n_top=np.array(faces.n_top),
            stitch=with_cast_on(np.array(faces.stitch), start, n_bottom, twin),
            row=_tube_by_tube(self.tube_of_row, self.begun)[faces.row],
        )


def _tube_by_tube(tube_of_row: list[int], begun: dict[int, float]) -> IntArray:
    """Number of each row, in the order in which the rows were made, shape (rows,).

    Args:
        tube_of_row: tube of each row.
        begun: length of the first line of each tube in which knitting begins [cm]. These tubes come first, the longest
            line before the others; lengths are rounded, so that equal sleeves keep their order.
    """
    first = sorted(begun, key=lambda tube: (-round(begun[tube], 6), tube))
    rank = {tube: place for place, tube in enumerate(first)}
    place = [rank.get(tube, len(first) + tube) for tube in tube_of_row]
    number = np.empty(len(place), dtype=np.int64)
    number[np.argsort(place, kind="stable")] = np.arange(len(place))
    return number


def _fans(start: IntArray, twin: IntArray) -> IntArray:
    """Number of the fan of faces of each corner, shape (C,).

    Where a slit reaches the first or the last course of a fabric, the two sides of the slit share no face; each then
    gets a vertex of its own.
    """
    across = next_sides(start)[np.where(twin == BORDER, 0, twin)]
    return find_fans(np.where(twin == BORDER, BORDER, across))
