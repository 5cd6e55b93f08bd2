# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Level lines of a time on a surface of triangles, and the bands of surface between them.

A level line runs with the later part of the surface on its left, seen from outside: from left to right along a course
that is knitted upwards. Lines at the ends of rows are the borders themselves. A band is a connected part of the surface
between two neighbouring levels; it has lines below and lines above.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.connectivity import linked_groups
from stitchmesh.selection.borders import CLOSED_LENGTH
from stitchmesh.shaping.ends import Ends
from stitchmesh.shaping.triangle_surface import TriangleSurface

NARROWEST_TIP = 0.66
"""Smallest length of the last ring at a tip, over the length of the ring below it; in a shorter ring, yarns start too
close."""
BESIDE_LEVEL = 1e-6
"""Distance of a vertex from a level, in courses, below which the vertex is moved off the level."""


@dataclass(frozen=True, eq=False)
class LevelLine:
    """A level line."""

    level: int
    """Its time in courses."""
    points: FloatArray
    """Points along the line [cm], shape (n, 3); a closed line does not repeat its first point."""
    closed: bool
    """Whether the line is a ring."""
    flat: FloatArray | None = None
    """The same points in the flat pattern of a panel [cm], shape (n, 2); None on other surfaces."""

    @property
    def along(self) -> FloatArray:
        """Length from the first point to each point [cm], and for a ring back to the first, shape (n,) or (n + 1,)."""
        points = np.concatenate([self.points, self.points[:1]]) if self.closed else self.points
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])

    @property
    def length(self) -> float:
        """Length of the line [cm]."""
        return float(self.along[-1])

    def at(self, place: FloatArray) -> FloatArray:
        """Return the points at some lengths along the line [cm], shape (n, 3); a ring continues beyond its end."""
        along = self.along
        points = np.concatenate([self.points, self.points[:1]]) if self.closed else self.points
        place = np.mod(place, along[-1]) if self.closed else np.clip(place, 0.0, along[-1])
        return np.stack([np.interp(place, along, points[:, k]) for k in range(3)], axis=1)

    def flat_at(self, place: FloatArray) -> FloatArray:
        """Return the points in the flat pattern at some lengths along an open line [cm], shape (n, 2)."""
        assert self.flat is not None
        return np.stack([np.interp(place, self.along, self.flat[:, k]) for k in range(2)], axis=1)

    def nearest(self, point: FloatArray) -> tuple[float, float]:
        """Return where the line is nearest to a point, as a length along the line, and the distance there [cm]."""
        start = self.points
        end = np.roll(start, -1, axis=0) if self.closed else start[1:]
        start = start[: len(end)]
        step = end - start
        square = np.maximum(np.einsum("ni,ni->n", step, step), np.finfo(np.float64).tiny)
        share = np.clip(np.einsum("ni,ni->n", point - start, step) / square, 0.0, 1.0)
        distance = np.linalg.norm(start + share[:, None] * step - point, axis=1)
        best = int(distance.argmin())
        return float(self.along[best] + share[best] * np.sqrt(square[best])), float(distance[best])


@dataclass
class Band:
    """A connected part of a surface between two levels."""

    below: list[int] = field(default_factory=list)
    """Numbers of the lines below it."""
    above: list[int] = field(default_factory=list)
    """Numbers of the lines above it."""


@dataclass(frozen=True, eq=False)
class LevelLines:
    """All lines of a time, and the bands between them."""

    lines: tuple[LevelLine, ...]
    """The lines, in ascending order of their levels."""
    bands: tuple[Band, ...]
    """The bands, in ascending order of their levels."""
    borders: frozenset[int]
    """Numbers of the lines that are borders of the surface."""
    at_holes: frozenset[int] = frozenset()
    """Numbers of the lines before or after which a border of the surface was left out."""

    @property
    def tips(self) -> int:
        """Number of rings beyond which nothing is knitted, although the surface has no border there."""
        ends = {line for band in self.bands if not (band.below and band.above) for line in band.below + band.above}
        return sum(self.lines[line].closed for line in ends - self.borders - self.at_holes)


def level_lines(
    surface: TriangleSurface, time: FloatArray, ends: Ends, flat: FloatArray | None = None
) -> LevelLines:
    """Find the lines of all whole numbers, and the bands between them.

    Args:
        surface: the surface.
        time: time of each vertex in courses, shape (V,).
        ends: the ends, which are lines too; their times are whole numbers.
        flat: position of each vertex in the flat pattern of a panel [cm], shape (V, 2).
    """
    value, borders = _off_the_levels(surface, time, ends, flat)
    segments = _segments(surface, value)
    lines, line_of_node = _chains(segments, surface, value, flat)
    first = len(lines)
    lines += [line for line, _, _ in borders]
    sides = _sides_of_bands(surface, value, segments, line_of_node, len(lines))
    for number, (_, vertices, starts) in enumerate(borders, start=first):
        sides.join_border(number, vertices, starts)
    return _sorted(lines, sides, first)


