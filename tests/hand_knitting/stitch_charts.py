# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flat pieces and tubes from rows of stitch codes, as seen from the right side; the first row is the lowest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.stitch import CODES, SIDE_COUNTS, Stitch


def chart_fabric(rows: Sequence[str], *, ring: bool = False, yarns: Sequence[str] = ()) -> StitchMesh:
    """Return a fabric of rows such as ``"k d21k y k"``; ``co`` casts on one loop, ``dt`` draws the yarn through one.

    Args:
        rows: codes from left to right; the first row is cast on.
        ring: whether each row closes around a tube.
        yarns: digits for the yarn of each stitch of each row; yarn 0 everywhere unless given.
    """
    stitches = [[_stitch(code) for code in row.split()] for row in rows]
    loops = [sum(below for _, below, _ in stitches[0])]
    loops += [sum(above for _, _, above in row) for row in stitches]
    points, first = _course_lines(loops, ring)
    faces: list[list[int]] = []
    for level, row in enumerate(stitches):
        below = above = 0
        for _, n_bottom, n_top in row:
            low = [_point(first, loops, level, below + k, ring) for k in range(n_bottom + 1)]
            high = [_point(first, loops, level + 1, above + k, ring) for k in range(n_top + 1)]
            faces.append(low + high[::-1])
            below, above = below + n_bottom, above + n_top
        assert below == loops[level], f"row {level} takes {below} of {loops[level]} loops"
    flat = [item for row in stitches for item in row]
    start = np.concatenate([[0], np.cumsum([len(face) for face in faces])])
    corners = np.array([vertex for face in faces for vertex in face])
    return StitchMesh(
        points, start, corners, find_twins(start, corners, len(points)),
        n_bottom=[below for _, below, _ in flat], n_top=[above for _, _, above in flat],
        stitch=[stitch for stitch, _, _ in flat], row=np.repeat(np.arange(len(rows)), [len(row) for row in stitches]),
        yarn=[int(digit) for row in yarns for digit in row],
    )  # fmt: skip


def _stitch(code: str) -> tuple[Stitch, int, int]:
    special = {"co": (Stitch.CAST_ON, 1, 1), "new": (Stitch.CAST_ON, 0, 1), "dt": (Stitch.DRAW_THROUGH, 1, 0)}
    return special.get(code) or (CODES[code], *SIDE_COUNTS[CODES[code]])


def _course_lines(loops: list[int], ring: bool) -> tuple[np.ndarray, list[int]]:
    """Return the points on all course lines, and the first point of each line."""
    points, first = [], []
    for level, count in enumerate(loops):
        first.append(len(points))
        for k in range(max(count, 1) if ring else count + 1):
            share = k / max(count, 1)
            turn = 2.0 * np.pi * share
            radius = 3.0 if count else 0.0
            points.append([radius * np.cos(turn), radius * np.sin(turn), level] if ring else [10.0 * share, level, 0.0])
    return np.array(points), first


def _point(first: list[int], loops: list[int], level: int, place: int, ring: bool) -> int:
    return first[level] + (place % max(loops[level], 1) if ring else place)
