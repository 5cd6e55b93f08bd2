# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A flat panel: its outline, its place in space, and its triangles.

*Triangles.* Each side of the outline is divided evenly, so that two sides with the same number of edges can be sewn
together. The inside is filled with points of a grid of equilateral triangles that keep a distance from the border. The
panel consists of the Delaunay triangles of all points that lie inside the outline. A few times, the grid points move to
the mean of their neighbours and the triangles are found again. Far from the border, where the grid stays as it is,
triangles are equilateral: the bending of a cloth then has no preferred direction, unlike on a grid of squares with
diagonals.

Libraries that divide polygons into triangles of a wanted size (Triangle, Gmsh) have no free licence that suits this
project; those with one (earcut) make triangles without points inside. SciPy's Delaunay triangulation and the recovery
of border edges need no new package. The same outline gives the same triangles.

Border edges that a triangulation lacks are recovered by flips of the edges that cross them (Sloan 1993).

A Delaunay triangulation of points on a border and inside it nearly always has all edges of the border. An edge can be
missing where the outline is narrower than its edges are long. If an edge crosses the wanted edge, and its two triangles
form a convex quadrilateral, it is replaced by the other diagonal. An edge whose quadrilateral is not convex waits until
its neighbours are flipped.

*Place.* At the start a panel lies in a plane, or is wrapped round a cylinder.

A point (x, y) of a panel in a plane lies at

    origin + x X + y Y

with unit axes X and Y. A cylinder of radius R has an axis in direction Y and touches that plane from behind, along the
line x = 0. On this cylinder the point lies at

    origin + R sin(x / R) X + y Y + R (cos(x / R) - 1) X x Y

Both maps keep lengths, and the front of the panel is the side of X x Y, which is the outside of the cylinder.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import ParameterError, first_few
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.outline import checked_outline, distance_to_sides, edge_pairs, inside

Triple = tuple[float, float, float]

@dataclass(frozen=True, kw_only=True)
class PanelPosition:
    """Where a panel lies in space.

    Raises:
        ParameterError: a number is not finite, an axis is zero, the axes are not at right angles, or the radius is not
            positive.
    """

    origin: Triple = (0.0, 0.0, 0.0)
    """Where the point (0, 0) of the panel lies [cm]."""
    x_axis: Triple = (1.0, 0.0, 0.0)
    """Direction of x; its length does not count."""
    y_axis: Triple = (0.0, 1.0, 0.0)
    """Direction of y; its length does not count."""
    radius: float | None = None
    """Radius of the cylinder round which the panel is wrapped [cm]; None for a panel in a plane."""

    def __post_init__(self) -> None:
        for name in ("origin", "x_axis", "y_axis"):
            value = getattr(self, name)
            if len(value) != 3 or not all(math.isfinite(number) for number in value):
                raise ParameterError(f"position: {name}: got {value}; expected three finite numbers")
        for name in ("x_axis", "y_axis"):
            if not any(getattr(self, name)):
                raise ParameterError(f"position: {name}: got a zero vector; expected a direction")
        cosine = float(_unit(self.x_axis) @ _unit(self.y_axis))
        if abs(cosine) > 1e-6:  # a user writes the axes with a few digits
            angle = math.degrees(math.acos(max(-1.0, min(1.0, cosine))))
            raise ParameterError(f"position: x_axis and y_axis: got an angle of {angle:.4g} degrees; expected 90")
        if self.radius is not None and not (math.isfinite(self.radius) and self.radius > 0.0):
            raise ParameterError(f"position: radius: got {self.radius}; expected a positive number of cm")

    def place(self, points: ArrayLike) -> FloatArray:
        """Return where points of the panel lie in space [cm], shape (n, 2) to (n, 3)."""
        x, y = np.asarray(points, dtype=np.float64).T
        along, up = _unit(self.x_axis), _unit(self.y_axis)
        back = np.zeros_like(x)
        if self.radius is not None:
            angle = x / self.radius
            x, back = self.radius * np.sin(angle), self.radius * (np.cos(angle) - 1.0)
        placed: FloatArray = (
            np.array(self.origin) + x[:, None] * along + y[:, None] * up + back[:, None] * np.cross(along, up)
        )
        return placed


def _unit(axis: Triple) -> FloatArray:
    direction = np.array(axis, dtype=np.float64)
    direction = direction / np.abs(direction).max()
    return direction / np.linalg.norm(direction)


