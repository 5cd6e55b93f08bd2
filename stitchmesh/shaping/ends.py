# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where knitting begins and ends on a surface.

Rows are level lines of a time. It begins and ends at borders that are rows (hems, cuffs, necks), at marked points and
lines, and at the tips of closed limbs, which need no mark. Other borders are sides, at which rows end: slits, and the
sides of flat pieces.

The border of a garment that is open in front, or whose skirt has a slit, has corners: its parts that face downwards and
upwards are rows, and those between them are sides.

A border is told by how it turns. By the theorem of Gauss and Bonnet the turning of a border, the sum of pi minus the
angle of the surface at its vertices, is near 0 at the end of a tube, near 2 pi around a flat piece, and near -2 pi
around a hole in a flat piece.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.selection.borders import CLOSED_LENGTH
from stitchmesh.shaping.triangle_surface import TriangleSurface

SLIT_TURNING = -np.pi
"""Turning below which a border is a hole in a surface that is flat around it [rad]."""
FLAT_TURNING = np.pi
"""Turning above which the only border of a surface is the outline of a flat piece [rad]."""
SLIT_ELONGATION = 1.6
"""Extent along over extent across from which a hole is a slit, whose long sides rows run into."""
CORNER = np.radians(40.0)
"""Turning of an outline within a fiftieth of its length that makes a corner [rad]."""
OPEN_SIDES = 0.15
"""Part of a border that faces neither upwards nor downwards from which its corners divide it."""
FACING = 0.7
"""Cosine of the angle between the direction of knitting and the normal of a border that begins or ends rows."""
FACING_BESIDE = 0.5
"""The same for a part of a border beside one that begins or ends rows, such as the front of a neck."""
FLAT = 0.5
"""Length of the sum of the normals of a piece, over its area, above which it is flat and not nearly a tube."""
LEVEL = 0.02
"""Difference of height, over the size of the surface, below which two borders are equally high."""


@dataclass(frozen=True, eq=False)
class End:
    """Vertices that are knitted at one time: a border, a tip, or a line on the surface."""

    vertices: IntArray
    """The vertices; those of a border or a line are in order."""
    time: float | None = None
    """Distance along the fabric from where knitting begins [cm]; None if it follows from the size of the surface."""


@dataclass(frozen=True, eq=False)
class Ends:
    """Where the time begins and ends."""

    roots: tuple[End, ...]
    """The ends at one side: those where knitting begins, or those where it ends."""
    others: tuple[End, ...] = ()
    """The ends at the other side, apart from the tips of closed limbs."""
    lines: tuple[End, ...] = ()
    """Lines along which rows run, somewhere between."""
    begins: bool = True
    """Whether knitting begins at the roots; if not, it ends there."""
    automatic: bool = False
    """Whether no mark chose an end, so that those of short limbs can be left out."""

    @property
    def all(self) -> tuple[End, ...]:
        """All ends and lines, the roots first."""
        return (*self.roots, *self.others, *self.lines)

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
    the hood. A single border is where knitting begins if it is the lower end, as the brim of a hat, and where it ends
    if it is the upper one: a sock is knitted from the toe. Borders that no finger goes through are tips, as those of a
    glove, and do not count if there are others. A closed surface begins at an end of its longest axis.

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
    rows = rows or [max(surface.borders, key=lambda border: _length(surface, border))]
    rows = [part for border in rows for part in _rows_of_border(surface, border, up)]
    level = [row for row in rows if not _is_hole_in_side(surface, row, up)] or rows
    wide = [row for row in level if _length(surface, row) >= CLOSED_LENGTH] or level
    root = wide[_highest(surface, wide, up)]
    if len(level) < len(rows) and _upwards(surface, root, up) <= 0.0:
        return Ends(tuple(End(row) for row in wide), begins=True, automatic=True)
    others = tuple(End(row) for row in _without_holes(surface, level, root))
    begins = len(wide) == 1 and not _is_upper_end(surface, root, up)
    return Ends((End(root),), others, begins=begins, automatic=True)