def _off_the_levels(
    surface: TriangleSurface, time: FloatArray, ends: Ends, flat: FloatArray | None
) -> tuple[FloatArray, list[tuple[LevelLine, IntArray, bool]]]:
    """Move vertices off whole numbers, and make the lines of the ends.

    Returns:
        The time of each vertex, shape (V,), and for each end its line, its vertices, and whether rows begin there.
    """
    value = time.copy()
    level = np.rint(value)
    on_level = np.abs(value - level) < BESIDE_LEVEL
    value[on_level] = level[on_level] + BESIDE_LEVEL
    found = []
    for end in (*ends.roots, *ends.others):
        ring, level_of_end = np.unique(end.vertices), round(time[end.vertices[0]])
        starts = bool(time[_beside(surface, ring)].mean() > time[ring[0]])
        value[ring] = level_of_end + (BESIDE_LEVEL if starts else -BESIDE_LEVEL)
        if len(ring) > 1:
            path = end.vertices if starts else end.vertices[::-1]
            closed = _is_ring(surface, end.vertices)
            own = None if flat is None else flat[path]
            found.append((LevelLine(level_of_end, surface.vertices[path], closed, own), ring, starts))
    return value, found


def _beside(surface: TriangleSurface, ring: IntArray) -> IntArray:
    """Vertices across the edges of an end, or around a tip; vertices beyond the corners of a hole do not count."""
    own = np.isin(surface.triangles, ring)
    across = own.sum(axis=1) == min(len(ring), 2)
    return surface.triangles[across][~own[across]]


def _is_ring(surface: TriangleSurface, vertices: IntArray) -> bool:
    """Whether the vertices of an end are a whole border."""
    return any(len(border) == len(vertices) and np.isin(vertices, border).all() for border in surface.borders)


@dataclass(frozen=True, eq=False)
class _Segments:
    """Pieces of lines in single triangles; a node is a place where a line crosses an edge."""

    triangle: IntArray
    level: IntArray
    entered: IntArray
    """Node at which the line enters the triangle, shape (S,)."""
    left: IntArray
    """Node at which the line leaves the triangle, shape (S,)."""
    node_edge: IntArray
    node_level: IntArray


