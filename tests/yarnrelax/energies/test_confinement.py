# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Confinement between two planes: its energy, force and curvature, similarity, and fabrics that do not touch it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import scalar_named
from stitchmesh.errors import ParameterError
from stitchmesh.lattice import Lattice
from stitchmesh.periodic.swatch import scale_yarns
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.collision.narrow_phase import make_candidates
from stitchmesh.yarnrelax.energies import evaluation
from stitchmesh.yarnrelax.energies.confinement import (
    STIFFNESS,
    CellConfinements,
    Confinement,
    confinement_curvature,
    confinement_force,
    excess_height,
    height_of_middle,
    plane_pressure,
)
from stitchmesh.yarnrelax.model.cells import PeriodicCell
from stitchmesh.yarnrelax.model.state import make_state
from stitchmesh.yarnrelax.model.upload import put_model
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell
from stitchmesh.yarnrelax.together.relax_cells import relax_cells
from tests.yarnrelax.stockinette import flat_patch, periodic_patch, woven_cell

KALDOR = YarnMaterial.named("kaldor-simulation")
EXACT = replace(PRESETS["draft"], precision="float64", tolerance=1e-5)


def confined(
    yarns: YarnSet, choice: Confinement, moved: np.ndarray | None = None, *, material: YarnMaterial = KALDOR,
    precision: str = "float64",
) -> tuple[float, np.ndarray]:  # fmt: skip
    """Energy [erg] and forces [dyn] of the planes alone, beside ``yarns``, on control points ``moved``."""
    model = put_model(
        yarns, material, quadrature_points=3, contact_samples=2, scalar=scalar_named(precision),
        device=device_named("cpu"),
    )  # fmt: skip
    state, candidates, term = make_state(model, external=True), make_candidates(model, 1e-4), choice.on(model)
    if moved is not None:
        state.points.assign(model.to_device(moved))
    term.forces(state, candidates, model.launch)
    evaluation.gather_launch(model, state, model.empty(model.point_count), model.launch)
    return term.energy(state, candidates), state.force.numpy().astype(np.float64) / model.unit


def line(count: int = 8) -> YarnSet:
    """A straight yarn of rest length ``count`` with one control point for each unit, on a lattice."""
    points = np.zeros((count, 3))
    points[:, 0] = np.arange(count)
    return YarnSet(
        points=points, start=[0, count], closed=[True], radius=[0.5], rest_length=np.ones(count), row=np.zeros(count),
        face=np.zeros(count), part=np.zeros(count), lattice=Lattice(np.array([[count, 0.0, 0.0], [0.0, 4.0, 0.0]])),
        lattice_step=[[1, 0]],
    )  # fmt: skip


@pytest.mark.parametrize(("precision", "accuracy"), [("float64", 1e-13), ("float32", 1e-5)])
@pytest.mark.parametrize("height", [-0.7, 0.1, 0.9])
def test_a_line_beyond_a_plane(height: float, precision: str, accuracy: float) -> None:
    yarns = line()
    energy, force = confined(
        yarns, Confinement(0.3, 2.0), yarns.points + np.array([0.0, 0.0, height]), precision=precision
    )  # the planes stay where the yarns were given
    excess = np.sign(height) * max(abs(height) - 0.3, 0.0)
    kappa = 2.0 * KALDOR.k_bend / 0.5**4
    assert energy == pytest.approx(8 * kappa * excess**2 / 2, rel=accuracy, abs=1e-30)  # eight units of length
    assert force == pytest.approx(np.tile([0.0, 0.0, -kappa * excess], (8, 1)), rel=accuracy, abs=1e-30)


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
    choice, noise = Confinement(0.05), np.random.default_rng(8).normal(size=yarns.points.shape)
    force, step = confined(turned, choice)[1], 1e-6
    ends = [confined(turned, choice, turned.points + side * step * noise)[0] for side in (1.0, -1.0)]
    # the energy is piecewise quadratic: only rounding, 1e-16 of an energy over a step of 1e-6 of its size
    assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(-(force * noise).sum(), rel=1e-8)