def _rows_of_border(surface: TriangleSurface, border: IntArray, up: FloatArray) -> list[IntArray]:
    """The parts of a border that are rows, the vertices of each in order: often the whole border.

    A border that runs down one front of a garment and up the other, or up and down a slit, is divided at its corners.
    Parts beside each other that face the same way are one row, as a rounded neck. A hole in a surface that is flat
    around it, such as a square neck, is not divided.
    """
    if turning(surface, border) <= SLIT_TURNING:
        return [border]
    pieces = outline_sides(surface, border)
    facing = _facing(surface, pieces, up)
    if not facing.any():
        return [border]
    all_rows = {1.0, -1.0} <= set(facing)
    for side in (1.0, -1.0):
        # A piece of two fronts and the neck between them faces upwards on the whole.
        if side not in facing or (all_rows and facing.all()):
            pieces = _with_part_facing(surface, pieces, side * up)
    facing = _facing(surface, pieces, up)
    length = np.array([_length(surface, piece, closed=False) for piece in pieces])
    if length[facing == 0.0].sum() < OPEN_SIDES * length.sum():
        return [border]
    first = int(np.flatnonzero(facing != np.roll(facing, 1))[0])
    turned = sorted(range(len(pieces)), key=lambda number: (number - first) % len(pieces))
    runs = [(side, list(run)) for side, run in groupby(turned, key=lambda number: facing[number])]
    return [_joined([pieces[number] for number in run]) for side, run in runs if side != 0.0]


def _with_part_facing(surface: TriangleSurface, pieces: list[IntArray], direction: FloatArray) -> list[IntArray]:
    """Divide one of the parts of a border where it passes smoothly into a row that faces a direction, if one does.

    So do the fronts of a cardigan pass into its V-neck, or into a rounded hem. The longest such row is taken.
    """
    found = []
    for number, piece in enumerate(pieces):
        cosine = _cosine_of_edges(surface, piece, direction)
        for faces, run in groupby(range(len(cosine)), key=lambda edge: bool(cosine[edge] > FACING_BESIDE)):
            edges = list(run)
            if faces and cosine[edges].max() > FACING:
                row = piece[edges[0] : edges[-1] + 2]
                found.append((_length(surface, row, closed=False), number, edges[0], edges[-1] + 1))
    length, number, first, last = max(found, default=(0.0, 0, 0, 0))
    if length < CLOSED_LENGTH:
        return pieces
    piece = pieces[number]
    parts = [part for part in (piece[: first + 1], piece[first : last + 1], piece[last:]) if len(part) > 1]
    return [*pieces[:number], *parts, *pieces[number + 1 :]]


def _cosine_of_edges(surface: TriangleSurface, piece: IntArray, up: FloatArray) -> FloatArray:
    """Cosine between the upward direction and that in which the border faces around each edge, shape (n - 1,).

    It is the mean over a length of a border that is no tip, because the border of a scan is jagged.
    """
    outward, step = _outward_of_edges(surface, piece)
    place = np.cumsum(step) - 0.5 * step
    near = np.abs(place[:, None] - place[None, :]) <= 0.5 * CLOSED_LENGTH
    total = near @ (outward * step[:, None])
    size = np.maximum(np.linalg.norm(total, axis=1), np.finfo(np.float64).tiny)
    return np.asarray(total @ up / size)


def _facing(surface: TriangleSurface, pieces: list[IntArray], up: FloatArray) -> FloatArray:
    """Whether parts of a border face upwards (1), downwards (-1) or sideways (0), shape (n,)."""
    cosine = np.array([float(_outward(surface, piece) @ up) for piece in pieces])
    facing = np.where(np.abs(cosine) > FACING, np.sign(cosine), 0.0)
    for side in (1.0, -1.0):
        beside = (np.roll(facing, 1) == side) | (np.roll(facing, -1) == side)
        facing = np.where((facing == 0.0) & beside & (side * cosine > FACING_BESIDE), side, facing)
    return facing


