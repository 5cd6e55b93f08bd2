# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Curves of stress over strain rise everywhere, and their energy is the integral of the stress."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.triangles.cloth_material import TensionCurve

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


def test_the_stress_is_the_cubic_curve_and_goes_on_as_lines():
    strain = np.linspace(-0.5, 0.5, 300).reshape(3, -1)
    inside = np.clip(strain, -0.3, 0.21)
    expected = CubicHermiteSpline(STEEP.strain, STEEP.stress, STEEP.slope)(inside)
    expected += (strain - inside) * np.where(strain < 0.0, STEEP.slope[0], STEEP.slope[-1])
    np.testing.assert_allclose(STEEP.at(strain), expected, rtol=1e-12, atol=1e-10)
    np.testing.assert_allclose(TensionCurve.linear(50.0).at(strain), 50.0 * strain)


def test_the_difference_of_curves_holds_at_the_strains_of_both():
    line = TensionCurve.through(np.array([-0.1, 0.0, 0.1]), np.array([-0.1, 0.0, 0.1]), "table")
    rest = STEEP.without(line, "difference")
    assert {*STEEP.strain, *line.strain} == {*rest.strain}
    np.testing.assert_allclose(rest.stress, STEEP.at(rest.strain) - rest.strain, rtol=1e-12)
    with pytest.raises(ParameterError, match="difference: point 1 is not above point 0"):
        line.without(STEEP, "difference")
