# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The plot of the energies and of the residual."""

from __future__ import annotations

from stitchmesh.app.pages.yarns.energy_plot import MOST_POINTS, Assessed, energy_plot


def assessed(count: int, **energies: float) -> list[Assessed]:
    return [Assessed(20 * k, 1.0 / (k + 1), energies or {"bend": 10.0, "contact": 5.0}) for k in range(count)]


def test_before_two_assessments_there_is_no_plot():
    assert energy_plot([], 0.01) is None and energy_plot(assessed(1), 0.01) is None


def test_each_term_has_a_curve_and_so_have_the_residual_and_its_limit():
    figure = energy_plot(assessed(3), 0.01)
    curves = {curve.name: curve for curve in figure.data}
    assert list(curves) == ["bend", "contact", "residual", "at rest"]
    assert list(curves["bend"].y) == [1.0, 1.0, 1.0]  # 10 erg are 1 microjoule
    assert list(curves["residual"].x) == [0, 20, 40] and list(curves["at rest"].y) == [0.01, 0.01]


def test_long_histories_are_thinned_and_keep_their_ends():
    curve = energy_plot(assessed(5000), 0.01).data[0]
    assert len(curve.x) <= MOST_POINTS and (curve.x[0], curve.x[-1]) == (0, 20 * 4999)


def test_energies_without_a_fixed_sign_have_a_linear_axis():
    assert energy_plot(assessed(3), 0.01).layout.yaxis.type == "log"
    assert energy_plot(assessed(3, gravity=-1.0), 0.01).layout.yaxis.type is None


def test_a_term_that_began_later_has_no_energy_before():
    early, late = Assessed(0, 1.0, {"bend": 1.0}), Assessed(20, 0.5, {"bend": 1.0, "friction": 2.0})
    assert list(energy_plot([early, late], 0.01).data[1].y) == [None, 0.2]  # zero has no place on a logarithmic axis
    falling = Assessed(40, 0.5, {"bend": -1.0})
    assert list(energy_plot([early, late, falling], 0.01).data[1].y) == [0.0, 0.2, 0.0]
