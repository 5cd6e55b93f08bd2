# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Forces are minus the gradients of the energies, and are invariant under translation, rotation and scaling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, yarn_energies, yarn_forces
from tests.yarnrelax.stockinette import flat_patch, shaken, tube

TERMS = {
    "stretch": YarnMaterial(2000.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.006),
    "length": YarnMaterial(0.0, 1000.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.006),
    "bend": YarnMaterial(0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.006),
    "contact": YarnMaterial(0.0, 0.0, 0.0, 3250.0, 0.0, 0.0, 0.0, 0.006),
}
COARSE = {"quadrature_points": 3, "contact_samples": 3}


def shaken_patch() -> YarnSet:
    """Open rows with non-zero forces of every energy term."""
    return shaken(flat_patch(3, 2))


@pytest.mark.parametrize("term", TERMS)
def test_force_is_minus_the_gradient(term: str) -> None:
    yarns, material = shaken_patch(), TERMS[term]
    force = yarn_forces(yarns, material, **COARSE)
    direction = np.random.default_rng(3).normal(size=yarns.points.shape)
    step = 1e-6  # central differences: truncation error 1e-12, rounding error 1e-10 for second derivatives of order 1
    ends = [
        yarn_energies(replace(yarns, points=yarns.points + side * step * direction), material, **COARSE)[term]
        for side in (1, -1)
    ]
    slope = (ends[0] - ends[1]) / (2 * step)
    assert slope == pytest.approx(-(force * direction).sum(), rel=1e-6)


def test_forces_and_torques_sum_to_zero() -> None:
    yarns = shaken_patch()
    force = yarn_forces(yarns, YarnMaterial.named("leaf"))
    size = np.abs(force).sum()
    # float64 rounding of about a hundred terms
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-13 * size)
    np.testing.assert_allclose(np.cross(yarns.points, force).sum(axis=0), 0.0, atol=1e-12 * size)


def test_a_rigid_motion_changes_no_energy_and_rotates_the_forces() -> None:
    yarns, material = shaken_patch(), YarnMaterial.named("leaf")
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    moved = replace(yarns, points=yarns.points @ turn.T + [3.0, -2.0, 1.0])
    before, after = yarn_energies(yarns, material), yarn_energies(moved, material)
    for term, energy in before.items():
        assert after[term] == pytest.approx(energy, rel=1e-10)  # rounding of coordinates of order one
    force = yarn_forces(yarns, material)
    np.testing.assert_allclose(yarn_forces(moved, material), force @ turn.T, atol=1e-9 * np.abs(force).max())


def test_the_radius_similarity_changes_no_energy() -> None:
    yarns, material, gamma = shaken_patch(), YarnMaterial.named("leaf"), 1e3
    yarns = replace(yarns, natural_curvature=np.random.default_rng(8).normal(size=len(yarns.points)))
    scaled = replace(
        yarns, points=gamma * yarns.points, rest_length=gamma * yarns.rest_length, radius=gamma * yarns.radius,
        natural_curvature=yarns.natural_curvature / gamma,
    )  # fmt: skip
    before, after = yarn_energies(yarns, material), yarn_energies(scaled, material.scaled(gamma))
    for term, energy in before.items():
        assert after[term] == pytest.approx(energy, rel=1e-11)  # rounding only: the similarity is exact


def test_single_precision_agrees_with_double() -> None:
    yarns, material = tube(3, 4), YarnMaterial.named("leaf")
    double = yarn_forces(yarns, material, **COARSE)
    single = yarn_forces(yarns, material, precision="float32", **COARSE)
    # Float32 rounds a coordinate of 2 cm to 1e-7 cm, so the strain of a segment of 0.35 cm is known to 5e-7, which
    # k_len / l turns into 6e-3 dyn. Bending forces are fourth differences, and their error is about as large.
    np.testing.assert_allclose(single, double, atol=5e-5 * np.abs(double).max())


def test_a_straight_yarn_of_short_segments_does_not_touch_itself() -> None:
    line = np.stack([np.arange(0.0, 1.0, 0.02), np.zeros(50), np.zeros(50)], axis=1)
    yarns = YarnSet.from_curves([line], closed=[False], radius=0.125)
    assert yarn_energies(yarns, YarnMaterial.named("leaf"))["contact"] == 0.0
