# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where knitting begins and ends on a surface.

Rows are level lines of a time. It begins and ends at borders that are rows (hems, cuffs, necks), at marked points and
lines, and at the tips of closed limbs, which need no mark. Other borders are sides, at which rows end: slits, and the
sides of flat pieces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.selection.borders import CLOSED_LENGTH
from stitchmesh.shaping.border_rows import rows_of_border
from stitchmesh.shaping.borders import (
    FACING,
    LEVEL,
    highest_border,
    is_hole_in_side,
    is_slit,
    is_wide_hole,
    length_of,
    outline_sides,
    outward_of,
    turning,
    upwards,
)
from stitchmesh.shaping.straps import across_strap, bound_off, is_level, tops_of_straps
from stitchmesh.shaping.triangle_surface import TriangleSurface

FLAT_TURNING = np.pi
"""Turning above which the only border of a surface is the outline of a flat piece [rad]."""
FLAT = 0.5
"""Length of the sum of the normals of a piece, over its area, above which it is flat and not nearly a tube."""


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
    grafts: tuple[End, ...] = ()
    """Lines across straps at which the last rows of both sides meet."""
    begins: bool = True
    """Whether knitting begins at the roots; if not, it ends there."""
    automatic: bool = False
    """Whether no mark chose an end, so that those of short limbs can be left out."""

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
    that no finger goes through are tips, as those of a glove, and do not count if there are others. A closed surface
    begins at an end of its longest axis.

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
    """The borders other than the root; of these, only those that are no wide holes in a flat surface, if there are any.

    Narrow ones are tips, such as those of fingers.
    """
    others = [border for border in rows if border is not root]
    kept = [border for border in others if not is_wide_hole(surface, border)]
    return kept or others


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
    direction = direction_in_piece(surface, up)
    pieces = outline_sides(surface, outline)
    facing = [float(outward_of(surface, piece) @ direction) for piece in pieces]
    below = [piece for piece, cosine in zip(pieces, facing, strict=True) if cosine < -FACING]
    above = [piece for piece, cosine in zip(pieces, facing, strict=True) if cosine > FACING]
    if not below or len(pieces) < 2:
        return None
    begin = max(below, key=lambda piece: length_of(surface, piece, closed=False))
    # Two rows have no point in common: a slanting side that begins at a corner of the first row is no last row.
    return Ends((End(begin),), tuple(End(piece) for piece in above if not np.isin(piece, begin).any()))


def direction_in_piece(surface: TriangleSurface, up: FloatArray) -> FloatArray:
    """Return the unit vector along which a piece is knitted: upwards, or along its longest axis if it lies level."""
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


def _is_upper_end(surface: TriangleSurface, border: IntArray, up: FloatArray) -> bool:
    """Whether a border lies above the middle of the surface."""
    height = surface.vertices @ up
    return bool(height[border].mean() > 0.5 * (height.min() + height.max()))
