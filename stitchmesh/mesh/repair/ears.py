# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Division of one polygon into triangles by its ears, also for a polygon that passes a bridge twice.

An ear is a triangle of three successive corners that holds no other corner. Source: Meisters, *Polygons have ears*
(1975).
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh.polygon_mesh import FloatArray

FLAT = 1e-12
"""Area of a triangle that is no ear, as a multiple of the area of the square around the polygon."""


def clip_ears(points: FloatArray, numbers: list[int]) -> list[tuple[int, int, int]]:
    """Divide a polygon into triangles; the ear with the best shape is cut off first.

    Args:
        points: positions of the corners [cm], shape (n, 3), nearly in one plane.
        numbers: number of the vertex at each corner; corners at one vertex do not hide each other.

    Returns:
        Places of the corners of each triangle, or an empty list if the polygon crosses itself.
    """
    flat = _in_plane(points)
    number = np.array(numbers)
    least = FLAT * float(np.max(np.ptp(flat, axis=0))) ** 2
    left = np.arange(len(points) if least > 0.0 else 0)
    triangles: list[tuple[int, int, int]] = []
    while len(left) >= 3:
        ear = _best_ear(flat, number, left, least)
        if ear < 0:
            return []
        before, after = left[ear - 1], left[(ear + 1) % len(left)]
        triangles.append((int(before), int(left[ear]), int(after)))
        left = np.delete(left, ear) if len(left) > 3 else left[:0]
    return triangles


def _in_plane(points: FloatArray) -> FloatArray:
    """Positions in the mean plane of a polygon, anticlockwise, shape (n, 2)."""
    spans = points - points[0]
    normal = np.cross(spans, np.roll(spans, -1, axis=0)).sum(axis=0)
    across = np.eye(3)[np.argmin(np.abs(normal))]
    right = np.cross(across, normal)
    up = np.cross(normal, right)
    axes = np.stack([right, up], axis=1) / np.maximum(np.linalg.norm([right, up], axis=1), np.finfo(float).tiny)
    plane: FloatArray = spans @ axes
    return plane


def _best_ear(flat: FloatArray, number: np.ndarray, left: np.ndarray, least: float) -> int:
    """Place in ``left`` of the ear with the largest area for its perimeter, -1 if there is no ear."""
    a, b, c = flat[np.roll(left, 1)], flat[left], flat[np.roll(left, -1)]
    area = _turn(a, b, c)
    shape = area / np.maximum(sum(np.sum((p - q) ** 2, axis=1) for p, q in ((a, b), (b, c), (c, a))), least)
    for ear in np.argsort(-shape, kind="stable"):
        if area[ear] <= least:
            return -1
        own = [number[left[ear - 1]], number[left[ear]], number[left[(ear + 1) % len(left)]]]
        others = flat[left[~np.isin(number[left], own)]]
        sides = [_turn(p, q, others) for p, q in ((a[ear], b[ear]), (b[ear], c[ear]), (c[ear], a[ear]))]
        if not (np.minimum.reduce(sides) >= 0.0).any():
            return int(ear)
    return -1


def _turn(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Twice the area of triangles in a plane, positive anticlockwise, shape (n,)."""
    turn: FloatArray = (b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0]
    return turn