def _segments(surface: TriangleSurface, value: FloatArray) -> _Segments:
    """Find the piece of each line in each triangle."""
    corner = value[surface.triangles]
    first = np.floor(corner.min(axis=1)).astype(np.int64) + 1
    count = np.maximum(np.floor(corner.max(axis=1)).astype(np.int64) - first + 1, 0)
    triangle = np.repeat(np.arange(len(count)), count)
    level = first[triangle] + np.arange(len(triangle)) - np.repeat(np.cumsum(count) - count, count)
    above = corner[triangle] > level[:, None]
    after = np.roll(above, -1, axis=1)
    rising, falling = (~above & after).argmax(axis=1), (above & ~after).argmax(axis=1)
    edge = _side_edges(surface)
    lowest = int(level.min(initial=0))
    span = int(level.max(initial=0)) - lowest + 1
    keys = np.concatenate([edge[triangle, side] * span + level - lowest for side in (falling, rising)])
    known, node = np.unique(keys, return_inverse=True)
    half = len(triangle)
    return _Segments(triangle, level, node[:half], node[half:], known // span, known % span + lowest)


def _side_edges(surface: TriangleSurface) -> IntArray:
    """Edge of each side of each triangle, shape (T, 3)."""
    tail, head = surface.triangles, np.roll(surface.triangles, -1, axis=1)
    key = np.minimum(tail, head) * len(surface.vertices) + np.maximum(tail, head)
    known = surface.edges[:, 0] * len(surface.vertices) + surface.edges[:, 1]
    return np.searchsorted(known, key)


def _chains(
    segments: _Segments, surface: TriangleSurface, value: FloatArray, flat: FloatArray | None = None
) -> tuple[list[LevelLine], IntArray]:
    """Join segments to lines; return the lines, and the line of each node."""
    count = len(segments.node_edge)
    following = np.full(count, -1)
    following[segments.entered] = segments.left
    has_previous = np.zeros(count, dtype=bool)
    has_previous[segments.left] = True
    ends = surface.edges[segments.node_edge]
    low, high = value[ends[:, 0]], value[ends[:, 1]]
    share = ((segments.node_level - low) / (high - low))[:, None]
    points, own = (
        None if place is None else place[ends[:, 0]] * (1.0 - share) + place[ends[:, 1]] * share
        for place in (surface.vertices, flat)
    )
    assert points is not None
    lines: list[LevelLine] = []
    line_of_node, after = np.full(count, -1), following.tolist()
    for start in [*np.flatnonzero(~has_previous).tolist(), *range(count)]:
        if line_of_node[start] >= 0:
            continue
        chain, node = [start], after[start]
        while node not in (-1, start):
            chain.append(node)
            node = after[node]
        line_of_node[chain] = len(lines)
        level = int(segments.node_level[start])
        lines.append(LevelLine(level, points[chain], node == start, None if own is None else own[chain]))
    return lines, line_of_node


def lines_between(surface: TriangleSurface, high: NDArray[np.bool_]) -> tuple[IntArray, IntArray]:
    """Return the edges between high vertices of a surface and others, shape (n,), and the line across each, (n,)."""
    value = np.where(high, 0.5, -0.5)
    segments = _segments(surface, value)
    return segments.node_edge, _chains(segments, surface, value)[1]


@dataclass
class _Sides:
    """A graph whose connected parts are the bands; its nodes are vertices, parts of triangles and sides of lines."""

    lines: int
    vertices: int
    pairs: list[tuple[IntArray, IntArray]]
    nodes: int

    def join_border(self, line: int, vertices: IntArray, starts: bool) -> None:
        """Join the surface beside an end: above its line where rows begin, below it where they end."""
        side = 2 * line + (0 if starts else 1)
        self.pairs.append((np.full(len(vertices), side), 2 * self.lines + vertices))

    def components(self) -> IntArray:
        """Number of the band of the upper (even) and the lower (odd) side of each line, shape (2 lines,)."""
        one, other = (np.concatenate([pair[k] for pair in self.pairs]) for k in range(2))
        return linked_groups(self.nodes, one, other)[: 2 * self.lines]


def _sides_of_bands(
    surface: TriangleSurface, value: FloatArray, segments: _Segments, line_of_node: IntArray, lines: int
) -> _Sides:
    """Join the parts into which the lines divide the triangles to what they touch."""
    floor = np.floor(value[surface.triangles]).astype(np.int64)
    low, high = floor.min(axis=1), floor.max(axis=1)
    start = np.concatenate([[0], np.cumsum(high - low + 1)])
    base = 2 * lines + len(value)
    part = base + start[:-1][:, None] + floor - low[:, None]
    line = line_of_node[segments.entered]
    upper = base + start[segments.triangle] + segments.level - low[segments.triangle]
    pairs = [(part.ravel(), 2 * lines + surface.triangles.ravel()), (upper, 2 * line), (upper - 1, 2 * line + 1)]
    return _Sides(lines, len(value), pairs, base + int(start[-1]))


def _sorted(lines: list[LevelLine], sides: _Sides, first_border: int) -> LevelLines:
    """Sort lines by level, then by place, and gather the lines of each band.

    Args:
        lines: the lines; lines of borders come last.
        sides: the graph that says which sides of lines lie in one band.
        first_border: number of the first line of a border.
    """
    keys = [(line.level, *np.round(line.points.mean(axis=0), 6)) for line in lines]
    order = sorted(range(len(lines)), key=keys.__getitem__)
    part = sides.components()
    bands: dict[int, Band] = {}
    for number, line in enumerate(order):
        bands.setdefault(int(part[2 * line]), Band()).below.append(number)
        bands.setdefault(int(part[2 * line + 1]), Band()).above.append(number)
    found = tuple(lines[line] for line in order)

    def level(band: Band) -> tuple[float, int]:
        lowest = found[band.below[0]].level if band.below else found[band.above[0]].level - 1
        return lowest, min([*band.below, *band.above])

    used = [band for band in bands.values() if band.below or band.above]
    borders = frozenset(number for number, line in enumerate(order) if line >= first_border)
    return LevelLines(found, tuple(sorted(used, key=level)), borders)


def _is_too_short(levels: LevelLines, line: int, beside: Band, shortest: float) -> bool:
    """Whether a ring at a tip is too short; ``beside`` is the band at its other side."""
    length = levels.lines[line].length
    if line in beside.above and len(beside.below) == 1:
        shortest = max(shortest, NARROWEST_TIP * levels.lines[beside.below[0]].length)
    return length < shortest


def without_small_tips(levels: LevelLines, shortest: float) -> LevelLines:
    """Leave out rings at tips that are too short; the rows then begin one course later, or end one course earlier.

    A border that no finger goes through also counts as such a ring: a yarn is drawn through the loops there.

    Args:
        levels: the lines and the bands.
        shortest: length of the shortest ring [cm]. The last ring must also have ``NARROWEST_TIP`` of the length of the
            ring below it, because both have equally many stitches.
    """
    bands = [Band(list(band.below), list(band.above)) for band in levels.bands]
    at_holes: set[int] = set()
    changed = True
    while changed:
        changed = False
        for band in bands:
            inner, outer = (band.below, band.above) if not band.above else (band.above, band.below)
            if outer or len(inner) != 1:
                continue
            line = inner[0]
            other = next((b for b in bands if b is not band and line in b.above + b.below), None)
            kept = line in levels.borders and levels.lines[line].length >= CLOSED_LENGTH
            if other is None or kept or not _is_too_short(levels, line, other, shortest):
                continue
            for side in (other.below, other.above):
                if line in side:
                    side.remove(line)
            if line in levels.borders or line in at_holes:
                at_holes.update(other.above if not other.below else other.below if not other.above else ())
            bands = [b for b in bands if b is not band]
            changed = True
            break
    return LevelLines(levels.lines, tuple(bands), levels.borders, frozenset(at_holes))