@kernel
def heights_to_derivatives(
    # model
    half: wp.float64,
    stiffness: wp.float64,
    # state in
    points: wp.array[wp.vec3d],
    # state out
    derivatives: wp.array2d[wp.float64],
) -> None:
    """Force and second derivative of the energy of each place over the plane z = 0."""
    i = wp.tid()
    zero, one = wp.float64(0.0), wp.float64(1.0)
    excess = excess_height(points[i], wp.vec3d(zero, zero, one), half)
    derivatives[i, 0] = confinement_force(excess, stiffness)
    derivatives[i, 1] = confinement_curvature(excess, stiffness)


def test_the_curvature_is_minus_the_slope_of_the_force() -> None:
    step, heights = 1e-6, np.array([-2.0, -1.1, -0.9, 0.0, 0.4, 1.3])
    places = np.zeros((len(heights), 3, 3))
    places[:, :, 2] = heights[:, None] + step * np.array([-1.0, 0.0, 1.0])
    found = wp.zeros((places.size // 3, 2), dtype=wp.float64, device="cpu")
    points = wp.array(places.reshape(-1, 3), dtype=wp.vec3d, device="cpu")
    wp.launch(heights_to_derivatives, len(points), [wp.float64(1.0), wp.float64(3.0), points], [found], device="cpu")
    force, curvature = found.numpy().reshape(len(heights), 3, 2).transpose(2, 0, 1)
    # the force is piecewise linear, so that only rounding remains: 1e-16 over 1e-6
    assert -(force[:, 2] - force[:, 0]) / (2 * step) == pytest.approx(curvature[:, 1], abs=1e-8)


def test_planes_do_not_act_on_the_strains_of_a_cell() -> None:
    yarns = periodic_patch(1, 1)
    assert yarns.lattice is not None
    matrix = np.array([[1.1, 0.2, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 1.0]])
    strained = replace(yarns, points=yarns.points @ matrix.T, lattice=Lattice(yarns.lattice.periods @ matrix.T))
    energy = confined(yarns, Confinement(0.05))[0]
    assert energy > 0.0
    # the heights, and so the energy, are equal up to rounding
    assert confined(strained, Confinement(0.05))[0] == pytest.approx(energy, rel=1e-12)
    simulation = YarnSimulation.start(
        yarns, KALDOR, EXACT, device_named("cpu"), [Confinement(0.05)], cell=RelaxCell()
    )
    without = YarnSimulation.start(yarns, KALDOR, EXACT, device_named("cpu"), cell=RelaxCell())
    simulation.assess_cells(), without.assess_cells()
    assert simulation.strain is not None and without.strain is not None
    np.testing.assert_array_equal(simulation.strain.net.numpy(), without.strain.net.numpy())


@pytest.mark.parametrize("gamma", [0.3, 4.0])
def test_similarity_keeps_the_energy(gamma: float) -> None:
    yarns = periodic_patch(1, 1)
    energy = confined(yarns, Confinement(0.05))[0]
    scaled = confined(scale_yarns(yarns, gamma), Confinement(gamma * 0.05), material=KALDOR.scaled(gamma))[0]
    assert scaled == pytest.approx(energy, rel=1e-12)  # rounding


def test_a_fabric_that_does_not_touch_the_planes_rests_as_without_them() -> None:
    yarns, cell = periodic_patch(1, 1), RelaxCell(shear=False)
    apart = relax_yarns(yarns, material=KALDOR, quality=EXACT, device="cpu", cell=cell, terms=[Confinement(10.0)])
    alone = relax_yarns(yarns, material=KALDOR, quality=EXACT, device="cpu", cell=cell)
    assert apart.report["energies"].pop("confinement") == 0.0
    assert alone.yarns.lattice is not None and apart.yarns.lattice is not None
    # the same iterations in other launches, which differ by rounding; the tolerance of forces is 1e-5
    assert apart.yarns.lattice.periods == pytest.approx(alone.yarns.lattice.periods, rel=1e-3, abs=1e-9)


def test_a_fabric_is_pressed_flat() -> None:
    yarns, cell = periodic_patch(1, 1), RelaxCell(shear=False)
    heights = []
    for stiffness in (STIFFNESS, 100 * STIFFNESS):
        rest = relax_yarns(
            yarns, material=KALDOR, quality=EXACT, device="cpu", cell=cell, terms=[Confinement(0.0, stiffness)]
        )
        assert rest.report["converged"] and rest.report["energies"]["confinement"] > 0.0
        heights.append(np.ptp(rest.yarns.points[:, 2]))
    free = relax_yarns(yarns, material=KALDOR, quality=EXACT, device="cpu", cell=cell)
    assert heights[1] < heights[0] < np.ptp(free.yarns.points[:, 2])


@pytest.mark.parametrize(
    ("values", "message"),
    [((-0.1, 1.0), "half thickness of -0.1"), ((np.nan, 1.0), "half thickness"), ((0.1, 0.0), "stiffness: got 0")],
)
def test_impossible_planes_are_refused(values: tuple[float, float], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        Confinement(*values)


def test_planes_need_a_lattice() -> None:
    with pytest.raises(ParameterError, match="needs the yarns of one periodic fabric"):
        confined(flat_patch(1, 2), Confinement(0.1))


CELLS = [periodic_patch(1, 1), woven_cell(), periodic_patch(2, 1)]
CHOICES = (Confinement(0.05), None, Confinement(0.02, 3.0))


def test_each_cell_of_a_batch_lies_between_its_own_planes() -> None:
    term = CellConfinements(CHOICES, (None,) * 3)
    batch = YarnSimulation([(yarns, KALDOR) for yarns in CELLS], EXACT, device_named("cpu"), [term])
    found = batch.assess_cells()
    for yarns, choice, together in zip(CELLS, CHOICES, found, strict=True):
        terms = [] if choice is None else [choice]
        alone = YarnSimulation.start(yarns, KALDOR, EXACT, device_named("cpu"), terms).assess_cells()[0]
        # rounding: the energies of control points are added in another order
        assert together.energies["confinement"] == pytest.approx(alone.energies.get("confinement", 0.0), rel=1e-12)
        assert together.residual == pytest.approx(alone.residual, rel=1e-9)
    assert found[0].energies["confinement"] > 0.0 and found[2].energies["confinement"] > 0.0


def test_planes_stay_where_they_were_when_a_cell_begins_again_from_another_state() -> None:
    yarns = periodic_patch(1, 1)
    height = height_of_middle(PeriodicCell(yarns, KALDOR))
    noise = 0.02 * np.random.default_rng(3).normal(size=yarns.points.shape)
    moved = replace(yarns, points=yarns.points + noise + np.array([0.0, 0.0, 0.04]))
    expected = confined(yarns, CHOICES[0], moved.points)[0]
    term = CellConfinements(CHOICES[:1], (height,))
    again = YarnSimulation.start(moved, KALDOR, EXACT, device_named("cpu"), [term]).assess_cells()[0]
    assert again.energies["confinement"] == pytest.approx(expected, rel=1e-12)  # rounding
    without = CellConfinements(CHOICES[:1], (None,))
    other = YarnSimulation.start(moved, KALDOR, EXACT, device_named("cpu"), [without]).assess_cells()[0]
    assert other.energies["confinement"] != pytest.approx(expected, rel=1e-2)


def test_a_batch_between_planes_rests_as_each_cell_alone() -> None:
    planes, cell = [Confinement(0.0), Confinement(0.0, 10.0)], RelaxCell(shear=False)
    cells = [periodic_patch(1, 1), periodic_patch(1, 2)]
    batch = relax_cells(cells, materials=[KALDOR] * 2, free=[cell] * 2, planes=planes, quality=EXACT, device="cpu")
    assert batch.report["converged"] == 2
    for yarns, choice, relaxed in zip(cells, planes, batch.cells, strict=True):
        alone = relax_yarns(yarns, material=KALDOR, quality=EXACT, device="cpu", cell=cell, terms=[choice])
        # candidate lists are made at other iterations; at rest energies differ by the square of the tolerance
        assert relaxed.report["energy"] == pytest.approx(alone.report["energy"], rel=1e-6)
        together, apart = relaxed.report["energies"]["confinement"], alone.report["energies"]["confinement"]
        assert together == pytest.approx(apart, rel=1e-2) and together > 0.0


def test_one_choice_of_planes_for_each_cell() -> None:
    with pytest.raises(ParameterError, match="planes: got 1 for 2 cells"):
        relax_cells(CELLS[:2], planes=[None], device="cpu")
