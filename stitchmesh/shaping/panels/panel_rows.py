# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stitches of panels: rows that end at the sides of the outline.

A row that is a little shorter than the row below has decreases. If it is much shorter, the loops beside it are left to
be bound off. A row that is much longer casts on beside the row below. In the same way a row parts into two at a neck,
whose loops are bound off, and two rows become one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from stitchmesh.errors import TessellationError
from stitchmesh.mesh import FloatArray
from stitchmesh.shaping.chains import Chain
from stitchmesh.shaping.counts import SLACK, StitchSize
from stitchmesh.shaping.level_lines import Band, LevelLine, LevelLines
from stitchmesh.shaping.panels.panel_time import Hem
from stitchmesh.shaping.rows import AT_EDGE, MadeRows
from stitchmesh.shaping.seams import Gore, RowChange, ShapedRows, halves, seam_plan, stacked_wales
from stitchmesh.shaping.wales import Wales, join_courses
from stitchmesh.tessellate.stitch_faces import StitchFaces

GENTLE = 1
"""Stitches by which a row may be shorter or longer at one end than the row below without binding off or casting on."""
NEAR_IN_PATTERN = 8.0
"""Factor, in the flat pattern, of the distance up to which two ends of courses meet: the sides of a dart are apart
there."""
BESIDE = 0.05
"""Distance from a vertex, in stitch widths, up to which an end of a line counts as beside it."""
SHORTEST_TIP = 4.0
"""Length of the shortest last course below a rounded end, such as a cap, in stitch widths: loops bound off beside a
shorter course do not hold."""


@dataclass(frozen=True)
class RowEnd:
    """The wale edge at one end of a row."""

    panel: int
    """The panel."""
    edge: int
    """Number of the edge."""
    vertices: tuple[int, int]
    """Its lower and its upper vertex."""
    right: bool
    """Whether it is the right end of the row."""


@dataclass(frozen=True, eq=False)
class _Course:
    """A course on a line."""

    line: LevelLine
    chain: Chain
    place: FloatArray
    """Length along the line to each vertex [cm], shape (edges + 1,)."""

    def followed_by(self, other: _Course) -> _Course:
        """Return the course and another one that starts at its end."""
        assert self.line.flat is not None and other.line.flat is not None
        points = np.concatenate([self.line.points, other.line.points[1:]])
        flat = np.concatenate([self.line.flat, other.line.flat[1:]])
        line = LevelLine(self.line.level, points, closed=False, flat=flat)
        place = np.concatenate([self.place, self.place[-1] + other.place[1:]])
        return _Course(line, self.chain.followed_by(other.chain), place)

    def ends_at(self, other: _Course, near: float) -> bool:
        """Return whether another course starts at most ``near`` [cm] from the end of this one, as at the tip of a dart.

        In the flat pattern the two may be ``NEAR_IN_PATTERN`` times as far apart, but not as far as the sides of a
        sleeve.
        """
        assert self.line.flat is not None and other.line.flat is not None
        in_space = np.linalg.norm(self.line.points[-1] - other.line.points[0])
        in_pattern = np.linalg.norm(self.line.flat[-1] - other.line.flat[0])
        return bool(in_space <= near and in_pattern <= NEAR_IN_PATTERN * near)

    def vertex_beside(self, point: FloatArray, *, first: bool) -> int:
        """Return the place, in the chain, of the vertex just outside an end of another line.

        ``point`` is that end in the flat pattern. Rows of loops that are bound off then follow the outline without
        going back. Distances are measured in the flat pattern, because the two sides of a panel may lie on each other
        in space, as the sides of a sleeve do.
        """
        flat = self.line.flat_at(self.place)
        spacing = self.line.length / len(self.chain.edges)
        nearest = int(np.linalg.norm(flat - point, axis=1).argmin())
        outside = nearest - 1 if first else nearest + 1
        if not 0 <= outside < len(self.place):
            return nearest
        at, away = flat[[nearest, outside]]
        return outside if float((point - at) @ (away - at)) > BESIDE * spacing**2 else nearest


