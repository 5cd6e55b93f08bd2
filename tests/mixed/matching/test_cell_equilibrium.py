# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Equilibria of a cell of a weave against what its model says in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial, FabricMaterials
from stitchmesh.mixed.matching.cell_equilibrium import PARAMETERS, CellShape, CellSolver
from stitchmesh.mixed.matching.yarn_cell import YarnCell, knit_cell, weave_cell

YARN = CrossingMaterial.named("gong-1")
ENDS, PICKS = 4.0, 5.0
PLAIN = [[1, 0], [0, 1]]


@pytest.fixture(scope="module")
def solver() -> CellSolver:
    return CellSolver(weave_cell(PLAIN, ends=ENDS, picks=PICKS, materials=FabricMaterials.of(YARN)))


@pytest.mark.parametrize("strain", [-0.1, 0.02, 0.3])
def test_a_stretched_weave_has_the_tension_of_its_straight_yarns(solver: CellSolver, strain: float) -> None:
    state = solver.equilibrium(CellShape(1.0 + strain, 1.0 + 2.0 * strain))
    expected = np.array([PICKS, 2.0 * ENDS]) * YARN.stretch_stiffness * strain
    assert np.allclose(state.slopes[:2], expected, rtol=1e-10)  # rounding
    energy = YARN.stretch_stiffness * strain**2 * (PICKS + 4.0 * ENDS) / 2.0
    assert state.energy == pytest.approx(energy, rel=1e-10)


def test_planar_yarns_have_no_poisson_effect(solver: CellSolver) -> None:
    state = solver.equilibrium(CellShape(1.1), free=("stretch_wale", "skew"))
    assert abs(state.shape.stretch_wale - 1.0) < 1e-9  # the tolerance of the forces
    assert abs(state.shape.skew) < 1e-9


@pytest.mark.parametrize("angle", [0.02, 0.5])
def test_shear_is_resisted_by_the_four_quadrants_of_each_crossing(solver: CellSolver, angle: float) -> None:
    half = angle / 2.0
    state = solver.equilibrium(CellShape(np.cos(half), np.cos(half), np.sin(half)))
    # 4 * 1/2 k_x L angle^2 for each crossing, with L = (1/ENDS + 1/PICKS) / 2 and ENDS * PICKS crossings for each cm^2
    energy = YARN.shear * YARN.radius**2 * (ENDS + PICKS) * angle**2
    assert state.energy == pytest.approx(energy, rel=1e-9)


@pytest.mark.parametrize(
    ("direction", "per_cm"), [(0.0, PICKS), (np.pi / 2.0, ENDS), (np.pi / 4.0, (ENDS + PICKS) / 4.0)]
)
def test_a_roll_bends_each_yarn(solver: CellSolver, direction: float, per_cm: float) -> None:
    shape = CellShape(curvature=0.1, direction=direction)
    state = solver.equilibrium(shape, free=("stretch_course", "stretch_wale", "skew"))
    # chords turn by 2 asin(kappa L / 2) instead of kappa L: (kappa L)^2 / 24 = 3e-5; and k_s resists the rest
    assert state.slopes[3] == pytest.approx(per_cm * YARN.bending_stiffness * 0.1, rel=2e-3)


def test_a_cylinder_of_chords_of_full_length_is_the_exact_state(solver: CellSolver) -> None:
    state = solver.equilibrium(CellShape(curvature=1.0), free=("stretch_course", "stretch_wale", "skew"))
    turn = 2.0 * np.arcsin(0.5 / ENDS)
    energy = YARN.bending_stiffness * turn**2 / (2.0 / ENDS) * ENDS * PICKS
    # the chords keep a strain of about k_b (kappa L)^2 / (k_s L^2) = 3e-6, which saves that part of the energy
    assert state.energy == pytest.approx(energy, rel=1e-4)
    assert state.shape.stretch_course == pytest.approx(ENDS * turn, rel=1e-5)


