# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conversions between curves: the curves agree at the knots, and each conversion is the inverse of the other."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from stitchmesh.io.yarn_formats.splines import bspline_to_catmull_rom, catmull_rom_to_bspline, polyline_to_bspline
from stitchmesh.yarn import YarnSet

ROUNDING = 1e-13  # A few hundred operations on numbers of size 1 in float64.

CURVES = [(closed, count) for closed, least in ((True, 3), (False, 4)) for count in (least, least + 1, 8, 101)]


def some_points(count: int) -> np.ndarray:
    return np.random.default_rng(count).standard_normal((count, 3))


def knots(control: np.ndarray, closed: bool) -> np.ndarray:
    """Return the starts of the segments of a B-spline, and the end of an open one."""
    return np.concatenate(YarnSet.from_curves([control], closed=[closed], radius=1.0).sampled(1))


@pytest.mark.parametrize(("closed", "count"), CURVES)
def test_bspline_passes_through_the_points_of_a_catmull_rom_curve(closed, count):
    points = some_points(count)
    control, _ = catmull_rom_to_bspline(points, closed)
    expected = np.roll(points, -1, axis=0) if closed else points[1:-1]  # A segment starts at its second control point.
    np.testing.assert_allclose(knots(control, closed), expected, atol=ROUNDING)


@pytest.mark.parametrize(("closed", "count"), CURVES)
def test_each_conversion_is_the_inverse_of_the_other(closed, count):
    points = some_points(count)
    control, there = catmull_rom_to_bspline(points, closed)
    again, back = bspline_to_catmull_rom(control, closed)
    np.testing.assert_allclose(again, points, atol=ROUNDING)
    assert there == pytest.approx(back, rel=1e-9)


@pytest.mark.parametrize("count", [32, 128])
def test_the_returned_error_on_a_circle_is_that_of_theory(count):
    """For a step h on the unit circle, the Catmull-Rom tangent is sin h = h - h^3 / 6, that of the spline h + O(h^5).

    Equal differences d of the end tangents make cubics differ by d s (1 - s) (1 - 2 s), at most d / (6 sqrt 3).
    """
    step = 2 * np.pi / count
    angle = step * np.arange(count)
    error = catmull_rom_to_bspline(np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1), True)[1]
    # The largest of 15 samples is 1 % below the maximum, and the next order of h adds a fraction of h^2 / 20.
    assert error == pytest.approx(step**3 / 6 / (6 * np.sqrt(3)), rel=0.015)


@pytest.mark.parametrize("closed", [True, False])
def test_the_returned_error_is_the_distance_of_the_curves(closed):
    points = some_points(12)
    control, error = catmull_rom_to_bspline(points, closed)
    around = np.concatenate([points[-1:], points, points[:2]]) if closed else points
    hermite = CubicHermiteSpline(np.arange(len(around) - 2), around[1:-1], (around[2:] - around[:-2]) / 2)
    if closed:
        control = np.roll(control, 1, axis=0)  # The first segment then starts at the first point.
    curve = YarnSet.from_curves([control], closed=[closed], radius=1.0).sampled(16)[0]
    distance = np.linalg.norm(curve - hermite(np.arange(len(curve)) / 16), axis=1)
    assert error == pytest.approx(distance.max(), rel=1e-12)


@pytest.mark.parametrize(("closed", "count"), [(True, 3), (True, 10), (False, 2), (False, 3), (False, 4), (False, 30)])
def test_the_points_of_a_polyline_are_on_the_curve(closed, count):
    points = some_points(count)
    np.testing.assert_allclose(knots(polyline_to_bspline(points, closed), closed), points, atol=ROUNDING)


def test_an_open_polyline_ends_without_curvature():
    control = polyline_to_bspline(some_points(7), closed=False)
    np.testing.assert_allclose(control[0] - 2 * control[1] + control[2], 0.0, atol=ROUNDING)
    np.testing.assert_allclose(control[-1] - 2 * control[-2] + control[-3], 0.0, atol=ROUNDING)
