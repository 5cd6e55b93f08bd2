# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Confinement between two planes: its energy, force and curvature, similarity, and fabrics that do not touch it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.lattice import Lattice
from stitchmesh.periodic.swatch import scale_yarns
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.energies.confinement import (
    CellConfinements,
    Confinement,
    plane_pressure,
)
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell
from stitchmesh.yarnrelax.together.relax_cells import relax_cells
from tests.yarnrelax.one_term import OneTerm, on_device
from tests.yarnrelax.stockinette import flat_patch, periodic_patch, woven_cell

KALDOR = YarnMaterial.named("kaldor-simulation")
EXACT = replace(PRESETS["draft"], precision="float64", tolerance=1e-5)


def line(count: int = 8) -> YarnSet:
    """A straight yarn of rest length ``count`` with one control point for each unit, on a lattice."""
    points = np.zeros((count, 3))
    points[:, 0] = np.arange(count)
    return YarnSet(
        points=points, start=[0, count], closed=[True], radius=[0.5], rest_length=np.ones(count), row=np.zeros(count),
        face=np.zeros(count), part=np.zeros(count), lattice=Lattice(np.array([[count, 0.0, 0.0], [0.0, 4.0, 0.0]])),
        lattice_step=[[1, 0]],
    )  # fmt: skip


@pytest.mark.parametrize("height", [-0.7, 0.1])
def test_a_line_beyond_a_plane(height: float) -> None:
    yarns = line()
    scene = OneTerm.of(on_device(yarns, KALDOR), Confinement(0.3, 2.0))
    moved = yarns.points + np.array([0.0, 0.0, height])  # the planes stay where the yarns were given
    excess = np.sign(height) * max(abs(height) - 0.3, 0.0)
    kappa = 2.0 * KALDOR.k_bend / 0.5**4
    assert scene.energy(moved) == pytest.approx(8 * kappa * excess**2 / 2, rel=1e-13, abs=1e-30)  # eight units long
    assert scene.forces(moved) == pytest.approx(np.tile([0.0, 0.0, -kappa * excess], (8, 1)), rel=1e-13, abs=1e-30)


def test_both_planes_press_with_the_force_of_the_yarns_beyond_them() -> None:
    """A line, one half 0.4 above the middle and the other one as far below, stands 0.1 beyond the planes."""
    flat = line()
    yarns = replace(flat, points=flat.points + np.repeat([0.4, -0.4], 4)[:, None] * np.array([0.0, 0.0, 1.0]))
    kappa = 2.0 * KALDOR.k_bend / 0.5**4
    # each plane carries four units of length on an area of 8 x 4; the middle is a root within 1e-12
    assert plane_pressure(Confinement(0.3, 2.0), yarns, KALDOR) == pytest.approx(kappa * 0.1 * 4 / 32, rel=1e-9)
    assert plane_pressure(Confinement(0.5, 2.0), yarns, KALDOR) == 0.0


def test_force_is_minus_the_gradient_on_a_tilted_lattice() -> None:
    turn = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]
    yarns = periodic_patch(1, 2)
    assert yarns.lattice is not None
    turned = replace(yarns, points=yarns.points @ turn.T, lattice=Lattice(yarns.lattice.periods @ turn.T))
    scene = OneTerm.of(on_device(turned, KALDOR), Confinement(0.05))
    noise = np.random.default_rng(8).normal(size=yarns.points.shape)
    # the energy is piecewise quadratic: only rounding, 1e-16 of an energy over a step of 1e-6 of its size
    assert scene.slope(turned.points, noise, 1e-6) == pytest.approx(-(scene.forces() * noise).sum(), rel=1e-8)


def test_planes_do_not_act_on_the_strains_of_a_cell() -> None:
    yarns = periodic_patch(1, 1)
    assert yarns.lattice is not None
    matrix = np.array([[1.1, 0.2, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 1.0]])
    strained = replace(yarns, points=yarns.points @ matrix.T, lattice=Lattice(yarns.lattice.periods @ matrix.T))
    energy, after = (OneTerm.of(on_device(each, KALDOR), Confinement(0.05)).energy() for each in (yarns, strained))
    assert energy > 0.0
    assert after == pytest.approx(energy, rel=1e-12)  # the heights are equal up to rounding
    simulation = YarnSimulation.start(
        yarns, KALDOR, EXACT, device_named("cpu"), [Confinement(0.05)], cell=RelaxCell()
    )
    without = YarnSimulation.start(yarns, KALDOR, EXACT, device_named("cpu"), cell=RelaxCell())
    simulation.assess_cells(), without.assess_cells()
    assert simulation.strain is not None and without.strain is not None
    np.testing.assert_array_equal(simulation.strain.net.numpy(), without.strain.net.numpy())


def test_similarity_keeps_the_energy() -> None:
    yarns, gamma = periodic_patch(1, 1), 0.3
    energy = OneTerm.of(on_device(yarns, KALDOR), Confinement(0.05)).energy()
    scaled = on_device(scale_yarns(yarns, gamma), KALDOR.scaled(gamma))
    assert OneTerm.of(scaled, Confinement(gamma * 0.05)).energy() == pytest.approx(energy, rel=1e-12)  # rounding


@pytest.mark.parametrize(
    ("values", "message"),
    [((-0.1, 1.0), "half thickness of -0.1"), ((np.nan, 1.0), "half thickness"), ((0.1, 0.0), "stiffness: got 0")],
)
def test_impossible_planes_are_refused(values: tuple[float, float], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        Confinement(*values)


def test_planes_need_a_lattice_and_one_choice_for_each_cell() -> None:
    with pytest.raises(ParameterError, match="needs the yarns of one periodic fabric"):
        Confinement(0.1).on(on_device(flat_patch(1, 2)))
    with pytest.raises(ParameterError, match="planes: got 1 for 2 cells"):
        relax_cells([periodic_patch(1, 1)] * 2, planes=[None], device="cpu")


CELLS = [periodic_patch(1, 1), woven_cell(), periodic_patch(2, 1)]
CHOICES = (Confinement(0.05), None, Confinement(0.02, 3.0))


def test_each_cell_of_a_batch_lies_between_its_own_planes() -> None:
    term = CellConfinements(CHOICES)
    batch = YarnSimulation([(yarns, KALDOR) for yarns in CELLS], EXACT, device_named("cpu"), [term])
    found = batch.assess_cells()
    for yarns, choice, together in zip(CELLS, CHOICES, found, strict=True):
        terms = [] if choice is None else [choice]
        alone = YarnSimulation.start(yarns, KALDOR, EXACT, device_named("cpu"), terms).assess_cells()[0]
        # rounding: the energies of control points are added in another order
        assert together.energies["confinement"] == pytest.approx(alone.energies.get("confinement", 0.0), rel=1e-12)
        assert together.residual == pytest.approx(alone.residual, rel=1e-9)
    assert found[0].energies["confinement"] > 0.0 and found[2].energies["confinement"] > 0.0
