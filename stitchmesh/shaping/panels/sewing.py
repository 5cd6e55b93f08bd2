# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Seams between knitted panels: grafts, rows that go on, and borders that are sewn.

Two hems are grafted stitch by stitch. Two sides are joined row by row if the left ends of the rows of one panel meet
the right ends of the rows of the other; the rows then go on from panel to panel. All other seams stay borders, for a
needle and a thread.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from stitchmesh.errors import LabelError, MeshError
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.connectivity import corner_fans, next_sides
from stitchmesh.mesh.courses import course_of_faces, courses_below, find_courses, knitting_order
from stitchmesh.mesh.shaping_stitches import with_increases
from stitchmesh.shaping.level_lines import LevelLine
from stitchmesh.shaping.panels.outline_pieces import BEGINS, ENDS, SIDE, OutlinePiece
from stitchmesh.shaping.panels.panel_rows import PanelStitches, RowEnd
from stitchmesh.tessellate.stitch_faces import GatheredFaces


@dataclass(frozen=True)
class SeamResult:
    """How a piece of a seam was made."""

    panels: tuple[int, int]
    """The panels on its two sides."""
    piece: int
    """Number of the piece of an outline on its first side."""
    length: float
    """Its length [cm]."""
    kind: str
    """``"grafted"``, ``"joined"`` (rows go on) or ``"sewn"``."""
    edges: int
    """Number of edges that the panels share; 0 if the seam is sewn."""


@dataclass(frozen=True, eq=False)
class _Faces:
    """The faces of all panels, before their vertices are joined."""

    points: FloatArray
    faces: GatheredFaces
    side_of_edge: dict[int, int]
    """Side of each edge that is on a border."""


def sewn_fabric(
    made: PanelStitches, pieces: list[OutlinePiece], lines: list[LevelLine], apart: Collection[tuple[int, int]] = ()
) -> tuple[StitchMesh, tuple[SeamResult, ...]]:
    """Join the panels at their seams where their stitches fit.

    Args:
        made: the stitches of all panels.
        pieces: pieces of the outlines.
        lines: the same pieces as lines.
        apart: pairs of panels, the lower number first, whose seams are sewn.

    Returns:
        The stitches, with rows in knitting order, and how each piece of a seam was made.
    """
    faces = _faces_of(made)
    twin = faces.faces.twin
    fabric = _stitch_mesh(faces, twin)
    # Distance between the ends of two rows along a seam, in course heights, up to which one row goes on in the
    # other.
    ends = _RowEnds(_ends_by_piece(made, pieces, lines), lines, 0.5 * made.size.height, faces.side_of_edge)
    results: dict[int, SeamResult] = {}
    joined: set[int] = set()
    for number in _sides_first(pieces):
        piece, other = pieces[number], pieces[pieces[number].partner]
        pair = (min(piece.panel, other.panel), max(piece.panel, other.panel))
        if pair in apart:
            kind, pairs = "sewn", []
        elif piece.kind != SIDE and other.kind != SIDE:
            kind = "grafted"
            fits = _graft_fits(pieces, number, joined)
            pairs = _hem_pairs(made.hem_edges, faces.side_of_edge, pieces, number) if fits else []
        else:
            kind, pairs = "joined", _row_pairs(ends, number, piece.partner)
        tried = None if _has_double_decrease(fabric, pairs) else _with_twins(fabric, faces, twin, pairs)
        if tried is None:
            kind, pairs = "sewn", []
        else:
            fabric, twin = tried
            joined |= {number, piece.partner}
        results[number] = SeamResult((piece.panel, other.panel), number, piece.length, kind, len(pairs))
    return in_knitting_order(fabric), tuple(results[number] for number in sorted(results))


def _sides_first(pieces: list[OutlinePiece]) -> list[int]:
    """The first piece of each seam.

    Seams of two sides come first, because seams of two hems depend on the seams beside them.
    """
    seams = [number for number, piece in enumerate(pieces) if piece.partner > number]
    return sorted(seams, key=lambda number: SIDE not in (pieces[number].kind, pieces[pieces[number].partner].kind))