def _joined(pieces: list[IntArray]) -> IntArray:
    """One part of a border from parts that follow each other and share their ends."""
    return np.append(np.concatenate([piece[:-1] for piece in pieces]), pieces[-1][-1])


def _without_holes(surface: TriangleSurface, rows: list[IntArray], root: IntArray) -> list[IntArray]:
    """The borders other than the root; of these, only those that are no wide holes in a flat surface, if there are any.

    Narrow ones are tips, such as those of fingers.
    """
    others = [border for border in rows if border is not root]
    kept = [border for border in others if not _is_wide_hole(surface, border)]
    return kept or others


def _is_wide_hole(surface: TriangleSurface, row: IntArray) -> bool:
    """Whether a row is a border around which the surface is flat and through which a hand goes."""
    return (
        _is_whole_border(surface, row)
        and _length(surface, row) >= CLOSED_LENGTH
        and turning(surface, row) <= SLIT_TURNING
    )


def _is_hole_in_side(surface: TriangleSurface, row: IntArray, up: FloatArray) -> bool:
    """Whether a row is a wide hole that faces neither upwards nor downwards, such as the face of a hood."""
    return _is_wide_hole(surface, row) and abs(_upwards(surface, row, up)) <= FACING


def _is_whole_border(surface: TriangleSurface, row: IntArray) -> bool:
    """Whether a row is a whole border, and not a part of one."""
    return any(row is border for border in surface.borders)


def _upwards(surface: TriangleSurface, row: IntArray, up: FloatArray) -> float:
    """Cosine of the angle between the upward direction and the direction in which a row faces."""
    run = np.append(row, row[0]) if _is_whole_border(surface, row) else row
    return float(_outward(surface, run) @ up)


def turning(surface: TriangleSurface, border: IntArray) -> float:
    """Return the turning of a border [rad]: the sum of pi minus the angle of the surface at each of its vertices."""
    return float(np.pi * len(border) - corner_angles(surface)[border].sum())


def corner_angles(surface: TriangleSurface) -> FloatArray:
    """Return the sum of the angles of the triangles at each vertex [rad], shape (V,)."""
    corner = surface.vertices[surface.triangles]
    ahead, behind = np.roll(corner, -1, axis=1) - corner, np.roll(corner, 1, axis=1) - corner
    across = np.linalg.norm(np.cross(ahead, behind), axis=2)
    angle = np.arctan2(across, np.einsum("tci,tci->tc", ahead, behind))
    total = np.bincount(surface.triangles.ravel(), angle.ravel(), len(surface.vertices))
    return np.asarray(total, dtype=np.float64)


def is_slit(surface: TriangleSurface, border: IntArray) -> bool:
    """Whether rows end at a border: a hole in a surface that is flat around it, and much longer than wide."""
    if turning(surface, border) > SLIT_TURNING:
        return False
    points = surface.vertices[border]
    step = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    weight = step + np.roll(step, 1)
    centred = points - np.average(points, axis=0, weights=weight)
    sizes = np.linalg.svd(centred * np.sqrt(weight)[:, None], compute_uv=False)
    return bool(sizes[0] > SLIT_ELONGATION * sizes[1])


