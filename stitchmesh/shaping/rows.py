# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches between level lines.

Each line becomes a course of equally wide stitches, each band a row, or one row for each of the limbs that meet in it.
The last course before a tip is left open: yarn generation draws a yarn through its loops. Rows are numbered tube by
tube: first the tube that begins at the longest line, such as the hem, then one sleeve, the other sleeve, and the body
above them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import TessellationError
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.connectivity import corner_fans, next_sides
from stitchmesh.mesh.shaping_stitches import with_increases
from stitchmesh.shaping.chains import Chain, Grafts, divide, owners
from stitchmesh.shaping.counts import (
    MOST_BESIDE,
    StitchSize,
    count_beside,
    exact_counts,
    is_part_beside,
    rounded_count,
)
from stitchmesh.shaping.level_lines import Band, LevelLine, LevelLines
from stitchmesh.shaping.plain_places import PlainPlaces
from stitchmesh.shaping.seams import (
    Gore,
    RowChange,
    SeamPlan,
    ShapedRows,
    halves,
    seam_plan,
    stacked_wales,
)
from stitchmesh.shaping.wales import ABOVE, Wales, join_courses
from stitchmesh.tessellate.stitch_faces import StitchFaces

AT_EDGE = 6.0
"""Cost of an increase or a decrease near an end of an open row, in squared stitch widths."""
BESIDE = 0.5
"""No row joins a stitch to an open course if its middle lies at least this number of stitches beside the course."""
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
"""In each round there is one place at which stitches stand exactly above each other. From one round with increases or
decreases to the next, it moves by this part of a round: the golden ratio spreads any number of places evenly."""
MOST_TURNED = 2
"""The place turns if a round has at most this number of increases or decreases; more of them stand all around
anyway."""
STITCHES_TO_TURN = 10
"""Least number of stitches of such a round for each increase or decrease."""


def stitches_between(
    levels: LevelLines, saddles: FloatArray, size: StitchSize, plain: PlainPlaces, report_part: Callable[[float], None]
) -> tuple[StitchMesh, ShapedRows, NDArray[np.bool_]]:
    """Knit all bands.

    Args:
        levels: the lines and the bands.
        saddles: points at which limbs meet [cm], shape (n, 3); grafts run through them.
        size: size of the stitches.
        plain: places from which increases and decreases are kept away.
        report_part: called at intervals with the part of the bands that is knitted, from 0 to 1.

    Returns:
        The stitches, where rows have their increases and decreases, and whether the wales of each stitch lean because
        of shaping at seams, shape (F,).

    Raises:
        TessellationError: limbs join and part within one band, or neighbouring courses differ too much.
    """
    rows = MadeRows(levels, saddles, size, plain)
    fabric = rows.knitted(report_part)
    return fabric, rows.shaped, rows.shaped.leaning(rows.tube_of_row)[fabric.row]