Edge = tuple[int, int]
SMALLEST_EDGE = 1e-4
"""Smallest edge length that can be asked for [cm]."""
MOST_POINTS = 4_000_000
"""Largest number of points of the grid of a panel."""


def with_edges(points: FloatArray, triangles: IntArray, edges: IntArray) -> IntArray:
    """Return triangles of the same points that have all wanted edges, shape (T, 3), anticlockwise.

    Args:
        points: points in the plane, shape (n, 2).
        triangles: a triangulation of the points, anticlockwise, shape (T, 3).
        edges: edges that must be there, which do not cross one another, shape (m, 2).

    Raises:
        ParameterError: an edge cannot be recovered, because a point lies on it.
    """
    missing = _missing(triangles, edges, len(points))
    if not len(missing):
        return triangles
    flips = _Flips(points, triangles)
    for one, other in missing.tolist():
        flips.recover(one, other)
    return np.array(flips.triangles)


def _missing(triangles: IntArray, edges: IntArray, count: int) -> IntArray:
    """Wanted edges that are not sides of triangles, shape (k, 2)."""
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    there = np.isin(_key(edges, count), _key(sides, count))
    return edges[~there]


def _key(edges: IntArray, count: int) -> IntArray:
    return edges.min(axis=1) * count + edges.max(axis=1)


class _Flips:
    """A triangulation whose edges can be flipped."""

    def __init__(self, points: FloatArray, triangles: IntArray) -> None:
        self.points = points.tolist()
        self.triangles: list[list[int]] = triangles.tolist()
        self.of_side: dict[Edge, int] = {}
        for number in range(len(self.triangles)):
            self._enter(number)

    def recover(self, one: int, other: int) -> None:
        """Flip edges until the edge from ``one`` to ``other`` is there."""
        waiting = deque(self._crossing(one, other))
        patience = 10 * len(waiting) ** 2 + 10  # each round of the queue removes at least one crossing
        while waiting and patience:
            patience -= 1
            edge = waiting.popleft()
            made = self._flip(*edge)
            if made is None:
                waiting.append(edge)
            elif self._cross(one, other, *made):
                waiting.append(made)
        if (one, other) not in self.of_side and (other, one) not in self.of_side:
            raise ParameterError(
                f"panel: border edge {one}-{other}: cannot become a side of triangles, because the outline is too "
                "narrow there; take a smaller edge length"
            )

    def _crossing(self, one: int, other: int) -> list[Edge]:
        """Edges that cross the segment between two points, in the order of their numbers."""
        return sorted(edge for edge in self.of_side if edge[0] < edge[1] and self._cross(one, other, *edge))

    def _cross(self, a: int, b: int, c: int, d: int) -> bool:
        if len({a, b, c, d}) < 4:
            return False
        return self._turn(a, b, c) * self._turn(a, b, d) < 0.0 and self._turn(c, d, a) * self._turn(c, d, b) < 0.0

    def _turn(self, a: int, b: int, c: int) -> float:
        (ax, ay), (bx, by), (cx, cy) = self.points[a], self.points[b], self.points[c]
        return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)

    def _flip(self, a: int, b: int) -> Edge | None:
        """Replace an edge by the other diagonal of its quadrilateral and return that; None if it is not convex."""
        left, right = self.of_side[a, b], self.of_side[b, a]
        c, d = self._third(left, a, b), self._third(right, a, b)
        if self._turn(d, b, c) <= 0.0 or self._turn(c, a, d) <= 0.0:
            return None
        for number in (left, right):
            for side in _sides(self.triangles[number]):
                del self.of_side[side]
        self.triangles[left], self.triangles[right] = [d, b, c], [c, a, d]
        self._enter(left)
        self._enter(right)
        return min(c, d), max(c, d)

    def _third(self, triangle: int, a: int, b: int) -> int:
        return next(vertex for vertex in self.triangles[triangle] if vertex not in (a, b))

    def _enter(self, number: int) -> None:
        for side in _sides(self.triangles[number]):
            self.of_side[side] = number


def _sides(triangle: list[int]) -> list[Edge]:
    a, b, c = triangle
    return [(a, b), (b, c), (c, a)]


