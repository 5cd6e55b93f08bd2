# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How a border of a surface turns, faces and lies, and its division at its corners.

By the theorem of Gauss and Bonnet the turning of a border, the sum of pi minus the angle of the surface at its
vertices, is near 0 at the end of a tube, near 2 pi around a flat piece, and near -2 pi around a hole in a flat piece.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.selection.borders import CLOSED_LENGTH
from stitchmesh.shaping.triangle_surface import TriangleSurface

SLIT_TURNING = -np.pi
"""Turning below which a border is a hole in a surface that is flat around it [rad]."""
CORNER = np.radians(40.0)
"""Turning of an outline within a fiftieth of its length that makes a corner [rad]."""
FACING = 0.7
"""Cosine of the angle between the direction of knitting and the normal of a border that begins or ends rows."""
FACING_BESIDE = 0.5
"""The same cosine for a part of a border beside a part that begins or ends rows, such as the front of a neck."""
LEVEL = 0.02
"""Difference of height, over the size of the surface, below which two borders are equally high."""


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
    """Return whether a border is a slit, at which rows end: a long, narrow hole in a surface that is flat around it."""
    if turning(surface, border) > SLIT_TURNING:
        return False
    points = surface.vertices[border]
    step = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    weight = step + np.roll(step, 1)
    centred = points - np.average(points, axis=0, weights=weight)
    sizes = np.linalg.svd(centred * np.sqrt(weight)[:, None], compute_uv=False)
    # Length of a hole over its width, from which it is a slit: rows end at its long sides.
    return bool(sizes[0] > 1.6 * sizes[1])


def is_wide_hole(surface: TriangleSurface, row: IntArray) -> bool:
    """Return whether a row is a wide hole: the surface is flat around it, and a hand goes through."""
    return (
        is_whole_border(surface, row)
        and length_of(surface, row) >= CLOSED_LENGTH
        and turning(surface, row) <= SLIT_TURNING
    )


def is_hole_in_side(surface: TriangleSurface, row: IntArray, up: FloatArray) -> bool:
    """Return whether a row is a wide hole that faces neither upwards nor downwards, such as the face of a hood."""
    return is_wide_hole(surface, row) and abs(upwards(surface, row, up)) <= FACING


def is_whole_border(surface: TriangleSurface, row: IntArray) -> bool:
    """Return whether a row is a whole border, and not a part of one."""
    return any(row is border for border in surface.borders)


def upwards(surface: TriangleSurface, row: IntArray, up: FloatArray) -> float:
    """Return the cosine of the angle between the upward direction and the direction in which a row faces."""
    run = np.append(row, row[0]) if is_whole_border(surface, row) else row
    return float(outward_of(surface, run) @ up)


def facing_of(surface: TriangleSurface, pieces: list[IntArray], up: FloatArray) -> FloatArray:
    """Return whether parts of a border face upwards (1), downwards (-1) or sideways (0), shape (n,)."""
    cosine = np.array([float(outward_of(surface, piece) @ up) for piece in pieces])
    facing = np.where(np.abs(cosine) > FACING, np.sign(cosine), 0.0)
    for side in (1.0, -1.0):
        beside = (np.roll(facing, 1) == side) | (np.roll(facing, -1) == side)
        facing = np.where((facing == 0.0) & beside & (side * cosine > FACING_BESIDE), side, facing)
    return facing


def outline_sides(surface: TriangleSurface, outline: IntArray) -> list[IntArray]:
    """Divide a border at its corners; return the vertices of each side, both ends included."""
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


def outward_of(surface: TriangleSurface, side: IntArray) -> FloatArray:
    """Return the unit vector along the mean direction away from the surface at a part of a border, shape (3,)."""
    outward, step = outward_of_edges(surface, side)
    total = (outward * step[:, None]).sum(axis=0)
    return np.asarray(total / max(float(np.linalg.norm(total)), np.finfo(np.float64).tiny))


def outward_of_edges(surface: TriangleSurface, side: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the unit vector away from the surface at each edge of a border, shape (n - 1, 3), and its length [cm]."""
    normal = surface.mesh.vertex_normal[side]
    step = np.diff(surface.vertices[side], axis=0)
    outward = np.cross(step, normal[1:] + normal[:-1])
    return unit_vectors(outward), np.linalg.norm(step, axis=1)


def length_of(surface: TriangleSurface, border: IntArray, *, closed: bool = True) -> float:
    """Return the length of a border, or of a part of one that is not closed [cm]."""
    points = surface.vertices[np.append(border, border[0]) if closed else border]
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def highest_border(surface: TriangleSurface, borders: list[IntArray], up: FloatArray) -> int:
    """Return the place of the highest border; among equally high ones the shortest, then the first along the axes."""
    height = np.array([surface.vertices[border].mean(axis=0) @ up for border in borders])
    size = float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
    high = np.flatnonzero(height > height.max() - LEVEL * size)
    lengths = np.array([length_of(surface, borders[number]) for number in high])
    short = high[lengths < 1.02 * lengths.min()]
    return int(max(short, key=lambda number: tuple(np.round(surface.vertices[borders[number]].mean(axis=0), 6))))
