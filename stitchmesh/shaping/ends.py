# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where knitting begins and ends on a surface.

Rows are level lines of a time. It begins and ends at borders that are rows (hems, cuffs, necks), at marked points and
lines, and at the tips of closed limbs, which need no mark. Other borders are sides, at which rows end: slits, and the
sides of flat pieces.

A border may be divided. The border of a garment that is open in front, or whose skirt has a slit, has corners: its
parts that face downwards and upwards are rows, and the parts between them are sides.

At straps and bibs part of a row is bound off while the rest of it goes on. The upper border of a camisole is bound off
in front and behind, its straps are knitted on from there, and the last rows of the two halves of a strap are grafted to
each other where the strap is highest.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.selection.borders import CLOSED_LENGTH
from stitchmesh.shaping.borders import (
    FACING,
    FACING_BESIDE,
    LEVEL,
    SLIT_TURNING,
    facing_of,
    highest_border,
    is_hole_in_side,
    is_slit,
    is_whole_border,
    is_wide_hole,
    length_of,
    outline_sides,
    outward_of,
    outward_of_edges,
    turning,
    upwards,
)
from stitchmesh.shaping.triangle_surface import TriangleSurface

FLAT_TURNING = np.pi
"""Turning above which the only border of a surface is the outline of a flat piece [rad]."""


def rows_of_border(surface: TriangleSurface, border: IntArray, up: FloatArray) -> list[IntArray]:
    """Return the parts of a border that are rows, the vertices of each in order: often the whole border.

    A border that runs down one front of a garment and up the other, or up and down a slit, is divided at its corners.
    Parts beside each other that face the same way are one row, as a rounded neck. A hole in a surface that is flat
    around it, such as a square neck, is not divided.
    """
    if turning(surface, border) <= SLIT_TURNING:
        return [border]
    pieces = outline_sides(surface, border)
    facing = facing_of(surface, pieces, up)
    if not facing.any():
        return [border]
    all_rows = {1.0, -1.0} <= set(facing)
    for side in (1.0, -1.0):
        # A piece of two fronts and the neck between them faces upwards on the whole.
        if side not in facing or (all_rows and facing.all()):
            pieces = _with_part_facing(surface, pieces, side * up)
    facing = facing_of(surface, pieces, up)
    length = np.array([length_of(surface, piece, closed=False) for piece in pieces])
    # A border is divided at its corners if at least this part of it faces neither upwards nor downwards.
    if length[facing == 0.0].sum() < 0.15 * length.sum():
        return [border]
    first = int(np.flatnonzero(facing != np.roll(facing, 1))[0])
    turned = sorted(range(len(pieces)), key=lambda number: (number - first) % len(pieces))
    runs = [(side, list(run)) for side, run in groupby(turned, key=lambda number: facing[number])]
    return [_joined([pieces[number] for number in run]) for side, run in runs if side != 0.0]


def _with_part_facing(surface: TriangleSurface, pieces: list[IntArray], direction: FloatArray) -> list[IntArray]:
    """Divide a part of a border where it passes smoothly into a row that faces a direction, if there is such a row.

    The fronts of a cardigan pass so into its V-neck, or into a rounded hem. The longest such row is taken.
    """
    found = []
    for number, piece in enumerate(pieces):
        cosine = _cosine_of_edges(surface, piece, direction)
        for faces, run in groupby(range(len(cosine)), key=lambda edge: bool(cosine[edge] > FACING_BESIDE)):
            edges = list(run)
            if faces and cosine[edges].max() > FACING:
                row = piece[edges[0] : edges[-1] + 2]
                found.append((length_of(surface, row, closed=False), number, edges[0], edges[-1] + 1))
    length, number, first, last = max(found, default=(0.0, 0, 0, 0))
    if length < CLOSED_LENGTH:
        return pieces
    piece = pieces[number]
    parts = [part for part in (piece[: first + 1], piece[first : last + 1], piece[last:]) if len(part) > 1]
    return [*pieces[:number], *parts, *pieces[number + 1 :]]


def _cosine_of_edges(surface: TriangleSurface, piece: IntArray, up: FloatArray) -> FloatArray:
    """Cosine between the upward direction and the direction in which the border faces at each edge, shape (n - 1,).

    It is a mean over the length of the shortest border that is no tip, because the border of a scan is jagged.
    """
    outward, step = outward_of_edges(surface, piece)
    place = np.cumsum(step) - 0.5 * step
    near = np.abs(place[:, None] - place[None, :]) <= 0.5 * CLOSED_LENGTH
    total = near @ (outward * step[:, None])
    size = np.maximum(np.linalg.norm(total, axis=1), np.finfo(np.float64).tiny)
    return np.asarray(total @ up / size)


def _joined(pieces: list[IntArray]) -> IntArray:
    """One part of a border from parts that follow each other and share their ends."""
    return np.append(np.concatenate([piece[:-1] for piece in pieces]), pieces[-1][-1])


