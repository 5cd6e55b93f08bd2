# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches between level lines.

Each line becomes a course of equally wide stitches, each band a row, or one row for each of the limbs that meet in it.
The last course before a tip is left open: yarn generation draws a yarn through its loops.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import TessellationError
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.connectivity import find_fans, next_sides
from stitchmesh.shaping.chains import Chain, Grafts, divide, owners
from stitchmesh.shaping.level_lines import Band, LevelLine, LevelLines
from stitchmesh.shaping.wales import ABOVE, join_courses
from stitchmesh.tessellate.panel import StitchFaces, stitch_for
from stitchmesh.tessellate.tessellate import twins_of_edges, with_cast_on

SLACK = 0.7
"""Difference of a number of stitches from the exact one up to which the number of the course below is kept."""
SMALLEST_RING = 4
"""Stitches in the smallest round."""
SMALLEST_TIP = 5
"""Stitches in the smallest round at a tip; through fewer loops the drawn yarn does not pass as it should."""
LARGEST_TIP = 20
"""Stitches in the largest round below the last one at a tip whose stitches are all plain: the yarn that is drawn
through the last loops does not pass well through a decrease and its neighbours."""
FADING = 0.8
"""Part of the mark of an increase or a decrease that stays from row to row, so that the next one stands elsewhere."""


@dataclass(frozen=True)
class StitchSize:
    """Size of the stitches, and the numbers that a pattern asks for."""

    width: float
    """Width of a stitch [cm]."""
    height: float
    """Height of a stitch [cm]."""
    multiple: int = 1
    """Number that the stitches of each round are a multiple of."""


def stitches_between(levels: LevelLines, saddles: FloatArray, size: StitchSize) -> StitchMesh:
    """Knit all bands.

    Args:
        levels: the lines and the bands.
        saddles: points at which limbs meet [cm], shape (n, 3); grafts run through them.
        size: size of the stitches.

    Raises:
        TessellationError: limbs join and part within one band, or neighbouring courses differ too much.
    """
    return Rows(levels, saddles, size).knitted()