@dataclass
class PanelStitches:
    """The stitches of all panels made so far."""

    size: StitchSize
    points: list[FloatArray] = field(default_factory=list)
    """Position of each vertex [cm]."""
    faces: StitchFaces = field(default_factory=StitchFaces)
    edges: int = 0
    """Number of edges."""
    face_panel: list[int] = field(default_factory=list)
    """Panel of each face."""
    row_ends: list[RowEnd] = field(default_factory=list)
    hem_edges: dict[int, tuple[int, ...]] = field(default_factory=dict)
    """Edges along each piece of an outline that is a hem, from left to right."""
    rows: int = 0
    """Number of rows."""
    shaped: ShapedRows = field(default_factory=ShapedRows)
    """Where rows have increases and decreases."""

    def knit(self, panel: int, levels: LevelLines, hems: Sequence[Hem]) -> None:
        """Knit a panel.

        Raises:
            TessellationError: the panel is narrower than two stitches or lower than a row, a row would be a ring, or
                two neighbouring rows differ too much.
        """
        _check_lines(levels, self.size)
        courses: dict[int, _Course] = {}
        first, wanted = self.rows, _counts_below_hems(levels, hems)
        exact = np.array([line.length for line in levels.lines]) / self.size.width
        changes = seam_plan(levels, exact, self.size).changes if self.size.shaping == "seams" else {}
        for band in levels.bands:
            change = changes.get(band.above[0]) if len(band.below) == len(band.above) == 1 else None
            self._make_courses(levels, band, hems, courses, wanted, change)
            # Two courses become one if the end of the first is at most this far from the start of the second, in
            # stitch widths.
            low, high = (
                _end_to_end([courses[line] for line in lines if line in courses], 0.25 * self.size.width)
                for lines in (band.below, band.above)
            )
            for joint in _joints(low, high):
                self._add_row(panel, joint, change)
        if self.rows == first:
            place = levels.lines[0].points.mean(axis=0).round(1).tolist()
            raise TessellationError(f"near {place} cm: no room for one row of stitches; choose a smaller stitch")

    def _make_courses(
        self, levels: LevelLines, band: Band, hems: Sequence[Hem], courses: dict[int, _Course], wanted: dict[int, int],
        change: RowChange | None,
    ) -> None:  # fmt: skip
        """Make the missing courses of a band; ``change`` is the shaping at the ends of its only row."""
        last = {band.below[0] for band in levels.bands if len(band.below) == 1 and not band.above}
        # Hems have given numbers of stitches; the other lines get the rest of the course below.
        for number in sorted([*band.below, *band.above], key=lambda number: number not in levels.borders):
            line = levels.lines[number]
            # Length of the shortest course, in stitch widths.
            shortest = SHORTEST_TIP if number in last - levels.borders else 0.75
            if number in courses or line.length < shortest * self.size.width:
                continue
            hem = _hem_on(line, hems) if number in levels.borders else None
            if hem is not None:
                courses[number] = self._hem_course(line, hem)
            else:
                below, beside = ([len(courses[one].chain.edges) for one in lines if one in courses]
                                 for lines in (band.below, band.above))  # fmt: skip
                left = sum(below) - sum(beside) if number in band.above else 0
                if change is not None and number in band.above and number not in wanted and left > 0:
                    courses[number] = self._even_course(line, left + change.left + change.right)
                else:
                    courses[number] = self._course(line, wanted.get(number, left))

    def _course(self, line: LevelLine, kept: int) -> _Course:
        """Make a course of equally wide stitches: ``kept`` stitches if their width permits it."""
        exact = line.length / self.size.width
        count = kept if kept > 0 and abs(exact - kept) <= SLACK else max(1, round(exact))
        return self._even_course(line, count)

    def _even_course(self, line: LevelLine, count: int) -> _Course:
        """Make a course of some equally wide stitches."""
        return self._chain_on(line, line.length * np.arange(count + 1) / count)

    def _hem_course(self, line: LevelLine, hem: Hem) -> _Course:
        """Make the course of a hem, whose parts have given numbers of stitches."""
        scale = line.length / sum(part.length for part in hem.parts)
        place, edges = [np.zeros(1)], self.edges
        for part in hem.parts:
            place.append(place[-1][-1] + scale * part.length * np.arange(1, part.count + 1) / part.count)
            self.hem_edges[part.piece] = tuple(range(edges, edges + part.count))
            edges += part.count
        return self._chain_on(line, np.concatenate(place))

    def _chain_on(self, line: LevelLine, place: FloatArray) -> _Course:
        first = len(self.points)
        self.points.extend(line.at(place))
        return _Course(line, Chain(tuple(range(first, len(self.points))), self._new_edges(len(place) - 1)), place)

    def _new_edges(self, count: int) -> tuple[int, ...]:
        first, self.edges = self.edges, self.edges + count
        return tuple(range(first, self.edges))

    def _add_row(self, panel: int, joint: _Joint, change: RowChange | None) -> None:
        """Add the stitches of a row, with shaping at its ends if it joins two whole courses."""
        gore = None if change is None else Gore(len(joint.low.chain.edges), change.left, change.right)
        stacked = gore is not None and gore.possible and joint.is_whole and gore.above == len(joint.high.chain.edges)
        wales: Wales | None
        if gore is not None and stacked:
            wales, left = stacked_wales([gore])
        else:
            wales = self._wales(joint) or self._wales(joint := joint.narrowed())
            left = np.zeros(0, dtype=bool) if wales is None else halves(wales)
        low, high = joint.low_part, joint.high_part
        if wales is None:
            raise TessellationError(
                f"near {self.points[low.vertices[0]].round(1).tolist()} cm {len(high.edges)} stitches "
                f"stand above {len(low.edges)}; a stitch changes the number of loops by at most a factor of 3: choose "
                "a smaller stitch"
            )
        wale = self._new_edges(len(wales.below))
        below, above = low.row_boundary(wales.below), high.row_boundary(wales.above)
        self.faces.add_row(below, above, wale, left, self.rows)
        self.face_panel += [panel] * (len(wale) - 1)
        self._note_row_ends(panel, joint, wale)
        self.shaped.add(wales, stacked=stacked)
        self.rows += 1

    def _wales(self, joint: _Joint) -> Wales | None:
        below, above = (
            np.array([self.points[vertex] for vertex in chain.vertices])
            for chain in (joint.low_part, joint.high_part)
        )  # fmt: skip
        penalty = np.zeros(len(below))
        penalty[: MadeRows.edge_vertices] += AT_EDGE
        penalty[len(penalty) - MadeRows.edge_vertices :] += AT_EDGE
        return join_courses(below, above, self.size.width, penalty)

    def _note_row_ends(self, panel: int, joint: _Joint, wale: tuple[int, ...]) -> None:
        """Remember the ends of a row that lie on the outline."""
        low, high = joint.low_part, joint.high_part
        if joint.low_range[0] == joint.high_range[0] == 0:
            self.row_ends.append(RowEnd(panel, wale[0], (low.vertices[0], high.vertices[0]), False))
        if (joint.low_range[1], joint.high_range[1]) == joint.whole:
            self.row_ends.append(RowEnd(panel, wale[-1], (low.vertices[-1], high.vertices[-1]), True))