class MadeRows:
    """Courses and rows made so far."""

    faces_are = "stitches"
    """Name of the faces in messages."""
    edge_vertices = 3
    """Vertices at each end of an open row that increases and decreases keep from: two stitches, as knitters do."""

    def __init__(self, levels: LevelLines, saddles: FloatArray, size: StitchSize, plain: PlainPlaces) -> None:
        """Start without a course; the arguments are the same as for ``stitches_between``."""
        self.levels, self.saddles, self.size, self.plain = levels, saddles, size, plain
        self.face_width = size.width  # the unit of the distances between two courses when they are joined
        self.exact = exact_counts(levels, size)
        self.points: list[FloatArray] = []
        self.course: dict[int, Chain] = {}
        self.recent: list[float] = []
        self.stitches: list[int] = []  # along each edge
        self.faces = StitchFaces()
        self.tube: dict[int, int] = {}
        self.tubes = 0
        self.turns: dict[int, int] = {}  # rounds of each tube at which the place of increases and decreases turned
        self.begun: dict[int, float] = {}
        self.tube_of_row: list[int] = []
        ends = {band.below[0] for band in levels.bands if not band.above and len(band.below) == 1}
        self.last_courses = ends - levels.borders
        self.shaped = ShapedRows()
        # Rounds of whole repeats change by more than the stitches beside seams.
        stacks = size.shaping == "seams" and size.multiple == 1
        self.seam_plan = seam_plan(levels, self.exact, size) if stacks else SeamPlan({}, {})
        self.seams: dict[int, IntArray] = {}  # places of the seams along each course
        self.gores: dict[int, list[Gore]] = {}  # the gores of the row below a line, if its shaping is at seams

    def knitted(self, report_part: Callable[[float], None]) -> StitchMesh:
        """Add the rows of all bands, and join their faces to a stitch mesh."""
        for number, band in enumerate(self.levels.bands):
            # Bands from one report of the progress to the next.
            if number % 20 == 0:
                report_part(number / len(self.levels.bands))
            self._knit(band)
        return self._stitch_mesh()

    def _knit(self, band: Band) -> None:
        """Add the rows of a band."""
        if not band.below or not band.above:
            self._finish(band)
            return
        for line in band.above:
            self._make_course_above(line, band)
        if len(band.below) > 1 and len(band.above) > 1:
            place = self.levels.lines[band.below[0]].points.mean(axis=0).round(1).tolist()
            raise TessellationError(
                f"near {place} cm: limbs join and part within one row; choose a smaller stitch, or mark other ends"
            )
        if len(band.above) == 1:
            self._join(band.below, band.above[0])
        else:
            self._part(band.below[0], band.above)

    def _join(self, below: Sequence[int], above: int) -> None:
        """Add the rows from the courses on one or several lines to the course on the line above them."""
        self.tube[above] = self.tube[below[0]] if len(below) == 1 else self._new_tube()
        for line, high in zip(below, self._divided(above, below), strict=True):
            if high is not None:
                self._add_row(self._opened(self.course[line], high), high, self.tube[line], above)

    def _part(self, below: int, above: Sequence[int]) -> None:
        """Add the rows from the course on a line to the courses on several lines above it."""
        for line, low in zip(above, self._divided(below, above), strict=True):
            self.tube[line] = self._new_tube()
            if low is not None:
                self._fit_to(line, below, self._stitches_of(low))
                self._add_row(low, self.course[line], self.tube[line])

    def _new_tube(self) -> int:
        """Number of a further tube; a tube that continues others has a larger number than they have."""
        self.tubes += 1
        return self.tubes - 1

    def _finish(self, band: Band) -> None:
        """Begin the courses above a place where rows begin; nothing is knitted above courses that end.

        Where a strap is highest or a crotch is lowest, two open courses face each other: a row between them joins them
        as a knitter grafts a shoulder.
        """
        for line in band.above:
            tip = line not in self.levels.borders
            self.tube[line] = self._new_tube()
            self.begun[self.tube[line]] = self.levels.lines[line].length
            count = rounded_count(self.levels.lines[line], self.exact[line], self.size, tip=tip)
            self._make_course(line, (), count, None)
        facing = band.below or band.above
        if len(facing) == 2 and not any(self.levels.lines[line].closed for line in facing):
            one, other = (self.course[line] for line in facing)
            low, high = (one, other.reversed()) if band.below else (one.reversed(), other)
            self._add_row(low, high, self.tube[facing[1]])

    def _make_course_above(self, line: int, band: Band) -> None:
        """Make the course on a line above a band."""
        lines = self.levels.lines
        if len(band.below) == len(band.above) == 1 and not is_part_beside(lines[band.below[0]], lines[line]):
            below = self.course[band.below[0]]
            self._find_gores(line, band.below[0])
            self._make_course(line, band.below, self._count_above(line, self._stitches_of(below)), below)
        else:
            count = rounded_count(self.levels.lines[line], self.exact[line], self.size)
            self._make_course(line, band.below, count, None)

    def _stitches_of(self, chain: Chain) -> int:
        """Number of stitches along a chain."""
        return sum(self.stitches[edge] for edge in chain.edges)

    def _start(self, line: int, below: Sequence[int]) -> float:
        """Length along a line at which its course starts [cm], for a round above the nearest start of a course below.

        Args:
            line: number of the line.
            below: numbers of the lines below; none where rows begin.
        """
        target = self.levels.lines[line]
        if not target.closed or not below:
            return 0.0
        found = [target.nearest(self.points[self.course[number].vertices[0]]) for number in below]
        return min(found, key=lambda pair: pair[1])[0]

    def _count_above(self, line: int, below: int) -> int:
        """Number of stitches of a course above a single one.

        A course that is plain all along keeps the stitches of the course below, as does the last one before a tip.
        """
        target = self.levels.lines[line]
        # If the round below the last one at a tip has at most this number of stitches, all of them are plain: the
        # yarn that is drawn through the last loops does not pass well through a decrease and its neighbours.
        is_tip = line in self.last_courses and below <= 20
        if is_tip or (below % self.size.step(target) == 0 and self.plain.hold(target.points).all()):
            return below
        if line in self.gores:
            return sum(gore.above for gore in self.gores[line])
        return count_beside(target, self.exact[line], below, self.size)

    def _fit_to(self, line: int, below: int, count: int) -> None:
        """Make the course of a limb again if no row can join it to the part of the course below that the limb gets.

        Args:
            line: number of the line of the limb.
            below: number of the line below.
            count: stitches that it gets.
        """
        made = self._stitches_of(self.course[line])
        if max(made, count) > self.size.factor * min(made, count):
            fitting = count_beside(self.levels.lines[line], made, count, self.size)
            self._make_course(line, (below,), fitting, None)

    def _make_course(self, line: int, beside: Sequence[int], count: int, below: Chain | None) -> None:
        """Make a course of some stitches on a line.

        Args:
            line: number of the line.
            beside: numbers of the lines below it.
            count: number of stitches.
            below: the course below, if it is the only one below and this is the only one above it.
        """
        target = self.levels.lines[line]
        start = self._seamed_start(line, beside, count)
        if below is not None and line not in self.gores and self._turns(target, count, below):
            start += self._phase(target, start, count, below, self.tube[beside[0]])
        along = self._edges_along(line, start, count, below)
        place = start + target.length * np.concatenate([[0], np.cumsum(along)]) / count
        vertices = self._new_vertices(target.at(place[:-1] if target.closed else place))
        self.course[line] = Chain((*vertices, *vertices[:1]) if target.closed else vertices, self._new_edges(along))

    def _find_gores(self, line: int, below: int) -> None:
        """Find the gores of the row below a line, unless its increases and decreases have no room at the seams."""
        change, chain = self.seam_plan.changes.get(line), self.course[below]
        if change is None or below not in self.seams:
            return
        ends = np.concatenate([[] if chain.closed else [0], self.seams[below], [len(chain.edges)]]).astype(np.int64)
        gores = change.gores(np.diff(ends).tolist(), chain.closed)
        at_seams = np.array([self.points[chain.vertices[place]] for place in ends])
        if all(gore.possible for gore in gores) and (change == RowChange() or not self.plain.hold(at_seams).any()):
            self.gores[line] = gores

    def _seamed_start(self, line: int, beside: Sequence[int], count: int) -> float:
        """Length along a line at which its course starts [cm], with the seams where they are in the course below.

        Args:
            line: number of the line.
            beside: numbers of the lines below it.
            count: number of stitches of the course.
        """
        target = self.levels.lines[line]
        if line in self.seam_plan.starts:
            points = self.seam_plan.starts[line]
        elif len(beside) == 1 and beside[0] in self.seams and self.levels.lines[beside[0]].closed == target.closed:
            below = self.course[beside[0]]
            points = np.array([self.points[below.vertices[place]] for place in self.seams[beside[0]]]).reshape(-1, 3)
        else:
            return self._start(line, beside)
        along = np.array([target.nearest(point)[0] for point in points])
        first = along[0] if target.closed else 0.0
        gores = self.gores.get(line, [])
        if sum(gore.above for gore in gores) == count:
            ends = np.cumsum([gore.above for gore in gores])[:-1]
            seams = np.append(0, ends) if target.closed else ends
        else:
            self.gores.pop(line, None)
            seams = np.rint(np.mod(along - first, target.length) / target.length * count).astype(np.int64) % count
        self.seams[line] = seams
        away = along - first - seams * target.length / count
        return float(first + np.mean(away - target.length * np.rint(away / target.length))) if target.closed else 0.0

    def _turns(self, target: LevelLine, count: int, below: Chain) -> bool:
        """Whether a course is a round with so few increases or decreases that all of them would stand in one place.

        Args:
            target: line of the course.
            count: number of its stitches.
            below: the course below.
        """
        changed = abs(count - self._stitches_of(below))
        return target.closed and below.closed and 0 < changed <= min(MOST_TURNED, count / STITCHES_TO_TURN)

    def _phase(self, target: LevelLine, start: float, count: int, below: Chain, tube: int) -> float:
        """Length by which a round moves along its line [cm], up to about half a stitch.

        The stitches of two rounds are equally wide. If their numbers differ, increases and decreases stand far from the
        place at which the rounds fit. This place therefore turns from one such round of a tube to the next.
        """
        turn = self.turns[tube] = self.turns.get(tube, 0) + 1
        fitting = below.vertices[int(GOLDEN * turn % 1.0 * len(below.edges))]
        width = target.length / count
        away = target.nearest(self.points[fitting])[0] - start
        least = -0.4837 * width  # about half a stitch; at exactly half a one rounding would choose the side
        return float((away - least) % width + least)

    def _edges_along(self, line: int, start: float, count: int, below: Chain | None) -> IntArray:
        """Number of stitches along each edge of the course on a line, here one, shape (edges,)."""
        return np.ones(count, dtype=np.int64)

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

    def _divided(self, whole: int, limbs: Sequence[int]) -> list[Chain | None]:
        """Divide the course on a line among the courses on the lines at the other side of its band."""
        course, others = self.course[whole], [self.course[line] for line in limbs]
        if len(others) == 1:
            return [self._opened(course, others[0])]
        found = divide(course, self._owners(whole, limbs), [other.closed for other in others], Grafts(self._graft))
        return [
            chain if chain is None or chain.closed else self._beside(chain, other)
            for chain, other in zip(found, others, strict=True)
        ]

    def _owners(self, whole: int, limbs: Sequence[int]) -> IntArray:
        """Place, in ``limbs``, of the line that gets each edge of the course on ``whole``, shape (edges,)."""
        course, others = self.course[whole], [self.course[line].vertices for line in limbs]
        position = np.array([self.points[vertex] for vertex in course.vertices])
        lines = [np.array([self.points[vertex] for vertex in vertices]) for vertices in others]
        return owners(0.5 * (position[1:] + position[:-1]), lines, course.closed)

    def _opened(self, course: Chain, other: Chain) -> Chain:
        """Cut a ring that faces an open course, at the foot or the head of a slit."""
        if not course.closed or other.closed:
            return course
        if len(other.edges) < MOST_BESIDE * len(course.edges):
            return self._part_along(course, other)
        ends = 0.5 * (self.points[other.vertices[0]] + self.points[other.vertices[-1]])
        points = np.array([self.points[vertex] for vertex in course.vertices[:-1]])
        return self._beside(course.turned(int(np.linalg.norm(points - ends, axis=1).argmin())), other)

    def _part_along(self, chain: Chain, other: Chain) -> Chain:
        """The part of a long chain beside a short course, between the vertices nearest to the ends of that course."""
        points = np.array([self.points[vertex] for vertex in chain.vertices[: len(chain.edges) + (not chain.closed)]])
        first, last = (
            int(np.linalg.norm(points - self.points[other.vertices[end]], axis=1).argmin()) for end in (0, -1)
        )
        if chain.closed and last <= first:
            last += len(chain.edges)
        return chain.part(first, last) if first < last else chain

    def _beside(self, chain: Chain, other: Chain) -> Chain:
        """The part of a chain beside an open course: stitches of the other part are bound off, or cast on.

        Args:
            chain: an open chain, or a ring that is cut at its first vertex.
            other: the course; the whole chain is beside a ring.
        """
        if other.closed:
            return chain
        points = np.array([self.points[vertex] for vertex in chain.vertices])
        step = np.diff(points, axis=0)
        along = step / np.linalg.norm(step, axis=1)[:, None]
        middle = 0.5 * (points[1:] + points[:-1])
        before = np.einsum("ei,ei->e", self.points[other.vertices[0]] - middle, along) > BESIDE * self.face_width
        after = np.einsum("ei,ei->e", middle - self.points[other.vertices[-1]], along) > BESIDE * self.face_width
        first, last = int(np.argmin(before)), len(after) - int(np.argmin(after[::-1]))
        if first + MOST_BESIDE * len(after) < last:
            return chain.part(first, last)
        return self._part_along(chain, other)

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
        """Number of stitches along each edge of a graft with some stitches, here one, shape (edges,)."""
        return np.ones(count, dtype=np.int64)

    def _add_row(self, low: Chain, high: Chain, tube: int, line: int | None = None) -> None:
        """Add the stitches between two chains of a tube; ``line`` is the line of the upper one if that is whole."""
        gores = None if line is None else self.gores.get(line)
        if gores is None:
            if low.closed and high.closed:
                low, high = self._aligned(low, high)
            wales = self._spread_wales(low, high)
            left = halves(wales)
        else:
            wales, left = stacked_wales(gores)
        self._add_faces(low, high, wales, left)
        self._mark(low, high, wales.below, wales.above)
        self.shaped.add(wales, stacked=gores is not None)
        self.tube_of_row.append(tube)

    def _spread_wales(self, low: Chain, high: Chain) -> Wales:
        """The wale edges between two chains, with increases and decreases that are spread.

        Raises:
            TessellationError: the numbers of their edges differ too much.
        """
        below, above = (np.array([self.points[vertex] for vertex in chain.vertices]) for chain in (low, high))
        recent = np.array([self.recent[vertex] for vertex in low.vertices])
        # Cost of an increase or a decrease in a plain place, in squared stitch widths; wales lean rather than pay
        # it.
        penalty = ABOVE * recent + 1000.0 * self.plain.hold(below)
        if not (low.closed and high.closed):
            penalty[: self.edge_vertices] += AT_EDGE
            penalty[len(penalty) - self.edge_vertices :] += AT_EDGE
        wales = join_courses(below, above, self.face_width, penalty)
        if wales is None:
            raise TessellationError(
                f"near {below.mean(axis=0).round(1).tolist()} cm: {len(low.edges)} {self.faces_are} below and "
                f"{len(high.edges)} above one row; the number changes by at most a factor of 3: choose smaller "
                f"{self.faces_are}"
            )
        return wales

    def _aligned(self, low: Chain, high: Chain) -> tuple[Chain, Chain]:
        """Turn two rings so that they start at vertices near each other."""
        below, above = (np.array([self.points[v] for v in chain.vertices[:-1]]) for chain in (low, high))
        apart = np.linalg.norm(below[:, None] - above[None], axis=2)
        if apart[0, 0] <= 1.2 * apart.min():
            return low, high
        one, other = np.unravel_index(apart.argmin(), apart.shape)
        return low.turned(int(one)), high.turned(int(other))

    def _add_faces(self, low: Chain, high: Chain, wales: Wales, left: NDArray[np.bool_]) -> None:
        """Add the faces between neighbouring wale edges.

        Args:
            low: the chain below.
            high: the chain above.
            wales: the wale edges.
            left: whether each increase or decrease leans as at the left end of a row.
        """
        closed = low.closed and high.closed
        wale = self._new_edges(np.ones(len(wales.below) - closed, dtype=np.int64))
        self.faces.add_row(
            low.row_boundary(wales.below), high.row_boundary(wales.above), (*wale, *wale[:1]) if closed else wale,
            left, len(self.tube_of_row),
        )  # fmt: skip

    def _mark(self, low: Chain, high: Chain, below: IntArray, above: IntArray) -> None:
        """Mark the loops above increases and decreases, and let the marks of the rows before fade."""
        # Part of the mark of an increase or a decrease that remains in the next row. Marks make the next one stand
        # elsewhere.
        old = np.array([self.recent[vertex] for vertex in low.vertices])[below] * 0.8
        mark = np.interp(np.arange(len(high.vertices)), above, old)
        shaped = np.flatnonzero((np.diff(below) != 1) | (np.diff(above) != 1))
        for place in shaped:
            away = np.abs(np.arange(len(mark)) - 0.5 * (above[place] + above[place + 1]))
            mark = np.maximum(mark, 1.0 - away / 5.0)
        for vertex, value in zip(high.vertices, mark, strict=True):
            self.recent[vertex] = float(value)

    def _stitch_mesh(self) -> StitchMesh:
        """Join all faces to a stitch mesh."""
        faces = self.faces.gathered()
        # Where a slit reaches the first or the last course of a fabric, the two sides of the slit share no face; each
        # then gets a vertex of its own.
        fan = corner_fans(faces.twin, next_sides(faces.start))
        shown = np.zeros(fan.max() + 1, dtype=np.int64)
        shown[fan] = faces.corner
        row = _tube_by_tube(self.tube_of_row, self.begun)[faces.row]
        return with_increases(replace(faces, corner=fan, row=row).mesh(np.array(self.points)[shown]))


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