def _ends_of_closed(surface: TriangleSurface, up: FloatArray) -> Ends:
    """The ends of a closed surface: the farther end of its longest axis is a tip, the other one is the root.

    Of the two ends, the root is the one nearer to the axis, so that a body begins at its head and not at one foot.
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
    direction = _direction_in_piece(surface, up)
    pieces = outline_sides(surface, outline)
    facing = [float(_outward(surface, piece) @ direction) for piece in pieces]
    below = [piece for piece, cosine in zip(pieces, facing, strict=True) if cosine < -FACING]
    above = [piece for piece, cosine in zip(pieces, facing, strict=True) if cosine > FACING]
    if not below or len(pieces) < 2:
        return None
    begin = max(below, key=lambda piece: _length(surface, piece, closed=False))
    # Two rows have no point in common: a slanting side that begins at a corner of the first row is no last row.
    return Ends((End(begin),), tuple(End(piece) for piece in above if not np.isin(piece, begin).any()))


def outline_sides(surface: TriangleSurface, outline: IntArray) -> list[IntArray]:
    """Divide the outline of a flat piece at its corners; the vertices of each side, both ends included."""
    points = surface.vertices[outline]
    step = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    turn = np.pi - corner_angles(surface)[outline]
    reach = 0.02 * step.sum()
    place = np.cumsum(step) - step
    away = np.abs(place[:, None] - place[None, :])
    away = np.minimum(away, step.sum() - away)
    total = np.where(away <= reach, turn[None, :], 0.0).sum(axis=1)
    peak = np.where(away <= reach, np.abs(turn)[None, :], 0.0).max(axis=1)
    corners = np.flatnonzero((np.abs(total) > CORNER) & (np.abs(turn) >= peak) & (np.abs(turn) > 0.0))
    if len(corners) < 2:
        return [np.append(outline, outline[0])]
    ring = np.roll(np.arange(len(outline)), -corners[0])
    cuts = [*(corners - corners[0]), len(outline)]
    return [outline[np.append(ring, ring[0])[first : last + 1]] for first, last in pairwise(cuts)]


def _direction_in_piece(surface: TriangleSurface, up: FloatArray) -> FloatArray:
    """The direction of knitting of a piece: upwards, or along its longest axis where it is flat and lies level."""
    normal = surface.vector_area.sum(axis=0)
    if np.linalg.norm(normal) < FLAT * surface.area.sum():
        return up
    normal = normal / np.linalg.norm(normal)
    along = up - (up @ normal) * normal
    if np.linalg.norm(along) > 0.3:
        return along / np.linalg.norm(along)
    centred = surface.vertices - surface.vertices.mean(axis=0)
    axis = np.linalg.svd(centred, full_matrices=False)[2][0]
    return axis * np.sign(axis[np.abs(axis).argmax()])


def _outward(surface: TriangleSurface, side: IntArray) -> FloatArray:
    """Unit vector along the mean, over a part of a border, of the direction that points away from the surface there."""
    outward, step = _outward_of_edges(surface, side)
    total = (outward * step[:, None]).sum(axis=0)
    return np.asarray(total / max(float(np.linalg.norm(total)), np.finfo(np.float64).tiny))


def _outward_of_edges(surface: TriangleSurface, side: IntArray) -> tuple[FloatArray, FloatArray]:
    """Unit vector that points away from the surface at each edge of a border, shape (n - 1, 3), and its length [cm]."""
    normal = surface.mesh.vertex_normal[side]
    step = np.diff(surface.vertices[side], axis=0)
    outward = np.cross(step, normal[1:] + normal[:-1])
    size = np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), np.finfo(np.float64).tiny)
    return outward / size, np.linalg.norm(step, axis=1)


def _length(surface: TriangleSurface, border: IntArray, *, closed: bool = True) -> float:
    points = surface.vertices[np.append(border, border[0]) if closed else border]
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _highest(surface: TriangleSurface, borders: list[IntArray], up: FloatArray) -> int:
    """The highest border; of several that are equally high the shortest, then the first along the axes."""
    height = np.array([surface.vertices[border].mean(axis=0) @ up for border in borders])
    size = float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
    high = np.flatnonzero(height > height.max() - LEVEL * size)
    lengths = np.array([_length(surface, borders[number]) for number in high])
    short = high[lengths < 1.02 * lengths.min()]
    return int(max(short, key=lambda number: tuple(np.round(surface.vertices[borders[number]].mean(axis=0), 6))))


def _is_upper_end(surface: TriangleSurface, border: IntArray, up: FloatArray) -> bool:
    """Whether a border lies above the middle of the surface."""
    height = surface.vertices @ up
    return bool(height[border].mean() > 0.5 * (height.min() + height.max()))
