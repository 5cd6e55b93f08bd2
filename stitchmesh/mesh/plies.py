# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Plies: the twisted strands of a yarn, as helices around its centre line.

The strands of a yarn of n plies are circles that touch one another inside the circle of the yarn. In a yarn of radius R
the radius of a strand is

    r = R / (1 + 1 / sin(pi / n)),

and its centre line has the distance R - r from that of the yarn. The helices turn to the right (a Z twist is seen, as
in most knitting yarn after plying from singles of S twist) once in ``LAY`` radii, relative to the twist-free frame of
the centre line. On a closed curve the number of turns is whole, so that every strand is closed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.mesh.polygon_mesh import FloatArray
from stitchmesh.mesh.tube_mesh import twist_free_frames

LAY = 9.0
"""Length of one turn of the strands over the radius of the yarn; the strands lean by about 25 degrees."""
POINTS_PER_TURN = 10
"""Fewest points of a curve in one turn of its strands."""
FULLNESS = 1.12
"""Drawn radius of a strand over that of touching circles: soft strands are pressed together."""


def ply_radius(radius: ArrayLike, count: int) -> FloatArray:
    """Return the radius of the strands of yarns of ``count`` plies [cm]; the radius of the yarn for a single ply."""
    whole = np.asarray(radius, dtype=np.float64)
    return whole if count == 1 else whole / (1.0 + 1.0 / np.sin(np.pi / count))


def plies_around(curves: Sequence[FloatArray], closed: ArrayLike, radius: ArrayLike, count: int) -> list[FloatArray]:
    """Return the centre lines of the strands of each curve, strand by strand of the first curve, then of the next.

    Args:
        curves: points of each curve [cm], shape (n, 3) each; a closed curve does not repeat its first point.
        closed: whether each curve is closed.
        radius: radius of the yarn of each curve [cm], or one radius for all.
        count: number of plies, at least 2.

    Returns:
        Points of each strand [cm], with the shape of the curve.
    """
    flags: NDArray[np.bool_] = np.broadcast_to(np.asarray(closed, dtype=np.bool_), len(curves))
    radii = np.broadcast_to(np.asarray(radius, dtype=np.float64), len(curves))
    across, upward = twist_free_frames(curves, flags)
    strands, first = [], 0
    for points, is_closed, whole in zip(curves, flags, radii, strict=True):
        own = slice(first, first + len(points))
        first += len(points)
        phase = _phase(points, bool(is_closed), float(whole))
        offset = float(whole - ply_radius(whole, count))
        for strand in range(count):
            angle = (phase + 2.0 * np.pi * strand / count)[:, None]
            strands.append(points + offset * (np.cos(angle) * across[own] + np.sin(angle) * upward[own]))
    return strands


def _phase(points: FloatArray, closed: bool, radius: float) -> FloatArray:
    """Angle of the first strand at each point of a curve, shape (n,)."""
    steps = np.linalg.norm(np.diff(points, axis=0, append=points[:1]), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    length = along[-1] if closed else along[-2]
    turns = length / (LAY * radius)
    turns = max(round(turns), 1) if closed else turns
    return 2.0 * np.pi * turns * along[:-1] / max(length, 1e-12)