def bound_off(
    surface: TriangleSurface, border: IntArray, rows: list[IntArray], tops: list[int], up: FloatArray
) -> list[IntArray]:
    """Return the rows of a border that end part of a row, while the rest goes on, as at the neck between straps.

    Among the rows of one border that face upwards, these are the lower ones, such as the back of a bib, or all of them
    where the border rises between them, as along straps. At a hole in the side, such as an armhole, they are the rows
    below the hole.

    Args:
        surface: the surface.
        border: a border.
        rows: its rows.
        tops: the highest vertices of its straps.
        up: unit vector, shape (3,).
    """
    if is_hole_in_side(surface, border, up):
        pieces = outline_sides(surface, border)
        facing = facing_of(surface, pieces, up)
        return [piece for piece, side in zip(pieces, facing, strict=True) if side > 0.0]
    upper = _upper_rows(surface, rows, up)
    if len(upper) < 2:
        return []
    if tops:
        return upper
    highest = upper[highest_border(surface, upper, up)]
    return [row for row in upper if row is not highest]


def _upper_rows(surface: TriangleSurface, rows: list[IntArray], up: FloatArray) -> list[IntArray]:
    """The parts of borders among some rows that face upwards."""
    return [row for row in rows if not is_whole_border(surface, row) and upwards(surface, row, up) > 0.0]


def tops_of_straps(surface: TriangleSurface, border: IntArray, rows: list[IntArray], up: FloatArray) -> list[int]:
    """Return the highest vertices of a border between its upper rows, if it rises above all of them as along straps."""
    rows = _upper_rows(surface, rows, up)
    if len(rows) < 2:
        return []
    height = surface.vertices @ up
    used = set(np.concatenate(rows).tolist())
    ring = np.roll(border, -int(np.flatnonzero(border == rows[0][0])[0]))
    between = [(own, list(run)) for own, run in groupby(ring.tolist(), key=used.__contains__)]
    tops = [max(run, key=height.__getitem__) for own, run in between if not own]
    level = max(float(height[row].max()) for row in rows)
    return [top for top in tops if height[top] > level + CLOSED_LENGTH]


def across_strap(surface: TriangleSurface, top: int) -> IntArray:
    """Return the shortest path over edges from a vertex of a border to another border; without one, the vertex."""
    from scipy.sparse.csgraph import dijkstra

    others = [border for border in surface.borders if top not in border]
    if not others:
        return np.array([top])
    distance, before = dijkstra(surface.edge_graph, directed=False, indices=top, return_predecessors=True)
    facing = np.concatenate(others)
    path = [int(facing[distance[facing].argmin()])]
    while path[-1] != top:
        path.append(int(before[path[-1]]))
    return np.array(path)


def is_level(surface: TriangleSurface, row: IntArray, up: FloatArray) -> bool:
    """Return whether a part of a border is nearly level, so that a row can run along all of it."""
    # Range of heights, over the length, below which a part of a border is level.
    return float(np.ptp(surface.vertices[row] @ up)) < 0.15 * length_of(surface, row, closed=False)


@dataclass(frozen=True, eq=False)
class End:
    """Vertices that are knitted at one time: a border, a tip, or a line on the surface."""

    vertices: IntArray
    """The vertices; the vertices of a border or a line are in order."""
    time: float | None = None
    """Distance along the fabric from where knitting begins [cm]; None if it follows from the size of the surface."""


@dataclass(frozen=True, eq=False)
class Ends:
    """Where the time begins and ends."""

    roots: tuple[End, ...]
    """The ends at one side: all ends where knitting begins, or all ends where it ends."""
    others: tuple[End, ...] = ()
    """The ends at the other side, apart from the tips of closed limbs."""
    lines: tuple[End, ...] = ()
    """Lines along which rows run, somewhere between."""
    grafts: tuple[End, ...] = ()
    """Lines across straps at which the last rows of both sides meet."""
    begins: bool = True
    """Whether knitting begins at the roots; if not, it ends there."""
    automatic: bool = False
    """Whether no mark chose an end, so that the ends of short limbs can be left out."""

    @property
    def all(self) -> tuple[End, ...]:
        """All ends and lines, the roots first and the grafts last."""
        return (*self.roots, *self.others, *self.lines, *self.grafts)

    @property
    def begin_ends(self) -> tuple[End, ...]:
        """The ends at which knitting begins."""
        return self.roots if self.begins else self.others

    @property
    def finish_ends(self) -> tuple[End, ...]:
        """The ends at which knitting ends."""
        return self.others if self.begins else self.roots


