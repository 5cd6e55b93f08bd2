# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Van Wyk's law between yarns: crossing and parallel yarns, the gradient, and cells of both laws together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.quality import PRESETS
from stitchmesh.yarnrelax.model.material import pressure_of_parallel_yarns
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.yarnrelax.stockinette import periodic_patch

RADIUS = 0.125
SOFT = sm.YarnMaterial(0.0, 0.0, 0.0, 3250.0, 0.0, 0.0, 0.0, 0.006, compression="van-wyk")
ARC_LENGTHS = np.arange(-1.2, 1.25, 0.1)


def crossing(angle: float, rho: float) -> sm.YarnSet:
    """Two straight yarns that cross at an angle [degrees]; their axes are rho diameters apart."""
    turn = np.radians(angle)
    along = np.array([[1.0, 0.0, 0.0], [np.cos(turn), np.sin(turn), 0.0]])
    curves = [ARC_LENGTHS[:, None] * each + [0.0, 0.0, height]
              for each, height in zip(along, (0.0, 2 * RADIUS * rho), strict=True)]  # fmt: skip
    return sm.YarnSet.from_curves(curves, closed=[False, False], radius=RADIUS)


@pytest.mark.parametrize("rho", [0.95, 0.8, 0.5, 0.3])
def test_crossing_yarns_press_by_the_integral_of_the_law(rho: float) -> None:
    """4 pi r k rho f(rho) / sin(angle), with f of ``energies.contact``."""
    s = np.sqrt(1.0 - rho**2)
    law = ((np.arccos(rho) + rho * s) / (2.0 * rho**3) - 4.0 * np.arccosh(1.0 / rho) + 3.0 * s) / np.pi
    expected = 4.0 * np.pi * RADIUS * SOFT.k_contact * rho * law / np.sin(np.radians(60.0))
    for precision in ("float64", "float32"):
        force = sm.yarn_forces(crossing(60.0, rho), SOFT, precision=precision, contact_samples=21)
        # the midpoint rule with 42 samples a diameter, over a contact that is a third of a diameter wide at 0.95
        assert force[len(ARC_LENGTHS) :, 2].sum() == pytest.approx(expected, rel=1e-3)


def test_parallel_yarns_follow_van_wyk() -> None:
    """The pressure on their diameter is k / 2r (rho^-3 - 4 + 3 rho); pressed hard, rho goes with p^(-1/3)."""
    curve = np.arange(-2.0, 2.05, 0.1)[:, None] * [1.0, 0.0, 0.0]
    for rho in (0.9, 0.6):
        apart = [0.0, 0.0, 2 * RADIUS * rho]
        yarns = sm.YarnSet.from_curves([curve, curve + apart], closed=[False, False], radius=RADIUS)
        middle = sm.yarn_forces(yarns, SOFT)[len(curve) + len(curve) // 2, 2]  # a control point carries 0.1 cm
        pressure = pressure_of_parallel_yarns(rho, RADIUS, "van-wyk")
        assert pressure * 2 * RADIUS == pytest.approx(rho**-3 - 4.0 + 3.0 * rho)
        # the midpoint rule with 27 samples a diameter
        assert middle / 0.1 == pytest.approx(pressure * 2 * RADIUS * SOFT.k_contact, rel=1e-3)
    low, high = (pressure_of_parallel_yarns(rho, RADIUS, "van-wyk") for rho in (0.02, 0.01))
    assert np.log(2.0) / np.log(high / low) == pytest.approx(1.0 / 3.0, rel=1e-3)


def test_force_is_minus_the_gradient() -> None:
    yarns = crossing(70.0, 0.7)
    noise = np.random.default_rng(2).normal(size=yarns.points.shape)
    step = 1e-7
    ends = [sm.yarn_energies(replace(yarns, points=yarns.points + side * step * noise), SOFT)["contact"]
            for side in (1.0, -1.0)]  # fmt: skip
    # rounding: 1e-16 of an energy of 100 erg over a step of 1e-7 with a slope of 1e4 erg
    assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(-(sm.yarn_forces(yarns, SOFT) * noise).sum(), rel=1e-4)


def test_another_law_keeps_the_transverse_modulus() -> None:
    plain = sm.YarnMaterial.named()
    soft = plain.compressed_by("van-wyk")
    assert soft.transverse_modulus(RADIUS) == pytest.approx(plain.transverse_modulus(RADIUS), rel=1e-12)
    assert soft.compressed_by("stiff").k_contact == pytest.approx(plain.k_contact, rel=1e-12)
    assert soft.scaled(2.0).compression == "van-wyk"
    assert replace(soft, k_contact=0.0).compressed_by("stiff").k_contact == 0.0
    with pytest.raises(ParameterError, match="compression is 'hard'; expected one of stiff, van-wyk"):
        plain.compressed_by("hard")  # type: ignore[arg-type]


def test_cells_of_both_laws_are_relaxed_together() -> None:
    """Each has the forces that it has alone."""
    yarns, plain = periodic_patch(1, 1), sm.YarnMaterial.named()
    thick = yarns.with_radius(1.1 * yarns.radius)  # the loops of the formula hardly touch
    quality, laws = replace(PRESETS["draft"], precision="float64"), (plain, plain.compressed_by("van-wyk"))
    together = YarnSimulation([(thick, law) for law in laws], quality, device_named("cpu")).assess_cells()
    energies = [found.energies["contact"] for found in together]
    assert energies[0] != pytest.approx(energies[1], rel=0.01)
    for law, energy in zip(laws, energies, strict=True):
        alone = YarnSimulation.start(thick, law, quality, device_named("cpu")).assess_cells()[0]
        assert energy == pytest.approx(alone.energies["contact"], rel=1e-12)  # rounding