class Rows:
    """Courses and rows made so far."""

    faces_are = "stitches"
    """Name of the faces in messages."""

    def __init__(self, levels: LevelLines, saddles: FloatArray, size: StitchSize) -> None:
        """Start without a course; the arguments are those of ``stitches_between``."""
        self.levels, self.saddles, self.size = levels, saddles, size
        self.face_width = size.width  # the unit of the distances between two courses when they are joined
        self.points: list[FloatArray] = []
        self.course: dict[int, Chain] = {}
        self.recent: list[float] = []
        self.stitches: list[int] = []
        self.faces = StitchFaces()
        self.row = 0
        ends = {band.below[0] for band in levels.bands if not band.above and len(band.below) == 1}
        self.last_courses = ends - levels.borders

    def knitted(self) -> StitchMesh:
        """Add the rows of all bands, and join their faces to a stitch mesh."""
        for band in self.levels.bands:
            self._knit(band)
        return self._stitch_mesh()

    def _knit(self, band: Band) -> None:
        """Add the rows of a band."""
        lines = self.levels.lines
        if not band.below or not band.above:
            self._finish(band)
            return
        for line in band.above:
            self._make_course_above(line, band)
        if len(band.below) > 1 and len(band.above) > 1:
            place = lines[band.below[0]].points.mean(axis=0).round(1).tolist()
            raise TessellationError(
                f"near {place} cm: limbs join and part within one row; choose smaller stitches, or mark other ends"
            )
        joins = len(band.above) == 1
        whole, limbs = (band.above[0], band.below) if joins else (band.below[0], band.above)
        for limb, part in zip(limbs, self._divided(whole, limbs, Grafts(self._graft)), strict=True):
            if part is not None:
                self._add_row(*((self.course[limb], part) if joins else (part, self.course[limb])))

    def _finish(self, band: Band) -> None:
        """Begin the courses above a place where rows begin; nothing is knitted above courses that end."""
        for line in band.above:
            self.course[line] = self._new_course(line, self._start(line, []), None, begins=True)

    def _edges_along(self, line: int, start: float, below: Chain | None, *, begins: bool) -> IntArray:
        """Number of stitches along each edge of the course on a line, here one, shape (edges,).

        Args:
            line: number of the line.
            start: length along the line at which the course starts [cm].
            below: the course below, if it is the only one below and this is the only one above it.
            begins: whether rows begin at this course.
        """
        return np.ones(self._count(line, below, begins=begins), dtype=np.int64)

    def _count(self, line: int, below: Chain | None, *, begins: bool) -> int:
        """Number of stitches of a course, near that of the course below."""
        target, before = self.levels.lines[line], None if below is None else self._stitches_of(below)
        if before is not None and line in self.last_courses and before <= LARGEST_TIP:
            return before
        exact = target.length / self.size.width
        step = self.size.multiple if target.closed else 1
        if before is not None and before % step == 0 and abs(exact - before) <= SLACK * step:
            return before
        # Rounding is done on a rounded number, so that equal limbs have equal numbers.
        count = step * int(np.floor(round(exact / step, 6) + 0.5))
        is_tip = begins and line not in self.levels.borders
        least = (SMALLEST_TIP if is_tip else SMALLEST_RING) if target.closed else 1
        return max(count, step * -(-least // step))

    def _stitches_of(self, chain: Chain) -> int:
        """Number of stitches along a chain."""
        return sum(self.stitches[edge] for edge in chain.edges)

    def _make_course_above(self, line: int, band: Band) -> None:
        """Make the course on a line above a band."""
        plain = len(band.below) == len(band.above) == 1
        below = [self.course[number] for number in band.below]
        start = self._start(line, below)
        self.course[line] = self._new_course(line, start, below[0] if plain else None, begins=False)

    def _start(self, line: int, below: Sequence[Chain]) -> float:
        """Length along a line at which its course starts [cm]: a round starts above the start of the nearest course."""
        target = self.levels.lines[line]
        if not target.closed or not below:
            return 0.0
        found = [target.nearest(self.points[chain.vertices[0]]) for chain in below]
        return min(found, key=lambda pair: pair[1])[0]

    def _new_course(self, line: int, start: float, below: Chain | None, *, begins: bool) -> Chain:
        """Make a course on a line; the other arguments are those of ``_edges_along``."""
        target, along = self.levels.lines[line], self._edges_along(line, start, below, begins=begins)
        place = start + target.length * np.concatenate([[0], np.cumsum(along)]) / along.sum()
        vertices = self._new_vertices(target.at(place[:-1] if target.closed else place))
        return Chain((*vertices, *vertices[:1]) if target.closed else vertices, self._new_edges(along))

    def _new_vertices(self, points: FloatArray) -> tuple[int, ...]:
        first = len(self.points)
        self.points.extend(points)
        self.recent.extend([0.0] * len(points))
        return tuple(range(first, len(self.points)))

    def _new_edges(self, stitches: IntArray) -> tuple[int, ...]:
        """Make edges, each with some stitches along it."""
        first = len(self.stitches)
        self.stitches.extend(stitches.tolist())
        return tuple(range(first, len(self.stitches)))

    def _divided(self, whole: int, limbs: Sequence[int], grafts: Grafts) -> list[Chain | None]:
        """Divide the course on a line among those on the lines at the other side of its band."""
        course, others = self.course[whole], [self.course[line] for line in limbs]
        if len(others) == 1:
            return [self._opened(course, others[0])]
        return divide(course, self._owners(whole, limbs), [other.closed for other in others], grafts)

    def _owners(self, whole: int, limbs: Sequence[int]) -> IntArray:
        """Place, among some lines, of the line that gets each edge of the course on another one, shape (edges,)."""
        course, others = self.course[whole], [self.course[line].vertices for line in limbs]
        position = np.array([self.points[vertex] for vertex in course.vertices])
        lines = [np.array([self.points[vertex] for vertex in vertices]) for vertices in others]
        return owners(0.5 * (position[1:] + position[:-1]), lines, course.closed)

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
        along = self._edges_of_graft(max(1, round(line.length / self.size.width)))
        inner = self._new_vertices(line.at(line.length * np.cumsum(along)[:-1] / along.sum()))
        return Chain((first, *inner, last), self._new_edges(along))

    def _edges_of_graft(self, count: int) -> IntArray:
        """Number of stitches along each edge of a graft with some stitches."""
        return np.ones(count, dtype=np.int64)

    def _add_row(self, low: Chain, high: Chain) -> None:
        """Add the stitches between two chains."""
        if low.closed and high.closed:
            low, high = self._aligned(low, high)
        below, above = (np.array([self.points[vertex] for vertex in chain.vertices]) for chain in (low, high))
        recent = np.array([self.recent[vertex] for vertex in low.vertices])
        wales = join_courses(below, above, self.face_width, ABOVE * recent)
        if wales is None:
            raise TessellationError(
                f"near {below.mean(axis=0).round(1).tolist()} cm: {len(low.edges)} {self.faces_are} below and "
                f"{len(high.edges)} above one row; the number changes by at most a factor of 3: choose smaller "
                f"{self.faces_are}"
            )
        self._add_faces(low, high, wales.below, wales.above)
        self._mark(low, high, wales.below, wales.above)
        self.row += 1

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
        wale = list(self._new_edges(np.ones(len(below) - closed, dtype=np.int64)))
        wale += wale[:1] if closed else []
        for place in range(len(below) - 1):
            b, t = slice(below[place], below[place + 1]), slice(above[place], above[place + 1])
            bottom, top = low.edges[b], high.edges[t]
            corners = [*low.vertices[b.start : b.stop + 1], *high.vertices[t.start : t.stop + 1][::-1]]
            self.faces.corners.append(list(corners))
            self.faces.edges.append([*bottom, wale[place + 1], *top[::-1], wale[place]])
            self.faces.n_bottom.append(len(bottom))
            self.faces.n_top.append(len(top))
            self.faces.stitch.append(stitch_for(len(bottom), len(top), 2 * place < len(below)))
            self.faces.row.append(self.row)

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

    def _stitch_mesh(self) -> StitchMesh:
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
            row=np.array(faces.row),
        )


def _fans(start: IntArray, twin: IntArray) -> IntArray:
    """Number of the fan of faces of each corner, shape (C,).

    Where a slit reaches the first or the last course of a fabric, the two sides of the slit share no face; each then
    gets a vertex of its own.
    """
    across = next_sides(start)[np.where(twin == BORDER, 0, twin)]
    return find_fans(np.where(twin == BORDER, BORDER, across))