@dataclass(frozen=True, kw_only=True)
class Panel:
    """A flat panel: its outline and its place in space.

    Raises:
        ParameterError: the outline is not simple (``checked_outline``), or ``side_edges`` does not have one positive
            number for each side.
    """

    name: str
    """Name of the panel."""
    outline: tuple[tuple[float, float], ...]
    """Corners [cm], anticlockwise, shape (n, 2); x along wefts or courses, y along warps or wales. Side k runs from
    corner k to the next one."""
    position: PanelPosition = field(default_factory=PanelPosition)
    """Where the panel lies in space."""
    side_edges: tuple[int, ...] = ()
    """Number of triangle edges on each side; empty if the edge length and the seams decide."""

    def __post_init__(self) -> None:
        corners = checked_outline(self.name, self.outline)
        object.__setattr__(self, "outline", tuple((x, y) for x, y in corners.tolist()))
        if self.side_edges and len(self.side_edges) != len(corners):
            raise ParameterError(
                f"panel {self.name!r}: side_edges: got {len(self.side_edges)} numbers; expected one for each of the "
                f"{len(corners)} sides"
            )
        bad = [number for number in self.side_edges if number < 1]
        if bad:
            raise ParameterError(
                f"panel {self.name!r}: side_edges: got {first_few(bad)}; expected numbers of at least 1"
            )

    @cached_property
    def corners(self) -> FloatArray:
        """Corners of the outline [cm], shape (n, 2)."""
        return np.array(self.outline, dtype=np.float64)

    @cached_property
    def side_lengths(self) -> FloatArray:
        """Length of each side [cm], shape (n,)."""
        return np.linalg.norm(np.roll(self.corners, -1, axis=0) - self.corners, axis=1)

    def even_side_edges(self, edge_length: float) -> IntArray:
        """Return the number of edges of each side that makes them closest to the wanted length, at least 1, shape (n,).

        Raises:
            ParameterError: the length is too small for a triangulation of at most ``MOST_POINTS`` points.
        """
        counts = np.maximum(np.round(self.side_lengths / checked_edge_length(edge_length)), 1)
        if counts.max() > MOST_POINTS:
            raise ParameterError(
                f"panel {self.name!r}: side {int(counts.argmax())}: needs {counts.max():.3g} edges of {edge_length:g} "
                f"cm; expected at most {MOST_POINTS:,}: choose a larger edge length"
            )
        return counts.astype(np.int64)


@dataclass(frozen=True, eq=False)
class PanelTriangles:
    """The triangles of a panel."""

    points: FloatArray
    """Points [cm], shape (P, 2); the points of the border come first, anticlockwise from corner 0."""
    triangles: IntArray
    """Points of each triangle, anticlockwise, shape (T, 3)."""
    corner_point: IntArray
    """Point of each corner of the outline, and the number of points of the border at the end, shape (n + 1,)."""

    def border_from(self, start: int, end: int) -> IntArray:
        """Return the points of the border anticlockwise between two corners; all points if both are the same corner."""
        count = int(self.corner_point[-1])
        first, last = int(self.corner_point[start]), int(self.corner_point[end])
        return np.arange(first, last + 1 if last > first else last + count + 1) % count


def checked_edge_length(edge_length: float) -> float:
    """Return a wanted edge length [cm].

    Raises:
        ParameterError: the length is not a number of at least ``SMALLEST_EDGE``.
    """
    if not (math.isfinite(edge_length) and edge_length >= SMALLEST_EDGE):
        raise ParameterError(f"edge length: got {edge_length}; expected a number of at least {SMALLEST_EDGE:g} cm")
    return edge_length


def triangulate(panel: Panel, edge_length: float, side_edges: Sequence[int] | IntArray | None = None) -> PanelTriangles:
    """Divide a panel into triangles.

    Args:
        panel: the panel.
        edge_length: wanted length of the edges inside [cm].
        side_edges: number of edges on each side, shape (n,); by default the numbers of the panel, or the numbers that
            fit the edge length best.

    Raises:
        ParameterError: the edge length is not positive or far too small, or the outline is narrower than its edges are
            long.
    """
    if side_edges is None:
        side_edges = panel.side_edges or panel.even_side_edges(edge_length)
    counts = np.asarray(side_edges, dtype=np.int64)
    border = _border_points(panel.corners, counts)
    grid = _grid_points(panel, border, checked_edge_length(edge_length))
    points, triangles = _smoothed(np.concatenate([border, grid]), len(border))
    triangles = with_edges(points, triangles, edge_pairs(np.arange(len(border))))
    triangles = _within(points, triangles, border)
    _check_all_used(panel, points, triangles)
    return PanelTriangles(points, triangles, np.concatenate([[0], np.cumsum(counts)]))


