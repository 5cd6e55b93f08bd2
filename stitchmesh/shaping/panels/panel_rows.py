# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stitches of panels: rows that end at the sides of the outline.

Where a row is a little shorter than the one below, it has decreases; where it is much shorter, the loops beside it are
left to be bound off. A row that is much longer casts on beside the one below. In the same way a row parts into two at a
neck, whose loops are bound off, and two rows become one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from stitchmesh.errors import TessellationError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.shaping.chains import Chain
from stitchmesh.shaping.level_lines import Band, LevelLine, LevelLines
from stitchmesh.shaping.rows import SLACK, StitchSize
from stitchmesh.shaping.wales import Wales, join_courses
from stitchmesh.tessellate.panel import StitchFaces, stitch_for

GENTLE = 2
"""Stitches by which a row may be shorter or longer at one end than the row below without binding off or casting on."""
SHORTEST_LINE = 0.75
"""Length of the shortest course, in stitch widths."""


@dataclass(frozen=True)
class HemPart:
    """Stitches along one piece of the outline at which rows begin or end."""

    piece: int
    """Number of the piece."""
    length: float
    """Its length [cm]."""
    count: int
    """Number of its stitches."""


@dataclass(frozen=True, eq=False)
class Hem:
    """A line at which rows begin or end."""

    points: FloatArray
    """Points along the line from left to right [cm], shape (n, 3)."""
    parts: tuple[HemPart, ...]
    """Its parts from left to right."""


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

    def nearest_vertex(self, point: FloatArray) -> int:
        """Return the place in the chain of the vertex nearest to a point beside the line."""
        place = self.line.nearest(point)[0]
        return int(np.abs(self.place - place).argmin())


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

    def knit(self, panel: int, levels: LevelLines, hems: Sequence[Hem]) -> None:
        """Knit a panel.

        Raises:
            TessellationError: the panel is narrower than two stitches or lower than a row, a row would be a ring, or
                two neighbouring rows differ too much.
        """
        _check_lines(panel, levels, self.size)
        courses: dict[int, _Course] = {}
        first = self.rows
        for band in levels.bands:
            self._make_courses(levels, band, hems, courses)
            low = [courses[line] for line in band.below if line in courses]
            high = [courses[line] for line in band.above if line in courses]
            for joint in _joints(low, high):
                self._add_row(panel, joint)
        if self.rows == first:
            raise TessellationError(f"panel {panel}: has no room for one row of stitches; choose a smaller stitch")

    def _make_courses(self, levels: LevelLines, band: Band, hems: Sequence[Hem], courses: dict[int, _Course]) -> None:
        """Make the courses of a band that have not been made yet."""
        for number in [*band.below, *band.above]:
            line = levels.lines[number]
            if number in courses or line.length < SHORTEST_LINE * self.size.width:
                continue
            hem = _hem_on(line, hems) if number in levels.borders else None
            if hem is not None:
                courses[number] = self._hem_course(line, hem)
            else:
                below = [courses[other] for other in band.below if other in courses and number in band.above]
                courses[number] = self._course(line, len(below[0].chain.edges) if len(below) == 1 else None)

    def _course(self, line: LevelLine, below: int | None) -> _Course:
        """Make a course of equally wide stitches, as many as below if their width permits it."""
        exact = line.length / self.size.width
        keeps = below is not None and abs(exact - below) <= SLACK
        count = below if below is not None and keeps else max(1, round(exact))
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

    def _add_row(self, panel: int, joint: _Joint) -> None:
        """Add the stitches of a row."""
        wales = self._wales(joint) or self._wales(joint := joint.narrowed())
        low, high = joint.low_part, joint.high_part
        if wales is None:
            raise TessellationError(
                f"panel {panel}: near {self.points[low.vertices[0]].round(1).tolist()} cm {len(high.edges)} stitches "
                f"stand above {len(low.edges)}; a stitch changes the number of loops by at most a factor of 3: choose "
                "a smaller stitch"
            )
        wale = self._new_edges(len(wales.below))
        for place in range(len(wale) - 1):
            self._add_face(low, high, wales, place, wale)
            self.face_panel.append(panel)
        self._note_row_ends(panel, joint, wale)
        self.rows += 1

    def _wales(self, joint: _Joint) -> Wales | None:
        below, above = (
            np.array([self.points[vertex] for vertex in chain.vertices])
            for chain in (joint.low_part, joint.high_part)
        )  # fmt: skip
        return join_courses(below, above, self.size.width, np.zeros(len(below)))

    def _add_face(self, low: Chain, high: Chain, wales: Wales, place: int, wale: tuple[int, ...]) -> None:
        """Add the face between two neighbouring wale edges."""
        b, t = slice(*wales.below[place : place + 2].tolist()), slice(*wales.above[place : place + 2].tolist())
        bottom, top = low.edges[b], high.edges[t]
        faces = self.faces
        faces.corners.append([*low.vertices[b.start : b.stop + 1], *high.vertices[t.start : t.stop + 1][::-1]])
        faces.edges.append([*bottom, wale[place + 1], *top[::-1], wale[place]])
        faces.n_bottom.append(len(bottom))
        faces.n_top.append(len(top))
        faces.stitch.append(stitch_for(len(bottom), len(top), 2 * place < len(wale)))
        faces.row.append(self.rows)

    def _note_row_ends(self, panel: int, joint: _Joint, wale: tuple[int, ...]) -> None:
        """Remember the ends of a row that lie on the outline."""
        low, high = joint.low_part, joint.high_part
        if joint.low_range[0] == joint.high_range[0] == 0:
            self.row_ends.append(RowEnd(panel, wale[0], (low.vertices[0], high.vertices[0]), False))
        whole = len(joint.low.chain.edges), len(joint.high.chain.edges)
        if (joint.low_range[1], joint.high_range[1]) == whole:
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
    def low_part(self) -> Chain:
        """The part of the course below."""
        return self.low.chain.part(*self.low_range)

    @property
    def high_part(self) -> Chain:
        """The part of the course above."""
        return self.high.chain.part(*self.high_range)

    def narrowed(self) -> _Joint:
        """Return the joint of only those parts that lie above each other."""
        return _Joint(self.low, self.high, self.low_exact, self.high_exact, self.low_exact, self.high_exact)


