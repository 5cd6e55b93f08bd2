# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Marks of a user: where knitting begins and ends, lines along which rows run, and places without shaping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.lattice import LARGEST_LENGTH
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.shaping.ends import End, Ends, automatic_ends
from stitchmesh.shaping.triangle_surface import TriangleSurface

KINDS = ("border", "stroke", "point")
"""Kinds of marks."""
ROLES = ("begin", "end", "row", "side", "plain")
"""Roles of marks."""
UNTIMED = ("side", "plain")
"""Roles of marks at which many rows pass, so that they have no time."""


@dataclass(frozen=True)
class TimeMark:
    """A mark on a surface.

    Raises:
        ParameterError: the kind or the role is unknown, or the points are no finite points in space.
    """

    kind: Literal["border", "stroke", "point"]
    """``border``: the whole border nearest to the first point; ``stroke``: a line through all points; ``point``: a tip
    at the first point."""
    points: Sequence[Sequence[float]]
    """Points on the surface [cm], shape (n, 3)."""
    role: Literal["begin", "end", "row", "side", "plain"] = "row"
    """``begin``: knitting begins here; ``end``: it ends here; ``row``: a row runs along it; ``side``: rows end at this
    border; ``plain``: increases and decreases are kept away from it."""
    time: float | None = None
    """Distance along the fabric from where knitting begins [cm]; None if it follows from the size of the surface."""
    radius: float | None = None
    """Distance from a ``plain`` mark up to which the fabric is plain [cm]; None for three stitch widths."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ParameterError(f"got the kind '{self.kind}'; expected one of {', '.join(KINDS)}")
        if self.role not in ROLES:
            raise ParameterError(f"got the role '{self.role}'; expected one of {', '.join(ROLES)}")
        if self.role == "side" and self.kind != "border":
            raise ParameterError(f"got the role 'side' for a {self.kind}; only a border is a side")
        points = np.asarray(self.points, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3 or not len(points) or not (np.abs(points) <= LARGEST_LENGTH).all():
            raise ParameterError(f"got points of shape {points.shape}; expected finite points, shape (n, 3) [cm]")
        if self.time is not None and not abs(self.time) <= LARGEST_LENGTH:
            raise ParameterError(f"got the time {self.time}; expected a finite number of centimetres")
        if self.time is not None and self.role in UNTIMED:
            raise ParameterError(f"got a time for the role '{self.role}'; only begin, end and row have one")
        if self.radius is not None and self.role != "plain":
            raise ParameterError(f"got a radius for the role '{self.role}'; only the role plain has one")
        if self.radius is not None and not 0.0 < self.radius <= LARGEST_LENGTH:
            raise ParameterError(f"got the radius {self.radius}; expected a positive number of centimetres")
        object.__setattr__(self, "points", tuple(map(tuple, points.tolist())))  # so that equal marks compare equal

    def turned(self, turn: FloatArray) -> TimeMark:
        """Return the mark on a surface that is turned by a rotation of points as columns, shape (3, 3)."""
        return replace(self, points=tuple(map(tuple, (np.asarray(self.points) @ turn.T).tolist())))


def marked_ends(surface: TriangleSurface, marks: Sequence[TimeMark], up: FloatArray) -> Ends:
    """Return the ends that marks name; what they leave open is chosen automatically.

    Borders without a mark keep their automatic roles, with one exception: they get the opposite roles if all marked
    borders have the opposite of their automatic roles, or if knitting would otherwise only begin or only end. The
    garment is then knitted the other way round. Tips without a mark follow from the flow.

    Args:
        surface: a connected surface.
        marks: the marks on it; those whose role is ``plain`` make no end.
        up: unit vector, shape (3,).

    Raises:
        ParameterError: a mark is off the surface, two marks share a place, their times contradict each other, or all
            borders at which knitting could begin or end are sides.
    """
    found = [(mark, End(vertices_of(surface, mark), mark.time)) for mark in marks if mark.role != "plain"]
    automatic = automatic_ends(surface, up)
    if not found:
        return automatic
    _check_apart(found)
    _check_times(surface, found)
    begins, finishes = (tuple(end for mark, end in found if mark.role == role) for role in ("begin", "end"))
    lines = tuple(end for mark, end in found if mark.role == "row")
    is_marked = bool(begins or finishes)
    used = np.concatenate([end.vertices for _, end in found])
    lines, grafts = (*lines, *_without(automatic.lines, used)), _without(automatic.grafts, used)
    if surface.borders or not is_marked:
        first, last = (_without(ends, used) for ends in (automatic.begin_ends, automatic.finish_ends))
        if is_marked and _is_turned(automatic, begins, finishes, (first, last)):
            first, last = last, first
        begins, finishes = (*begins, *first), (*finishes, *last)
    if not begins and not finishes:
        raise ParameterError(
            "marks: leave no border at which knitting begins or ends; mark one as begin or end, or a point as a tip"
        )
    # The flow to a single root has saddles only where limbs meet.
    if not finishes or 0 < len(begins) < len(finishes):
        return Ends(begins, finishes, lines, grafts, begins=True)
    return Ends(finishes, begins, lines, grafts, begins=False)


def _without(ends: Sequence[End], used: IntArray) -> tuple[End, ...]:
    """The ends that have none of some vertices."""
    return tuple(end for end in ends if not np.isin(end.vertices, used).any())


def _is_turned(
    automatic: Ends, begins: tuple[End, ...], finishes: tuple[End, ...], free: tuple[tuple[End, ...], tuple[End, ...]]
) -> bool:
    """Whether marks turn the direction of knitting (``marked_ends``); ``free`` are the automatic ends without marks."""
    pairs = [(automatic.begin_ends, begins), (automatic.finish_ends, finishes)]
    kept = any(_meet(own, marked) for own, marked in pairs)
    contradicted = _meet(automatic.begin_ends, finishes) or _meet(automatic.finish_ends, begins)
    one_sided = not (begins or free[0]) or not (finishes or free[1])
    two_sided_if_turned = bool((begins or free[1]) and (finishes or free[0]))
    return (contradicted and not kept) or (one_sided and two_sided_if_turned)


def _meet(some: Sequence[End], others: Sequence[End]) -> bool:
    """Whether two groups of ends share a vertex."""
    return any(np.isin(one.vertices, other.vertices).any() for one in some for other in others)


def vertices_of(surface: TriangleSurface, mark: TimeMark) -> IntArray:
    """Return the vertices of a mark: the whole border, the path of a stroke over edges, or the nearest vertex.

    Raises:
        ParameterError: the mark is off the surface, or names a border of a closed one.
    """
    points = np.asarray(mark.points, dtype=np.float64)
    if mark.kind == "border":
        return surface.borders[nearest_border(surface, points[0])]
    vertices = _nearest_vertices(surface, points, mark)
    return vertices[:1] if mark.kind == "point" else _path(surface, vertices)


def nearest_border(surface: TriangleSurface, point: FloatArray) -> int:
    """Return the number of the border nearest to a point.

    Raises:
        ParameterError: the surface has no border.
    """
    if not surface.borders:
        raise ParameterError("mark: names a border, but the surface is closed; mark a point or a stroke")
    distance = [np.linalg.norm(surface.vertices[border] - point, axis=1).min() for border in surface.borders]
    return int(np.argmin(distance))


def _nearest_vertices(surface: TriangleSurface, points: FloatArray, mark: TimeMark) -> IntArray:
    """The vertex nearest to each point.

    Raises:
        ParameterError: a point is far from the surface.
    """
    from scipy.spatial import cKDTree

    distance, vertex = cKDTree(surface.vertices).query(points)
    size = float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
    far = int(distance.argmax())
    # A mark at this distance from the surface or farther, over the size of the surface, does not lie on it.
    if distance[far] > 0.05 * size:
        raise ParameterError(
            f"mark: point {far} of a {mark.kind} at {points[far].round(2).tolist()} cm is {distance[far]:.1f} cm off "
            "the surface; draw it on the surface, and check the unit"
        )
    return np.asarray(vertex, dtype=np.int64)


def _path(surface: TriangleSurface, stops: IntArray) -> IntArray:
    """Vertices along the shortest path over edges through some vertices."""
    from scipy.sparse.csgraph import dijkstra

    path = [int(stops[0])]
    for stop in stops[1:].tolist():
        _, before = dijkstra(surface.edge_graph, directed=False, indices=stop, return_predecessors=True)
        while path[-1] != stop:
            path.append(int(before[path[-1]]))
    known = np.array(path)
    return known[np.sort(np.unique(known, return_index=True)[1])]


def _check_apart(found: list[tuple[TimeMark, End]]) -> None:
    """Check that no two marks share a vertex.

    Raises:
        ParameterError: two marks share a vertex.
    """
    for number, (mark, end) in enumerate(found):
        for other, (second, later) in enumerate(found[number + 1 :], start=number + 1):
            if np.isin(end.vertices, later.vertices).any():
                raise ParameterError(
                    f"marks {number} and {other}: a {mark.kind} ({mark.role}) and a {second.kind} ({second.role}) "
                    "meet; a place has one time: remove one of them"
                )


def _check_times(surface: TriangleSurface, found: list[tuple[TimeMark, End]]) -> None:
    """Check that times agree with roles and with distances in space.

    Raises:
        ParameterError: the times do not agree.
    """
    timed = [(number, mark, end) for number, (mark, end) in enumerate(found) if mark.time is not None]
    for place, (number, mark, end) in enumerate(timed):
        for other, second, later in timed[place + 1 :]:
            assert mark.time is not None and second.time is not None
            change = second.time - mark.time
            backwards = {("begin", "end"): change <= 0.0, ("end", "begin"): change >= 0.0}.get((mark.role, second.role))
            if backwards:
                raise ParameterError(
                    f"marks {number} and {other}: knitting would end at {min(mark.time, second.time):g} cm and begin "
                    f"at {max(mark.time, second.time):g} cm; exchange the times, or the roles"
                )
            apart = _smallest_distance(surface, end.vertices, later.vertices)
            # The times of two marks contradict each other if their difference, over the distance in space, is
            # larger than this.
            if abs(change) > 0.0 and apart < abs(change) / 20.0:
                raise ParameterError(
                    f"marks {number} and {other}: times {mark.time:g} and {second.time:g} cm, but only {apart:.2g} cm "
                    "apart; rows would be crowded: bring the times together, or the marks apart"
                )


def _smallest_distance(surface: TriangleSurface, one: IntArray, other: IntArray) -> float:
    """Smallest distance in space between two sets of vertices [cm]."""
    return float(np.linalg.norm(surface.vertices[one][:, None] - surface.vertices[other][None], axis=2).min())