@dataclass(frozen=True, eq=False)
class _Joint:
    """Parts of two courses with a row between them."""

    low: _Course
    high: _Course
    low_range: tuple[int, int]
    """Places of the first and the last vertex in the course below."""
    high_range: tuple[int, int]
    """Places of the first and the last vertex in the course above."""
    low_exact: tuple[int, int]
    """The same for the vertices nearest to the ends of the other course."""
    high_exact: tuple[int, int]

    @property
    def whole(self) -> tuple[int, int]:
        """Numbers of stitches of the two courses."""
        return len(self.low.chain.edges), len(self.high.chain.edges)

    @property
    def is_whole(self) -> bool:
        """Whether the row lies between two whole courses."""
        return (self.low_range, self.high_range) == ((0, self.whole[0]), (0, self.whole[1]))

    @property
    def low_part(self) -> Chain:
        """The part of the course below."""
        return self.low.chain.part(*self.low_range)

    @property
    def high_part(self) -> Chain:
        """The part of the course above."""
        return self.high.chain.part(*self.high_range)

    def narrowed(self) -> _Joint:
        """Return the joint without the parts of the courses that do not lie above each other."""
        return _Joint(self.low, self.high, self.low_exact, self.high_exact, self.low_exact, self.high_exact)


def _end_to_end(courses: list[_Course], near: float) -> list[_Course]:
    """Join courses at one side of a band to one course where they follow each other from end to end.

    Beside a corner of the outline, part of a row is bound off at a hem while the rest of it goes on, or a row begins at
    a hem beside one that goes on. The row between them is one.

    Args:
        courses: the courses.
        near: largest distance between the end of a course and the start of the course that follows it [cm].
    """
    after = {}
    for number, course in enumerate(courses):
        for other, following in enumerate(courses):
            if number != other and course.ends_at(following, near):
                after[number] = other
    found = []
    for first in sorted(set(range(len(courses))) - set(after.values())):
        whole, last = courses[first], first
        while last in after:
            last = after[last]
            whole = whole.followed_by(courses[last])
        found.append(whole)
    return found