def _graft_fits(pieces: list[OutlinePiece], number: int, joined: Collection[int]) -> bool:
    """Whether there is room for the yarns at the ends of a graft of two hems.

    Where rows begin on both sides, the first rows must go on in the other panel beside the graft: otherwise the yarns
    at their ends would lie in one place. Where rows end on both sides, the last rows must not go on: a round that is
    closed beside the graft has no loop in which the yarn of the graft can turn.
    """
    kinds = {pieces[number].kind, pieces[pieces[number].partner].kind}
    if kinds == {BEGINS, ENDS}:
        return True
    before = {piece.following: place for place, piece in enumerate(pieces)}
    beside = [side for one in (number, pieces[number].partner) for side in (pieces[one].following, before[one])]
    goes_on = [side in joined for side in beside if pieces[side].kind == SIDE]
    return all(goes_on) if kinds == {BEGINS} else not any(goes_on)


def _has_double_decrease(fabric: StitchMesh, pairs: list[tuple[int, int]]) -> bool:
    """Whether a stitch at a seam takes three loops together, which has no room beside the stitch of the other panel."""
    faces = fabric.side_face[np.array(pairs, dtype=np.int64).reshape(-1)]
    return bool((fabric.n_bottom[faces] - fabric.n_top[faces] > 1).any())


def in_knitting_order(fabric: StitchMesh) -> StitchMesh:
    """Return the fabric with a number for each row, also across seams, so that rows follow the rows below them."""
    courses = sorted(find_courses(fabric, climbing=True), key=lambda course: int(fabric.row[list(course.faces)].min()))
    below = [under - {number} for number, under in enumerate(courses_below(fabric, courses))]
    order, cyclic = knitting_order(below)
    number = np.empty(len(courses), dtype=np.int64)
    number[[*order, *cyclic]] = np.arange(len(courses))
    return replace(fabric, row=number[course_of_faces(fabric, courses)])


def _faces_of(made: PanelStitches) -> _Faces:
    """Gather the faces, with the twins within the panels."""
    faces = made.faces.gathered()
    border = np.flatnonzero(faces.twin == BORDER)
    return _Faces(np.array(made.points), faces, dict(zip(faces.edge[border].tolist(), border.tolist(), strict=True)))


def _stitch_mesh(faces: _Faces, twin: IntArray) -> StitchMesh:
    """Make the stitch mesh of faces with some twins; corners share a vertex if faces around it are joined by edges.

    A vertex takes the mean of the positions of the vertices that it was made of.
    """
    fan = corner_fans(twin, next_sides(faces.faces.start))
    members = np.unique(np.stack([fan, faces.faces.corner], axis=1), axis=0)
    count = np.bincount(members[:, 0])
    position = faces.points[members[:, 1]]
    vertices = np.stack([np.bincount(members[:, 0], position[:, axis]) / count for axis in range(3)], axis=1)
    return with_increases(replace(faces.faces, corner=fan, twin=twin).mesh(vertices))


def _with_twins(
    fabric: StitchMesh, faces: _Faces, twin: IntArray, pairs: list[tuple[int, int]]
) -> tuple[StitchMesh, IntArray] | None:
    """Join pairs of border sides; None if there are none, or the result would not be legal."""
    if not pairs:
        return None
    first, second = np.array(pairs).T
    joined = twin.copy()
    joined[first], joined[second] = second, first
    if (fabric.side_face[first] == fabric.side_face[second]).any():
        return None
    try:
        return _stitch_mesh(faces, joined), joined
    except (MeshError, LabelError):
        return None


def _hem_pairs(
    hem_edges: dict[int, tuple[int, ...]], sides: dict[int, int], pieces: list[OutlinePiece], number: int
) -> list[tuple[int, int]]:
    """Pair the sides along two hems, from one end of the seam to the other; none if their numbers differ."""
    lines = []
    for one in (number, pieces[number].partner):
        edges = hem_edges.get(one, ())
        # The border runs from left to right where rows begin, and from right to left where they end.
        along = edges if pieces[one].kind < 0 else edges[::-1]
        lines.append([sides[edge] for edge in along if edge in sides])
    if len(lines[0]) != len(lines[1]):
        return []
    return list(zip(lines[0], lines[1][::-1], strict=True))


