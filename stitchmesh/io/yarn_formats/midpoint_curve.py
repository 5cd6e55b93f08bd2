# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Smooth curves of polylines: quadratic Bezier pieces from the middle of each edge to the middle of the next one.

This is how programs for ``.yarns`` and ``.smobj`` files draw a polyline. An open curve also has the first half of the
first edge and the last half of the last one, so that it begins and ends where the polyline does.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stitchmesh.errors import YarnError
from stitchmesh.io.yarn_formats.splines import polyline_to_bspline
from stitchmesh.mesh import FloatArray

STEPS = 8
"""Samples of each Bezier piece."""
MOST_SAMPLES = 1_000_000
"""Most samples of a yarn; a garment of one yarn has fewer."""
FEWEST = {True: 6, False: 4}
"""Fewest samples of a closed and of an open yarn; a B-spline needs 3 and 4."""


@dataclass(frozen=True, eq=False)
class MidpointCurve:
    """A dense polyline along a curve."""

    points: FloatArray
    """Points [cm], shape (n, 3); a closed curve repeats its first point."""
    corner: FloatArray
    """Place of each corner of the polyline along the points, as an index with a fraction, shape (corners,)."""
    closed: bool
    """Whether the curve is closed."""

    @cached_property
    def arc_length(self) -> FloatArray:
        """Length from the start to each point [cm], shape (n,)."""
        steps = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])


def midpoint_curve(corners: FloatArray, closed: bool) -> MidpointCurve:
    """Return the curve of a polyline.

    Args:
        corners: corners of the polyline [cm], shape (n, 3); n is at least 2. A closed one does not repeat its first.
        closed: whether the last corner is followed by the first one.
    """
    count = len(corners)
    if closed:
        before = (np.roll(corners, 1, axis=0) + corners) / 2
        pieces = _pieces(before, corners, np.roll(before, -1, axis=0))
        points = np.concatenate([pieces.reshape(-1, 3), before[:1]])
        return MidpointCurve(points, np.asarray(STEPS * (np.arange(count) + 0.5), dtype=np.float64), True)
    middle = (corners[:-1] + corners[1:]) / 2
    pieces = _pieces(middle[:-1], corners[1:-1], middle[1:])
    points = np.concatenate([corners[:1], pieces.reshape(-1, 3), middle[-1:], corners[-1:]])
    inner = 1 + STEPS * (np.arange(count - 2) + 0.5)
    return MidpointCurve(points, np.concatenate([[0.0], inner, [len(points) - 1.0]]), False)


def _pieces(first: FloatArray, corner: FloatArray, last: FloatArray) -> FloatArray:
    """Return samples of the Bezier pieces without their last points, shape (pieces, STEPS, 3)."""
    s = (np.arange(STEPS) / STEPS)[None, :, None]
    first, corner, last = (points[:, None, :] for points in (first, corner, last))
    return (1 - s) ** 2 * first + 2 * s * (1 - s) * corner + s**2 * last


def through_samples(curve: MidpointCurve, spacing: float) -> tuple[FloatArray, FloatArray]:
    """Return the B-spline through samples of a curve at equal arc lengths.

    Args:
        curve: the curve.
        spacing: distance of samples [cm].

    Returns:
        Control points [cm], shape (n, 3), and the place of each corner of the polyline in segments from the start.

    Raises:
        YarnError: the curve is too long for the spacing.
    """
    total = float(curve.arc_length[-1])
    if not total <= MOST_SAMPLES * spacing:
        found = f"a yarn of {total:.3g} cm at samples {spacing:.3g} cm apart"
        raise YarnError(f"{found}: more than {MOST_SAMPLES:,} control points; check the coordinates and the radius")
    count = max(FEWEST[curve.closed], round(total / spacing) + (not curve.closed))
    at = np.linspace(0.0, total, count, endpoint=not curve.closed)
    samples = np.stack([np.interp(at, curve.arc_length, axis) for axis in curve.points.T], axis=1)
    segments = count if curve.closed else count - 1
    corners = np.interp(curve.corner, np.arange(len(curve.points)), curve.arc_length) / total * segments
    return polyline_to_bspline(samples, curve.closed), corners


def knots_of_polyline(corners: FloatArray, closed: bool) -> FloatArray:
    """Return the points of the curve of a polyline that are nearest to its corners, one for each corner.

    The curve passes the corner P between its neighbours A and B at (A + 6 P + B) / 8, and begins and ends where an open
    polyline does.

    Args:
        corners: corners of the polyline, shape (n, 3); a closed one repeats its first point, where its curve begins.
        closed: whether the polyline returns to its first point.

    Returns:
        Points, shape (n, 3), or (n - 1, 3) for a closed polyline.
    """
    knots = np.array(corners)
    knots[1:-1] = (corners[:-2] + 6.0 * corners[1:-1] + corners[2:]) / 8.0
    return knots[:-1] if closed else knots


def polyline_of_knots(knots: FloatArray, closed: bool) -> FloatArray:
    """Return the polyline whose curve passes given points; the inverse of ``knots_of_polyline``."""
    from scipy.linalg import solve_banded  # SciPy is imported here, so that the command line starts fast.

    corners = np.concatenate([knots, knots[:1]]) if closed else np.array(knots)
    if len(corners) > 2:
        right = 8.0 * corners[1:-1]
        right[0] -= corners[0]
        right[-1] -= corners[-1]
        corners[1:-1] = solve_banded((1, 1), np.repeat([[1.0], [6.0], [1.0]], len(right), axis=1), right)
    return corners