def _joints(low: list[_Course], high: list[_Course]) -> list[_Joint]:
    """Find the parts of the courses below and above a band that lie above each other."""
    exact: dict[tuple[int, int], tuple[tuple[int, int], tuple[int, int]]] = {}
    for i, lower in enumerate(low):
        for j, upper in enumerate(high):
            on_low, on_high = _facing_range(lower, upper), _facing_range(upper, lower)
            if on_low[1] > on_low[0] and on_high[1] > on_high[0]:
                exact[i, j] = on_low, on_high
    low_range, high_range = _widened(low, exact, 0), _widened(high, exact, 1)
    kept = sorted(low_range.keys() & high_range.keys())
    return [_Joint(low[i], high[j], low_range[i, j], high_range[i, j], *exact[i, j]) for i, j in kept]


def _facing_range(course: _Course, other: _Course) -> tuple[int, int]:
    """Places of the vertices of a course that are nearest to the ends of another one."""
    assert other.line.flat is not None
    first, last = other.line.flat[[0, -1]]
    return course.vertex_beside(first, first=True), course.vertex_beside(last, first=False)


def _widened(
    courses: list[_Course], exact: dict[tuple[int, int], tuple[tuple[int, int], tuple[int, int]]], own: int
) -> dict[tuple[int, int], tuple[int, int]]:
    """Widen each range to the ends of its course where these are near; leave out a range that another one covers.

    Args:
        courses: the courses below a band, or the courses above it.
        exact: for each pair of courses, its range in the course below and its range in the course above.
        own: 0 for the courses below, 1 for those above.
    """
    found = {}
    for number, course in enumerate(courses):
        pairs = sorted((pair for pair in exact if pair[own] == number), key=lambda pair: exact[pair][own])
        count, covered = len(course.chain.edges), 0
        for place, pair in enumerate(pairs):
            first, last = exact[pair][own]
            first = 0 if place == 0 and first <= GENTLE else max(first, covered)
            last = count if place == len(pairs) - 1 and count - last <= GENTLE else last
            if last > first:
                found[pair], covered = (first, last), last
    return found


def _hem_on(line: LevelLine, hems: Sequence[Hem]) -> Hem | None:
    """Return the hem whose line this is."""
    same = [hem for hem in hems if hem.points.shape == line.points.shape and np.allclose(hem.points, line.points)]
    return same[0] if same else None


def _counts_below_hems(levels: LevelLines, hems: Sequence[Hem]) -> dict[int, int]:
    """Number of stitches of the hem that lies one row above a line, by the number of the line."""
    counts = {}
    for band in levels.bands:
        hem = _hem_on(levels.lines[band.above[0]], hems) if len(band.above) == len(band.below) == 1 else None
        if hem is not None and band.above[0] in levels.borders:
            counts[band.below[0]] = sum(part.count for part in hem.parts)
    return counts


def _check_lines(levels: LevelLines, size: StitchSize) -> None:
    """Check that a panel has room for stitches, and that no row is a ring.

    Raises:
        TessellationError: the panel has no room, or a row is a ring.
    """
    longest = max((line.length for line in levels.lines), default=0.0)
    if longest < 2.0 * size.width:
        raise TessellationError(
            f"the longest row of {longest:.3g} cm is narrower than 2 stitches of {size.width:g} cm; choose a smaller "
            "stitch"
        )
    rings = [line for line in levels.lines if line.closed]
    if rings:
        place = rings[0].points.mean(axis=0).round(1).tolist()
        raise TessellationError(
            f"near {place} cm: a row would be a ring; correct the texture coordinates, or choose another direction"
        )
