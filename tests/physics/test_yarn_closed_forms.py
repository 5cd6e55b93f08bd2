# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn energies and forces compared with closed forms.

For crossing and parallel yarns, the reference is the integral of the contact energy k f(d / 2r) over two straight
lines. For the ring and the stretched yarn, it is L eqs 7 and 8 with a constant curvature or a constant strain. Contact
samples are at most 0.1 r apart, so the discretization error is far below the tolerance of one per cent.
"""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, yarn_energies, yarn_forces

RADIUS = 0.125
MATERIAL = YarnMaterial.named("kaldor-simulation")


Vector = tuple[float, float, float]


def straight(direction: Vector, through: Vector, half: float = 1.5) -> np.ndarray:
    """Control points every 0.1 cm along a line."""
    arc_length = np.arange(-half, half + 0.05, 0.1)
    return np.asarray(through) + arc_length[:, None] * np.asarray(direction)


@pytest.mark.parametrize(("angle", "delta"), [(90.0, 0.95), (40.0, 0.5)])
def test_the_contact_force_of_crossing_yarns_equals_the_integral(angle: float, delta: float) -> None:
    """The force is 4 pi r k (1 - delta^2)^2 / delta / sin(angle)."""
    turn = np.radians(angle)
    lower = straight((1.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    upper = straight((np.cos(turn), np.sin(turn), 0.0), (0.03, 0.02, delta * 2 * RADIUS))
    yarns = YarnSet.from_curves([lower, upper], closed=[False, False], radius=RADIUS)
    force = yarn_forces(yarns, MATERIAL)[len(lower) :].sum(axis=0)
    expected = 4 * np.pi * RADIUS * MATERIAL.k_contact * (1 - delta**2) ** 2 / delta / np.sin(turn)
    # f'' is not smooth at d = 1, so the midpoint rule has an error of second order in 0.07 r, largest at delta = 0.95
    np.testing.assert_allclose(force, [0.0, 0.0, expected], rtol=0.01, atol=0.01 * expected)


def test_the_contact_energy_of_parallel_yarns_equals_the_integral() -> None:
    """E / L = 2 r k [(2 / delta) atan(s / delta) + 2 (delta^2 - 2) s + 2/3 s^3] with s = sqrt(1 - delta^2)."""
    delta = 0.8
    lower = straight((1.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    longer = straight((1.0, 0.0, 0.0), (0.0, delta * 2 * RADIUS, 0.0), half=3.0)
    yarns = YarnSet.from_curves([lower, longer], closed=[False, False], radius=RADIUS)
    length = yarns.rest_length[: len(lower) - 3].sum()
    s = np.sqrt(1 - delta**2)
    inside = 2 / delta * np.arctan(s / delta) + 2 * (delta**2 - 2) * s + 2 / 3 * s**3
    expected = 2 * RADIUS * MATERIAL.k_contact * inside * length
    assert yarn_energies(yarns, MATERIAL)["contact"] == pytest.approx(expected, rel=0.01)


def ring(radius: float, points: int) -> YarnSet:
    angle = np.arange(points) / points * 2 * np.pi
    return YarnSet.from_curves(
        [radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)], closed=[True], radius=RADIUS
    )


def test_the_bending_energy_of_a_ring() -> None:
    """E = 2 pi k_bend / R, where R is the radius of the curve; it is smaller than the radius of the control points."""
    yarns = ring(2.0, 40)
    curve_radius = yarns.lengths.sum() / (2 * np.pi)
    energies = yarn_energies(yarns, MATERIAL)
    # the curvature of a spline with 40 segments differs from the circle's by (2 pi / 40)^2 / 12 = 0.2 per cent
    assert energies["bend"] == pytest.approx(2 * np.pi * MATERIAL.k_bend / curve_radius, rel=0.005)
    assert energies["contact"] == 0.0


@pytest.mark.parametrize("stretch", [0.9, 1.1])
def test_the_energy_of_a_uniform_stretch(stretch: float) -> None:
    """The energies are N k_len (1 - lambda)^2 and N k_length (1 - lambda)^2 for a yarn as long as N segments of l0."""
    line = straight((0.0, 1.0, 0.0), (0.0, 0.0, 0.0))
    rest = [np.full(len(line) - 3, 0.1 / stretch)]
    yarns = YarnSet.from_curves([line], closed=[False], radius=0.01, rest_lengths=rest)
    material = YarnMaterial.named("leaf")
    energies = yarn_energies(yarns, material)
    count = yarns.rest_length.sum() / material.segment_length
    # exact for a straight line, except for the rounding of the coordinates
    assert energies["stretch"] == pytest.approx(count * material.k_len * (1 - stretch) ** 2, rel=1e-9)
    assert energies["length"] == pytest.approx(count * material.k_length * (1 - stretch) ** 2, rel=1e-9)
    assert energies["bend"] == pytest.approx(0.0, abs=1e-9)


def test_the_outward_force_of_a_ring() -> None:
    """At rest length 2 pi R0, E = 2 pi R0 k_bend / R^2; the total outward force at R = R0 is 4 pi k_bend / R0^2."""
    yarns = ring(2.0, 60)
    material = YarnMaterial(0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.006)
    outwards = yarns.points / np.linalg.norm(yarns.points, axis=1, keepdims=True)
    push = (yarn_forces(yarns, material) * outwards).sum()
    # the radius of the curve is smaller than that of the control points by (2 pi / 60)^2 / 6 = 0.2 per cent
    assert push == pytest.approx(4 * np.pi * material.k_bend / 2.0**2, rel=0.01)