def test_slopes_are_derivatives_of_the_energy() -> None:
    material = replace(YARN, contact=1e6)
    solver = CellSolver(
        weave_cell([[1, 1, 0], [0, 1, 1], [1, 0, 1]], ends=8.0, picks=9.0, materials=FabricMaterials.of(material))
    )
    shape, step = CellShape(1.02, 0.97, 0.04, 0.3, 0.6), 1e-4
    state = solver.equilibrium(shape)
    for k, name in enumerate(PARAMETERS):
        after, before = (
            solver.equilibrium(shape.changed(name, sign * step), state.moved).energy for sign in (1.0, -1.0)
        )
        # error of the differences: step^2 times third derivatives, of the order of the moduli
        assert (after - before) / (2.0 * step) == pytest.approx(state.slopes[k], rel=1e-4, abs=1e-4)


def test_the_same_fabric_in_a_larger_repeat_has_the_same_energy(solver: CellSolver) -> None:
    larger = CellSolver(weave_cell(np.tile(PLAIN, (1, 2)), ends=ENDS, picks=PICKS, materials=FabricMaterials.of(YARN)))
    shape = CellShape(1.05, 1.0, 0.1, 0.5, 0.3)
    free = ("stretch_course", "stretch_wale")
    own, other = solver.equilibrium(shape, free=free), larger.equilibrium(shape, free=free)
    assert own.energy == pytest.approx(other.energy, rel=1e-8)  # the tolerance of the forces


def test_a_disturbed_start_ends_in_the_same_state(solver: CellSolver) -> None:
    shape = CellShape(1.1, 1.05)
    start = 0.02 * np.random.default_rng(2).normal(size=(solver.cell.node_count, 5))
    assert solver.equilibrium(shape, start).energy == pytest.approx(solver.equilibrium(shape).energy, rel=1e-8)


def test_an_unknown_parameter_is_refused(solver: CellSolver) -> None:
    with pytest.raises(ParameterError, match="'width'"):
        solver.equilibrium(CellShape(), free=("width",))


def test_a_load_stretches_the_yarns_along_it(solver: CellSolver) -> None:
    load = np.array([300.0, 700.0, 0.0])
    state = solver.equilibrium(CellShape(), free=("stretch_course", "stretch_wale", "skew"), load=load)
    assert np.allclose(state.slopes[:3], load, atol=1e-2)  # the tolerance of the forces, over the size of the cell
    stretch = np.array([state.shape.stretch_course, state.shape.stretch_wale])
    assert np.allclose(stretch, 1.0 + load[:2] / (YARN.stretch_stiffness * np.array([PICKS, ENDS])), rtol=1e-6)


def test_held_nodes_stay_in_their_places(solver: CellSolver) -> None:
    start = 0.01 * np.random.default_rng(5).normal(size=(solver.cell.node_count, 5))
    state = solver.equilibrium(CellShape(1.1), start, held=True)
    assert np.array_equal(state.moved, start)
    assert state.energy > solver.equilibrium(CellShape(1.1), start).energy


@pytest.fixture(scope="module")
def knit() -> YarnCell:
    return knit_cell([[1]], wale_spacing=0.8, course_spacing=0.6, materials=FabricMaterials.of(YARN))


def test_a_stockinette_has_one_node_for_each_quarter_of_a_loop(knit: YarnCell) -> None:
    assert knit.node_count == 4
    assert len(knit.stitches.nodes[knit.stitches.length_stiffness > 0.0]) >= 2


def test_a_stockinette_as_laid_out_has_no_tension_but_curls(knit: YarnCell) -> None:
    state = CellSolver(knit).equilibrium(CellShape())
    assert np.abs(state.slopes[:3]).max() < 1e-6  # rounding of the stretch stiffness; the layout has its rest lengths
    assert state.slopes[3] > 1.0


def test_a_purl_fabric_curls_to_the_other_side(knit: YarnCell) -> None:
    purl = knit_cell([[0]], wale_spacing=0.8, course_spacing=0.6, materials=FabricMaterials.of(YARN))
    one, other = (CellSolver(cell).equilibrium(CellShape()).slopes[3] for cell in (knit, purl))
    assert one == pytest.approx(-other, rel=1e-9)  # rounding


def test_sliding_softens_a_knit(knit: YarnCell) -> None:
    shape = CellShape(1.05)
    slid, stuck = (CellSolver(knit, sliding=sliding).equilibrium(shape) for sliding in (True, False))
    assert np.array_equal(stuck.moved[:, 3:], np.zeros((4, 2)))
    assert slid.energy < stuck.energy