@dataclass(frozen=True)
class _PlacedEnd:
    """The end of a row at a piece of an outline."""

    end: RowEnd
    first: float
    last: float
    """Lengths along the piece to the two vertices of the edge [cm], ascending."""


def _ends_by_piece(
    made: PanelStitches, pieces: list[OutlinePiece], lines: list[LevelLine]
) -> dict[int, list[_PlacedEnd]]:
    """Find the piece of the outline at which each row ends; return the ends at each piece, in their order along it."""
    found: dict[int, list[_PlacedEnd]] = {}
    own: dict[int, list[int]] = {}
    for number, piece in enumerate(pieces):
        own.setdefault(piece.panel, []).append(number)
    for end in made.row_ends:
        points = [made.points[vertex] for vertex in end.vertices]
        placed = [_placed_on(lines[number], end, points) for number in own[end.panel]]
        number, best = min(zip(own[end.panel], placed, strict=True), key=lambda pair: pair[1][0])
        found.setdefault(number, []).append(best[1])
    return {number: sorted(ends, key=lambda end: end.first) for number, ends in found.items()}


def _placed_on(line: LevelLine, end: RowEnd, points: list[FloatArray]) -> tuple[float, _PlacedEnd]:
    """Return the distance of a row end from a piece of an outline [cm], and its place there.

    The border runs upwards at right ends of rows and downwards at left ends. If a piece runs the other way, the length
    of the edge is added, because the two sides of a seam of one panel lie on each other.
    """
    lower, upper = (line.nearest(point) for point in points)
    wrong_way = (upper[0] > lower[0]) != end.right
    length = float(np.linalg.norm(points[1] - points[0]))
    distance = 0.5 * (lower[1] + upper[1]) + (length if wrong_way else 0.0)
    return distance, _PlacedEnd(end, *sorted((lower[0], upper[0])))


@dataclass(frozen=True, eq=False)
class _RowEnds:
    """The ends of all rows, for their comparison at seams."""

    by_piece: dict[int, list[_PlacedEnd]]
    """Ends at each piece of the outlines, in the order along it."""
    lines: list[LevelLine]
    """The pieces."""
    near: float
    """Distance along a seam up to which ends agree [cm]."""
    sides: dict[int, int]
    """Border side of each edge."""


def _row_pairs(ends: _RowEnds, first: int, second: int) -> list[tuple[int, int]]:
    """Pair the sides at the ends of rows at the two sides of a seam; none if the rows do not agree."""
    length = ends.lines[second].length
    one, back = ends.by_piece.get(first, []), reversed(ends.by_piece.get(second, []))
    other = [_PlacedEnd(end.end, length - end.last, length - end.first) for end in back]
    if {end.end.right for end in one} == {end.end.right for end in other} or not _in_one_line(one, other):
        return []
    apart = np.array([[max(abs(a.first - b.first), abs(a.last - b.last)) for b in other] for a in one])
    pairs = np.argwhere(apart <= ends.near)
    # Part of the row ends at a seam that must agree; if fewer do, the seam is sewn.
    if len(pairs) < 0.8 * max(len(one), len(other)) or (np.diff(pairs, axis=0) != 1).any():
        return []
    return [(ends.sides[one[i].end.edge], ends.sides[other[j].end.edge]) for i, j in pairs.tolist()]


def _in_one_line(*lines: Sequence[_PlacedEnd]) -> bool:
    """Whether each line of row ends has only left or only right ends, and each edge starts where another one ends."""
    for line in lines:
        ends = [placed.end for placed in line]
        if len({end.right for end in ends}) != 1:
            return False
        if any(not set(a.vertices) & set(b.vertices) for a, b in pairwise(ends)):
            return False
    return True
