# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn with natural curvature: its bending energy, the gradient of this energy, and the arc that it relaxes to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import YarnError
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet, basis_derivative
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns, yarn_energies, yarn_forces

K_BEND = 5.0
BENDING = YarnMaterial(0.0, 0.0, K_BEND, 0.0, 0.0, 0.0, 0.0, 0.006)
LEAF = YarnMaterial.named("leaf")
COARSE = {"quadrature_points": 3, "contact_samples": 3}


def ring(radius: float, points: int, curvature: float) -> YarnSet:
    """A ring whose curve (not its control polygon) has the given radius, with an error of (2 pi / points)^4."""
    angle = np.arange(points) / points * 2 * np.pi
    outside = radius * 3 / (2 + np.cos(2 * np.pi / points))
    circle = outside * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    yarns = YarnSet.from_curves([circle], closed=[True], radius=0.125)
    return replace(yarns, natural_curvature=np.full(points, curvature))


def shaken() -> YarnSet:
    """An open and a closed yarn with random bends.

    Their natural curvatures have both signs and are smaller or larger than the curvatures of the curves.
    """
    rng = np.random.default_rng(5)
    line = np.stack([np.arange(14.0), np.zeros(14), np.zeros(14)], axis=1) * 0.3
    curves = [line, line[:9] + np.array([0.0, 5.0, 0.0])]
    yarns = YarnSet.from_curves(curves, closed=[False, True], radius=0.05)
    points = yarns.points + rng.normal(scale=0.06, size=yarns.points.shape)
    return replace(yarns, points=points, natural_curvature=rng.normal(scale=4.0, size=len(points)))


def curvatures(yarns: YarnSet) -> np.ndarray:
    """Curvature [1/cm] at the first knot of each segment."""
    corners = yarns.points[yarns.segment_points]
    along = np.einsum("j,sjd->sd", basis_derivative(0.0)[0], corners)
    turn = corners[:, 0] - 2 * corners[:, 1] + corners[:, 2]
    return np.linalg.norm(np.cross(along, turn), axis=1) / np.linalg.norm(along, axis=1) ** 3


def bend_energy(yarns: YarnSet) -> float:
    return yarn_energies(yarns, BENDING, **COARSE)["bend"]


def test_the_force_is_minus_the_gradient() -> None:
    yarns = shaken()
    size = np.abs(yarns.natural_curvature[1:-1]).mean() / curvatures(yarns).mean()
    assert 0.25 < size < 4.0  # both pieces of the energy occur: nearly straight, and bent
    force, step = yarn_forces(yarns, BENDING, **COARSE), 1e-6
    direction = np.random.default_rng(3).normal(size=yarns.points.shape)
    ends = [bend_energy(replace(yarns, points=yarns.points + side * step * direction)) for side in (1, -1)]
    # central differences: the truncation error is 1e-12 and the rounding error 1e-10 for second derivatives of order 1
    assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(-(force * direction).sum(), rel=1e-6)


@pytest.mark.parametrize("natural", [0.2, 1.9])
def test_the_energy_of_a_ring_is_the_square_of_the_difference_of_curvatures(natural: float) -> None:
    """E = 2 pi R k_bend (1 / R - k)^2. The sign of k does not matter."""
    radius = 2.0
    expected = 2 * np.pi * radius * K_BEND * (1 / radius - natural) ** 2
    # The curvature of the spline differs from the circle's by (2 pi / 60)^2 / 12 = 0.1 %, which is at most 2 % of the
    # difference of curvatures.
    for side in (1, -1):
        assert bend_energy(ring(radius, 60, side * natural)) == pytest.approx(expected, rel=0.02)


def test_nearly_straight_yarn_has_the_energy_of_the_parabola() -> None:
    """The energy density is (1 - q) k^2 - (1 / q - 1) kappa^2 with q = 1/4, for kappa below q k."""
    radius, part = 2.0, 0.2
    natural = 1 / (part * radius)
    expected = 2 * np.pi * radius * K_BEND * (0.75 * natural**2 - 3 / radius**2)
    assert bend_energy(ring(radius, 60, natural)) == pytest.approx(expected, rel=0.002)  # spline error 0.1 %


def test_energy_and_force_are_continuous_at_a_quarter() -> None:
    """Energies and forces at natural curvatures 1e-6 below and above the switch at q = 1/4 agree."""
    near = [ring(2.0, 60, 2.0 * (1 + side * 1e-6)) for side in (-1, 1)]
    bends = [yarn_forces(yarns, BENDING, **COARSE) for yarns in near]
    # The two pieces of the energy meet at this curvature: one ring is computed with one piece, the other ring with the
    # other piece.
    assert bend_energy(near[0]) == pytest.approx(bend_energy(near[1]), rel=1e-5)
    np.testing.assert_allclose(bends[0], bends[1], atol=1e-4 * np.abs(bends[0]).max())


def test_an_open_yarn_relaxes_to_an_arc_with_its_natural_curvature() -> None:
    count, natural = 20, 0.6
    angle = 0.12 * np.arange(count)  # half the natural curvature: a straighter yarn could bend to both sides
    arc = np.stack([np.sin(angle), 1 - np.cos(angle), 0 * angle], axis=1) * (0.4 / 0.12)
    yarns = YarnSet.from_curves([arc], closed=[False], radius=0.05)
    yarns = replace(yarns, natural_curvature=np.full(count, natural))
    quality = replace(PRESETS["reference"], **COARSE, tolerance=1e-6)
    rest = relax_yarns(yarns, material=LEAF, quality=quality, device="cpu")
    assert rest.report["converged"]
    # the curvature of a spline with segments of 0.4 cm differs from the circle's by (0.6 * 0.4)^2 / 12 = 0.5 %
    np.testing.assert_allclose(curvatures(rest.yarns), natural, rtol=0.01)
    np.testing.assert_allclose(rest.yarns.strain, 0.0, atol=1e-4)


def test_the_sign_of_the_natural_curvature_does_not_matter() -> None:
    yarns = shaken()
    other = replace(yarns, natural_curvature=-yarns.natural_curvature)
    forces = [yarn_forces(each, LEAF, **COARSE) for each in (yarns, other)]
    np.testing.assert_array_equal(*forces)


@pytest.mark.parametrize(
    ("natural", "message"),
    [
        (np.ones(3), r"natural_curvature: got shape \(3,\); expected \(23,\)"),
        (np.append(np.nan, np.ones(22)), "natural_curvature 0: got nan; expected finite numbers in 1/cm"),
    ],
)
def test_bad_natural_curvatures_are_refused(natural: np.ndarray, message: str) -> None:
    with pytest.raises(YarnError, match=message):
        replace(shaken(), natural_curvature=natural)
