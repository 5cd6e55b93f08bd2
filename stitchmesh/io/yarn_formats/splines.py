# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cubic B-splines from and to the other curves that yarn files hold.

A Catmull-Rom curve passes through its points p with the tangent (p_(k+1) - p_(k-1)) / 2 in p_k; a cubic B-spline of
control points q passes through (q_(k-1) + 4 q_k + q_(k+1)) / 6. The two agree in the points and differ between them,
the first having continuous tangents and the second continuous curvature.

An open curve of n points runs from the second to the last but one: its end points only set the end tangents,
(p_2 - p_0) / 2 for the one and (q_2 - q_0) / 2 for the other, and equal end tangents make the conversion one to one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.mesh import FloatArray
from stitchmesh.yarn import basis

COMPARED = np.arange(1, 16) / 16
"""Parameters within a segment at which two curves are compared."""


def catmull_rom_to_bspline(points: ArrayLike, closed: bool) -> tuple[FloatArray, float]:
    """Control points of the B-spline through the points of a Catmull-Rom curve.

    Args:
        points: shape (n, 3); n is at least 3 for a closed curve and 4 for an open one.
        closed: whether the curve returns to its first point.

    Returns:
        Control points, shape (n, 3), and the largest distance between points of equal parameter on the two curves.
    """
    through = np.asarray(points, dtype=np.float64)
    control = _closed_through(through) if closed else _open_with_tangents(through)
    return control, largest_distance(control, through, closed)


def bspline_to_catmull_rom(control: ArrayLike, closed: bool) -> tuple[FloatArray, float]:
    """Points of the Catmull-Rom curve through the knots of a B-spline: ``catmull_rom_to_bspline`` backwards.

    Args:
        control: shape (n, 3); n is at least 3 for a closed curve and 4 for an open one.
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
    """Control points of the B-spline through the corners of a polyline, straight at the ends of an open one.

    Args:
        points: shape (n, 3); n is at least 3 for a closed curve and 2 for an open one.
        closed: whether the polyline returns to its first point, which is not repeated.

    Returns:
        Control points, shape (n, 3) for a closed curve and (n + 2, 3) for an open one.
    """
    p = np.asarray(points, dtype=np.float64)
    if closed:
        return np.roll(_closed_through(p), 1, axis=0)  # so that the curve starts at the first corner
    q = p.copy()  # no curvature at the ends puts the control point there on the end itself
    if len(p) > 2:
        right = 6 * p[1:-1]
        right[0] -= p[0]
        right[-1] -= p[-1]
        q[1:-1] = _solve_tridiagonal(_bands(len(p) - 2), right)
    return np.concatenate([2 * q[:1] - q[1:2], q, 2 * q[-1:] - q[-2:-1]])


def largest_distance(control: FloatArray, points: FloatArray, closed: bool) -> float:
    """Largest distance between points of equal parameter on a B-spline and a Catmull-Rom curve."""
    count = len(points) if closed else len(points) - 3
    window = (np.arange(count)[:, None] + np.arange(4)) % len(points)
    difference = np.einsum("kj,sjd->skd", basis(COMPARED), control[window])
    difference -= np.einsum("kj,sjd->skd", _catmull_rom_basis(COMPARED), points[window])
    return float(np.linalg.norm(difference, axis=2).max())


def _catmull_rom_basis(parameter: FloatArray) -> FloatArray:
    s = parameter
    weights = [-(s**3) + 2 * s**2 - s, 3 * s**3 - 5 * s**2 + 2, -3 * s**3 + 4 * s**2 + s, s**3 - s**2]
    return np.stack(weights, axis=1) / 2


def _solve_tridiagonal(bands: FloatArray, right: FloatArray) -> FloatArray:
    """Solution of a tridiagonal system, its three bands as in ``scipy.linalg.solve_banded``."""
    from scipy.linalg import solve_banded  # SciPy is imported here, so that the command line starts fast

    solution: FloatArray = solve_banded((1, 1), bands, right)
    return solution


def _closed_through(points: FloatArray) -> FloatArray:
    """Solve q_(k-1) + 4 q_k + q_(k+1) = 6 p_k around the curve: a convolution, undone by Fourier transform."""
    count = len(points)
    wave = np.cos(2 * np.pi * np.arange(count // 2 + 1) / count)
    return np.fft.irfft(np.fft.rfft(points, axis=0) * (6 / (4 + 2 * wave))[:, None], n=count, axis=0)


def _open_with_tangents(points: FloatArray) -> FloatArray:
    """Solve the same for the knots of an open curve, with q_2 - q_0 = p_2 - p_0 and its mirror image at the ends."""
    p = points
    bands = _bands(len(p) - 2)
    bands[0, 1:2] = bands[2, -2:-1] = 2.0  # q_0 is replaced by q_2 - (p_2 - p_0), the last likewise
    right = 6 * p[1:-1]
    right[0] += p[2] - p[0]
    right[-1] -= p[-1] - p[-3]
    q = _solve_tridiagonal(bands, right)
    first = q[1] - (p[2] - p[0])
    last = q[-2] + (p[-1] - p[-3])
    return np.concatenate([first[None], q, last[None]])


def _bands(count: int) -> FloatArray:
    return np.repeat([[1.0], [4.0], [1.0]], count, axis=1)
