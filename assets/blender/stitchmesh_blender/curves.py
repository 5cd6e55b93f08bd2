# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Points on the B-splines of yarns. Nothing here needs Blender."""

from __future__ import annotations

import numpy as np

POINTS_OF_SEGMENT = 3
"""Points on the curve for each segment of a B-spline; Cycles connects points, and does not evaluate the spline."""


def on_spline(control: np.ndarray, closed: bool) -> np.ndarray:
    """Return points on a uniform cubic B-spline; a closed curve repeats its first point.

    Args:
        control: control points, shape (n, 3).
        closed: whether the last control point is followed by the first one.

    Returns:
        Points, shape (m, 3).
    """
    s = np.arange(POINTS_OF_SEGMENT)[:, None] / POINTS_OF_SEGMENT
    weights = np.hstack([(1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3]) / 6.0
    corners = control[_segments(len(control), closed)]
    points = np.einsum("kj,sjd->skd", weights, corners).reshape(-1, 3)
    end = points[:1] if closed else np.array([[0.0, 1.0, 4.0, 1.0]]) @ corners[-1] / 6.0
    return np.concatenate([points, end])


def nearest_control(count: int, closed: bool) -> np.ndarray:
    """Return the control point that weighs most at each point of ``on_spline``, shape (m,).

    Labels such as the row are whole numbers, which cannot be interpolated.
    """
    segments = _segments(count, closed)
    later = np.arange(POINTS_OF_SEGMENT) > POINTS_OF_SEGMENT / 2
    chosen = np.where(later[None, :], segments[:, 2:3], segments[:, 1:2]).ravel()
    return np.append(chosen, chosen[0] if closed else segments[-1, 2])


def length_along(points: np.ndarray) -> np.ndarray:
    """Return the length of a curve from its start to each of its points, shape (m,), for points of shape (m, 3)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def _segments(count: int, closed: bool) -> np.ndarray:
    """Return the four control points of each segment, shape (s, 4)."""
    segments = count if closed else count - 3
    return (np.arange(segments)[:, None] + np.arange(4)) % count