def _border_points(corners: FloatArray, counts: IntArray) -> FloatArray:
    """Points that divide each side evenly, from corner 0 anticlockwise, shape (B, 2)."""
    side = np.repeat(np.arange(len(corners)), counts)
    part = (np.arange(len(side)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[side]
    start, end = corners[side], np.roll(corners, -1, axis=0)[side]
    return start + part[:, None] * (end - start)


def _grid_points(panel: Panel, border: FloatArray, edge_length: float) -> FloatArray:
    """Points of a grid of equilateral triangles that lie inside and clear of the border, shape (n, 2)."""
    low, size = border.min(axis=0), np.ptp(border, axis=0)
    height = edge_length * math.sqrt(3.0) / 2.0
    columns, rows = int(size[0] / edge_length) + 2, int(size[1] / height) + 2
    if columns * rows > MOST_POINTS:
        raise ParameterError(
            f"panel {panel.name!r}: got an edge length of {edge_length:g} cm, which needs {columns * rows:,} points; "
            f"expected at most {MOST_POINTS:,}; take longer edges"
        )
    row, column = np.divmod(np.arange(rows * columns), columns)
    margin = (size - [(columns - 1) * edge_length, (rows - 1) * height]) / 2.0
    points = low + margin + np.stack([(column + row % 2 / 2 - 0.25) * edge_length, row * height], axis=1)
    start, end = border, np.roll(border, -1, axis=0)
    points = points[inside(points, start, end)]
    # a clearance of somewhat less than the height of a triangle
    return points[distance_to_sides(points, start, end) > 0.65 * edge_length]


def _smoothed(points: FloatArray, border_count: int) -> tuple[FloatArray, IntArray]:
    """Move the points inside the border to the mean of their neighbours; return points and Delaunay triangles."""
    border = points[:border_count]
    triangles = _delaunay(points)
    for _ in range(8 if len(points) > border_count else 0):  # further rounds hardly change the smallest angle
        kept = _within(points, triangles, border)
        sides = np.unique(np.sort(np.concatenate([kept[:, [0, 1]], kept[:, [1, 2]], kept[:, [2, 0]]]), axis=1), axis=0)
        ends = np.concatenate([sides, sides[:, ::-1]])
        count = np.bincount(ends[:, 0], minlength=len(points))
        sums = [np.bincount(ends[:, 0], weights=points[ends[:, 1], axis], minlength=len(points)) for axis in (0, 1)]
        mean = np.stack(sums, axis=1) / np.maximum(count, 1)[:, None]
        points = np.concatenate([border, np.where(count[:, None] > 0, mean, points)[border_count:]])
        triangles = _delaunay(points)
    return points, triangles


def _delaunay(points: FloatArray) -> IntArray:
    """Delaunay triangles, anticlockwise, shape (T, 3)."""
    from scipy.spatial import Delaunay

    triangles = Delaunay(points).simplices.astype(np.int64)
    one, other = points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]]
    turned = one[:, 0] * other[:, 1] < one[:, 1] * other[:, 0]
    triangles[turned] = triangles[turned][:, [0, 2, 1]]
    return triangles


def _within(points: FloatArray, triangles: IntArray, border: FloatArray) -> IntArray:
    """Triangles whose centre lies inside the border.

    The points of one side of the outline lie on a line only up to rounding. Triangles without an area can therefore lie
    behind a side that is part of the convex hull; they are left out.
    """
    corners = points[triangles]
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    doubled = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    kept = inside(corners.mean(axis=1), border, np.roll(border, -1, axis=0))
    return triangles[kept & (doubled > 1e-10 * (one**2 + other**2).sum(axis=1))]  # above rounding


def _check_all_used(panel: Panel, points: FloatArray, triangles: IntArray) -> None:
    used = np.zeros(len(points), dtype=np.bool_)
    used[triangles] = True
    bad = np.flatnonzero(~used)
    if len(bad):
        place = points[bad[0]].round(4).tolist()
        raise ParameterError(
            f"panel {panel.name!r}: the outline at {place} is too narrow for edges of this length; take a smaller "
            "edge length"
        )
