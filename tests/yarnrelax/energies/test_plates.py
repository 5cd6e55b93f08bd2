# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Plates that squeeze a fabric: the force of parallel yarns, and its energy and curvature."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.lattice import Lattice
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.energies.plates import Plates, plates_pressure
from stitchmesh.yarnrelax.model.material import Compression, pressure_of_parallel_yarns
from tests.yarnrelax.one_term import OneTerm, on_device
from tests.yarnrelax.stockinette import flat_patch, periodic_patch

KALDOR = YarnMaterial.named("kaldor-simulation")
LAWS: tuple[Compression, ...] = ("stiff", "van-wyk")


def lines(rho: float) -> YarnSet:
    """Two straight yarns, one above the other, whose axes are 2 - rho radii from the plate at 2 radii: four diameters
    of yarn each, on a lattice."""
    points = np.zeros((8, 3))
    points[:4, 0] = points[4:, 0] = np.arange(4)
    points[:, 2] = np.repeat([-1.0, 1.0], 4) * (2.0 - rho) * 0.5
    return YarnSet(
        points=points, start=[0, 4, 8], closed=[True] * 2, radius=[0.5] * 2, rest_length=np.ones(8), row=np.zeros(8),
        face=np.zeros(8), part=np.zeros(8), lattice=Lattice(np.array([[4.0, 0.0, 0.0], [0.0, 8.0, 0.0]])),
        lattice_step=[[1, 0], [1, 0]],
    )  # fmt: skip


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("rho", [0.95, 0.5])
def test_a_plate_presses_like_a_mirrored_yarn(law: Compression, rho: float) -> None:
    yarns, material = lines(rho), replace(KALDOR, compression=law)
    force = pressure_of_parallel_yarns(rho, 0.5, law) * material.k_contact * 1.0  # over a diameter of 1 cm
    scene = OneTerm.of(on_device(yarns, material), Plates(2.0))
    np.testing.assert_allclose(scene.forces()[4:], np.tile([0.0, 0.0, -force], (4, 1)), rtol=1e-12)  # rounding
    # 4 cm of yarn press on each plate, whose area is 4 cm x 8 cm
    assert plates_pressure(2.0, yarns, material) == pytest.approx(force * 4.0 / 32.0, rel=1e-12)


@pytest.mark.parametrize("law", LAWS)
def test_force_and_curvature_are_derivatives_of_the_energy(law: Compression) -> None:
    yarns = periodic_patch(1, 2)
    scene = OneTerm.of(on_device(yarns, replace(KALDOR, compression=law)), Plates(0.45))
    noise = np.random.default_rng(8).normal(size=yarns.points.shape)
    assert np.abs(scene.forces()).max() > 0.0
    # truncation error: 1e-12 over a squared height of 0.1 radii
    assert scene.slope(yarns.points, noise, 1e-6) == pytest.approx(-(scene.forces() * noise).sum(), rel=1e-6)
    step = 1e-6
    change = (scene.forces(yarns.points + step * noise) - scene.forces(yarns.points - step * noise)) / (2 * step)
    scene.forces()
    blocks = scene.term.point_blocks(scene.state).numpy() / scene.model.unit**2
    expected = -np.einsum("nij,nj->ni", blocks, noise)
    np.testing.assert_allclose(change, expected, rtol=1e-5, atol=1e-5 * np.abs(change).max())


def test_impossible_plates_are_refused() -> None:
    with pytest.raises(ParameterError, match="plates: distance: got 0"):
        Plates(0.0)
    with pytest.raises(ParameterError, match="plates: need the yarns of one periodic fabric"):
        Plates(0.5).on(on_device(flat_patch(1, 2)))
    with pytest.raises(ParameterError, match="plates: got a material of k_contact 0"):
        Plates(0.5).on(on_device(periodic_patch(1, 1), replace(KALDOR, k_contact=0.0)))