def _joints(low: list[_Course], high: list[_Course]) -> list[_Joint]:
    """Find the parts of the courses below and above a band that lie above each other."""
    exact: dict[tuple[int, int], tuple[tuple[int, int], tuple[int, int]]] = {}
    for i, lower in enumerate(low):
        for j, upper in enumerate(high):
            on_low, on_high = _facing_range(lower, upper), _facing_range(upper, lower)
            if on_low[1] > on_low[0] and on_high[1] > on_high[0]:
                exact[i, j] = on_low, on_high
    low_range, high_range = _widened(low, exact, 0), _widened(high, exact, 1)
    return [
        _Joint(low[i], high[j], low_range[i, j], high_range[i, j], *exact[i, j]) for i, j in sorted(exact)
    ]  # fmt: skip


def _facing_range(course: _Course, other: _Course) -> tuple[int, int]:
    """Places of the vertices of a course that are nearest to the ends of another one."""
    return course.nearest_vertex(other.line.points[0]), course.nearest_vertex(other.line.points[-1])


def _widened(
    courses: list[_Course], exact: dict[tuple[int, int], tuple[tuple[int, int], tuple[int, int]]], own: int
) -> dict[tuple[int, int], tuple[int, int]]:
    """Widen the ranges in each course to its ends where the ends are near.

    Args:
        courses: the courses below a band, or those above it.
        exact: ranges of each pair of courses in the course below and in the one above.
        own: 0 for the courses below, 1 for those above.
    """
    found = {}
    for number, course in enumerate(courses):
        pairs = sorted((pair for pair in exact if pair[own] == number), key=lambda pair: exact[pair][own])
        for place, pair in enumerate(pairs):
            first, last = exact[pair][own]
            count = len(course.chain.edges)
            first = 0 if place == 0 and first <= GENTLE else first
            last = count if place == len(pairs) - 1 and count - last <= GENTLE else last
            found[pair] = first, last
    return found


def _hem_on(line: LevelLine, hems: Sequence[Hem]) -> Hem | None:
    """Return the hem whose line this is."""
    same = [hem for hem in hems if hem.points.shape == line.points.shape and np.allclose(hem.points, line.points)]
    return same[0] if same else None


def _check_lines(panel: int, levels: LevelLines, size: StitchSize) -> None:
    """Check that a panel has room for stitches, and that no row is a ring.

    Raises:
        TessellationError: it has none, or a row is one.
    """
    longest = max((line.length for line in levels.lines), default=0.0)
    if longest < 2.0 * size.width:
        raise TessellationError(
            f"panel {panel}: its longest row of {longest:.3g} cm is narrower than 2 stitches of {size.width:g} cm; "
            "choose a smaller stitch"
        )
    rings = [line for line in levels.lines if line.closed]
    if rings:
        place = rings[0].points.mean(axis=0).round(1).tolist()
        raise TessellationError(
            f"panel {panel}: a row near {place} cm would be a ring; correct its texture coordinates, or choose another "
            "direction"
        )
