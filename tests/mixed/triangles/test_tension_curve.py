# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Curves of stress over strain rise everywhere, and their energy is the integral of the stress."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from stitchmesh.mixed.triangles.tension_curve import TensionCurve

STEEP = TensionCurve.through(
    np.array([-0.3, -0.1, 0.0, 0.02, 0.2, 0.21]), np.array([-30.0, -29.0, 0.0, 500.0, 501.0, 900.0]), "table"
)


def test_the_slope_is_positive_between_points_of_very_different_chords():
    curve = CubicHermiteSpline(STEEP.strain, STEEP.stress, STEEP.slope)
    slopes = curve.derivative()(np.linspace(-0.3, 0.21, 20001))
    assert slopes.min() > 0.0
    assert STEEP.least_slope == pytest.approx(slopes.min(), rel=1e-4)  # a parabola, sampled 20000 times


def test_the_energy_is_the_integral_of_the_stress_from_rest():
    curve = CubicHermiteSpline(STEEP.strain, STEEP.stress, STEEP.slope)
    integrals = [curve.integrate(0.0, strain) for strain in STEEP.strain]
    np.testing.assert_allclose(STEEP.energy, integrals, rtol=1e-12, atol=1e-12)


def test_points_of_a_line_give_the_line():
    line = TensionCurve.through(np.array([-0.1, 0.0, 0.3]), np.array([-5.0, 0.0, 15.0]), "table")
    np.testing.assert_allclose(line.slope, TensionCurve.linear(50.0).slope[0])
    assert line.least_slope == pytest.approx(50.0)