def automatic_ends(surface: TriangleSurface, up: FloatArray) -> Ends:
    """Choose the ends of a connected surface.

    Holes in a surface that is flat around them, such as the armholes of a vest, are sides if other borders are left.
    The highest of several borders is the root, and knitting ends there: from the hem to the neck, from the cuff to the
    shoulder. Where the face of a hood is the only upper border, knitting begins at all others and ends at the tip of
    the hood; where a garment has straps, it ends at their tops. A single border is where knitting begins if it is the
    lower end, as the brim of a hat, and where it ends if it is the upper one: a sock is knitted from the toe. Borders
    that no finger goes through are tips, as at the fingers of a glove, and do not count if there are others. A closed
    surface begins at an end of its longest axis.

    Args:
        surface: a connected surface.
        up: unit vector, shape (3,).
    """
    if not surface.borders:
        return _ends_of_closed(surface, up)
    if len(surface.borders) == 1 and turning(surface, surface.borders[0]) > FLAT_TURNING:
        flat = _ends_of_outline(surface, surface.borders[0], up)
        if flat is not None:
            return flat
    rows = [border for border in surface.borders if not is_slit(surface, border)]
    rows = rows or [max(surface.borders, key=lambda border: length_of(surface, border))]
    parts = [rows_of_border(surface, border, up) for border in rows]
    tops = [tops_of_straps(surface, border, own, up) for border, own in zip(rows, parts, strict=True)]
    paths = [across_strap(surface, top) for own in tops for top in own]
    grafts = tuple(End(path) for path in paths if len(path) > 1)
    off = [row for pair in zip(rows, parts, tops, strict=True) for row in bound_off(surface, *pair, up)]
    lines = tuple(End(row) for row in off if is_level(surface, row, up))
    rows = [row for own in parts for row in own if not any(row is other for other in off)]
    level = [row for row in rows if not is_hole_in_side(surface, row, up)]
    if not level:  # the only openings are holes in the side: they are rows, and nothing is bound off at them
        level, lines = rows, ()
    wide = [row for row in level if length_of(surface, row) >= CLOSED_LENGTH] or level
    root = wide[highest_border(surface, wide, up)]
    if (any(tops) or len(level) < len(rows)) and upwards(surface, root, up) <= 0.0:
        return Ends(tuple(End(row) for row in wide), (), lines, grafts, begins=True, automatic=True)
    others = tuple(End(row) for row in _without_holes(surface, level, root))
    begins = len(wide) == 1 and not _is_upper_end(surface, root, up)
    return Ends((End(root),), others, lines, grafts, begins=begins, automatic=True)


def _without_holes(surface: TriangleSurface, rows: list[IntArray], root: IntArray) -> list[IntArray]:
    """The borders other than the root, without wide holes in a flat surface if any other border is left.

    Narrow holes stay, because they are tips, such as the tips of fingers.
    """
    others = [border for border in rows if border is not root]
    kept = [border for border in others if not is_wide_hole(surface, border)]
    return kept or others


def _ends_of_closed(surface: TriangleSurface, up: FloatArray) -> Ends:
    """The ends of a closed surface: one end of its longest axis is a tip, the other one is the root.

    The root is the end nearer to the axis, so that a body begins at its head and not at one foot.
    """
    centred = surface.vertices - np.average(surface.vertices, axis=0, weights=surface.vertex_area)
    moment = (centred * surface.vertex_area[:, None]).T @ centred
    axis = np.linalg.eigh(moment)[1][:, -1]
    along = centred @ axis
    ends = np.array([along.argmin(), along.argmax()])
    beside = np.linalg.norm(centred[ends] - along[ends, None] * axis, axis=1)
    lower = int((centred[ends] @ up).argmin())
    uneven = abs(beside[0] - beside[1]) > LEVEL * np.ptp(along)
    root = int(beside.argmin()) if uneven else lower
    return Ends((End(ends[[root]]),), begins=root == lower)


def _ends_of_outline(surface: TriangleSurface, outline: IntArray, up: FloatArray) -> Ends | None:
    """The ends of a flat piece with corners: the sides of its outline below and above; None without such sides."""
    direction = direction_in_piece(surface, up)
    pieces = outline_sides(surface, outline)
    facing = [float(outward_of(surface, piece) @ direction) for piece in pieces]
    below = [piece for piece, cosine in zip(pieces, facing, strict=True) if cosine < -FACING]
    above = [piece for piece, cosine in zip(pieces, facing, strict=True) if cosine > FACING]
    if not below or len(pieces) < 2:
        return None
    begin = max(below, key=lambda piece: length_of(surface, piece, closed=False))
    # Two rows share no point, so a slanting side that begins at a corner of the first row is not a last row.
    return Ends((End(begin),), tuple(End(piece) for piece in above if not np.isin(piece, begin).any()))


def direction_in_piece(surface: TriangleSurface, up: FloatArray) -> FloatArray:
    """Return the unit vector along which a piece is knitted: upwards, or along its longest axis if it lies level."""
    normal = surface.vector_area.sum(axis=0)
    # Length of the sum of the normals of a piece, over its area, above which it is flat and not nearly a tube.
    if np.linalg.norm(normal) < 0.5 * surface.area.sum():
        return up
    normal = normal / np.linalg.norm(normal)
    along = up - (up @ normal) * normal
    if np.linalg.norm(along) > 0.3:
        return along / np.linalg.norm(along)
    centred = surface.vertices - surface.vertices.mean(axis=0)
    axis = np.linalg.svd(centred, full_matrices=False)[2][0]
    return axis * np.sign(axis[np.abs(axis).argmax()])


def _is_upper_end(surface: TriangleSurface, border: IntArray, up: FloatArray) -> bool:
    """Whether a border lies above the middle of the surface."""
    height = surface.vertices @ up
    return bool(height[border].mean() > 0.5 * (height.min() + height.max()))
