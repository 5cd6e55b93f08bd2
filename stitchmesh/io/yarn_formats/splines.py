# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conversion between cubic B-splines and the other kinds of curves in yarn files.

A Catmull-Rom curve passes through its points p_k with the tangent (p_(k+1) - p_(k-1)) / 2. A cubic B-spline with the
control points q_k passes through (q_(k-1) + 4 q_k + q_(k+1)) / 6. After a conversion the two curves agree at these
points and differ between them, because the Catmull-Rom curve has continuous tangents and the B-spline also a continuous
curvature.

An open curve of n points starts at the second point and ends at the last but one. Its first and last points only define
the tangents at the ends, (p_2 - p_0) / 2 at the start of a Catmull-Rom curve and (q_2 - q_0) / 2 at the start of a
B-spline. The conversion keeps these tangents, so that it is one to one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.mesh import FloatArray
from stitchmesh.yarn import basis

COMPARED = np.arange(1, 16) / 16
"""Parameters in a segment at which two curves are compared."""


def catmull_rom_to_bspline(points: ArrayLike, closed: bool) -> tuple[FloatArray, float]:
    """Return the control points of the B-spline through the points of a Catmull-Rom curve.

    Args:
        points: points of the curve, shape (n, 3); n is at least 3 for a closed curve and 4 for an open one.
        closed: whether the curve returns to its first point.

    Returns:
        Control points, shape (n, 3), and the largest distance between points of equal parameter on the two curves.
    """
    through = np.asarray(points, dtype=np.float64)
    control = _closed_through(through) if closed else _open_with_tangents(through)
    return control, largest_distance(control, through, closed)


def bspline_to_catmull_rom(control: ArrayLike, closed: bool) -> tuple[FloatArray, float]:
    """Return the points of the Catmull-Rom curve through the knots of a B-spline.

    The function is the inverse of ``catmull_rom_to_bspline``.

    Args:
        control: control points, shape (n, 3); n is at least 3 for a closed curve and 4 for an open one.
        closed: whether the curve returns to its first point.

    Returns:
        Points, shape (n, 3), and the largest distance between points of equal parameter on the two curves.
    """
    q = np.asarray(control, dtype=np.float64)
    p = (np.roll(q, 1, axis=0) + 4 * q + np.roll(q, -1, axis=0)) / 6
    if not closed:
        p[0] = p[2] - (q[2] - q[0])
        p[-1] = p[-3] + (q[-1] - q[-3])
    return p, largest_distance(q, p, closed)


def polyline_to_bspline(points: ArrayLike, closed: bool) -> FloatArray:
    """Return the control points of the B-spline through the points of a polyline.

    The curvature at the ends of an open curve is zero.

    Args:
        points: points of the polyline, shape (n, 3); n is at least 3 for a closed curve and 2 for an open one.
        closed: whether the polyline returns to its first point, which is not repeated.

    Returns:
        Control points, shape (n, 3) for a closed curve and (n + 2, 3) for an open one.
    """
    p = np.asarray(points, dtype=np.float64)
    if closed:
        return np.roll(_closed_through(p), 1, axis=0)  # The curve then starts at the first point.
    q = p.copy()  # Without curvature at an end, the control point at the end is the end itself.
    if len(p) > 2:
        right = 6 * p[1:-1]
        right[0] -= p[0]
        right[-1] -= p[-1]
        q[1:-1] = _solve_tridiagonal(_bands(len(p) - 2), right)
    return np.concatenate([2 * q[:1] - q[1:2], q, 2 * q[-1:] - q[-2:-1]])


def largest_distance(control: FloatArray, points: FloatArray, closed: bool) -> float:
    """Return the largest distance between points of equal parameter on a B-spline and a Catmull-Rom curve.

    Args:
        control: control points of the B-spline, shape (n, 3).
        points: points of the Catmull-Rom curve, shape (n, 3).
        closed: whether the curves are closed.
    """
    count = len(points) if closed else len(points) - 3
    window = (np.arange(count)[:, None] + np.arange(4)) % len(points)
    difference = np.einsum("kj,sjd->skd", basis(COMPARED), control[window])
    difference -= np.einsum("kj,sjd->skd", _catmull_rom_basis(COMPARED), points[window])
    return float(np.linalg.norm(difference, axis=2).max())


def _catmull_rom_basis(parameter: FloatArray) -> FloatArray:
    """Return the weights of four successive points at parameters from 0 to 1, shape (parameters, 4)."""
    s = parameter
    weights = [-(s**3) + 2 * s**2 - s, 3 * s**3 - 5 * s**2 + 2, -3 * s**3 + 4 * s**2 + s, s**3 - s**2]
    return np.stack(weights, axis=1) / 2


def _solve_tridiagonal(bands: FloatArray, right: FloatArray) -> FloatArray:
    """Solve a tridiagonal system; its three bands are given as in ``scipy.linalg.solve_banded``."""
    from scipy.linalg import solve_banded  # SciPy is imported here, so that the command line starts fast.

    solution: FloatArray = solve_banded((1, 1), bands, right)
    return solution


def _closed_through(points: FloatArray) -> FloatArray:
    """Solve q_(k-1) + 4 q_k + q_(k+1) = 6 p_k for a closed curve.

    The left side is a circular convolution, so that a Fourier transform solves the system.
    """
    count = len(points)
    wave = np.cos(2 * np.pi * np.arange(count // 2 + 1) / count)
    return np.fft.irfft(np.fft.rfft(points, axis=0) * (6 / (4 + 2 * wave))[:, None], n=count, axis=0)


def _open_with_tangents(points: FloatArray) -> FloatArray:
    """Solve q_(k-1) + 4 q_k + q_(k+1) = 6 p_k for the knots of an open curve.

    The conditions at the start are q_2 - q_0 = p_2 - p_0, and the mirrored condition at the end.
    """
    p = points
    bands = _bands(len(p) - 2)
    bands[0, 1:2] = bands[2, -2:-1] = 2.0  # q_0 is replaced by q_2 - (p_2 - p_0), and the last q correspondingly.
    right = 6 * p[1:-1]
    right[0] += p[2] - p[0]
    right[-1] -= p[-1] - p[-3]
    q = _solve_tridiagonal(bands, right)
    first = q[1] - (p[2] - p[0])
    last = q[-2] + (p[-1] - p[-3])
    return np.concatenate([first[None], q, last[None]])


def _bands(count: int) -> FloatArray:
    """Return the bands of the matrix with 4 on the diagonal and 1 beside it."""
    return np.repeat([[1.0], [4.0], [1.0]], count, axis=1)
