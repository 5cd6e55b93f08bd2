# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Shapes of a cell of a fabric, and its equilibria against what its model says in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial, FabricMaterials
from stitchmesh.mixed.matching.cell_equilibrium import (
    PARAMETERS,
    CellShape,
    CellSolver,
    place_nodes,
    shape_derivatives,
    turned_back,
)
from stitchmesh.mixed.matching.yarn_cell import YarnCell, knit_cell, weave_cell

YARN = CrossingMaterial.named("gong-1")
ENDS, PICKS = 4.0, 5.0
PLAIN = [[1, 0], [0, 1]]


@pytest.fixture(scope="module")
def solver() -> CellSolver:
    return CellSolver(weave_cell(PLAIN, ends=ENDS, picks=PICKS, materials=FabricMaterials.of(YARN)))


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


RANDOM = np.random.default_rng(4)
FLAT, MOVED = RANDOM.normal(size=(7, 2)), 0.1 * RANDOM.normal(size=(7, 3))
ROLLED = CellShape(1.1, 0.9, 0.05, 0.6, 0.4)


def test_a_flat_shape_is_affine() -> None:
    shape = CellShape(1.2, 0.8, 0.1)
    expected = np.column_stack([FLAT @ [[1.2, 0.1], [0.1, 0.8]], np.zeros(7)]) + MOVED
    assert np.abs(place_nodes(shape, FLAT, MOVED) - expected).max() < 1e-15  # rounding of sums of numbers near 1


@pytest.mark.parametrize("direction", [0.0, 0.7])
def test_a_roll_keeps_lengths_and_has_its_radius(direction: float) -> None:
    shape = CellShape(curvature=0.5, direction=direction)
    along = np.array([np.cos(direction), np.sin(direction)])
    places = place_nodes(shape, np.linspace(0.0, 3.0, 2000)[:, None] * along, np.zeros((2000, 3)))
    length = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
    assert abs(length - 3.0) < 1e-6  # chords of 1.5 mm on a radius of 2 cm are short by 2e-8 of their length
    assert np.abs(np.linalg.norm(places - [0.0, 0.0, 2.0], axis=1) - 2.0).max() < 1e-14


def test_derivatives_are_those_of_differences() -> None:
    found, step = shape_derivatives(ROLLED, FLAT, MOVED), 1e-6
    for k, name in enumerate(PARAMETERS):
        after, before = (place_nodes(ROLLED.changed(name, sign * step), FLAT, MOVED) for sign in (1.0, -1.0))
        # error of the differences: step^2 times third derivatives, and 1e-16 / step of rounding
        assert np.abs((after - before) / (2.0 * step) - found[k]).max() < 1e-8


def test_forces_turn_back_as_displacements_turn() -> None:
    push, change = RANDOM.normal(size=(7, 3)), RANDOM.normal(size=(7, 3))
    moved = place_nodes(ROLLED, FLAT, MOVED + change) - place_nodes(ROLLED, FLAT, MOVED)
    assert abs((push * moved).sum() - (turned_back(ROLLED, FLAT, push) * change).sum()) < 1e-13  # rounding


def test_the_mass_is_that_of_yarns_at_their_distances() -> None:
    twill = [[1, 1, 0, 0], [0, 1, 1, 0], [0, 0, 1, 1], [1, 0, 0, 1]]
    cell = weave_cell(twill, ends=4.0, picks=5.0, materials=FabricMaterials.of(YARN))
    assert cell.density == pytest.approx(9.0 * YARN.density, rel=1e-12)  # rounding; 9 cm of yarn for each cm^2


def test_elements_weigh_one_for_each_copy_in_the_repeat() -> None:
    cell = weave_cell(PLAIN, ends=4.0, picks=4.0, materials=FabricMaterials.of(YARN))
    # one segment along each yarn and one bend of each yarn for each of the four nodes; sums of thirds
    assert cell.elements.stretch.sum() == pytest.approx(8.0 * YARN.stretch_stiffness, rel=1e-12)
    assert cell.elements.bending.sum() == pytest.approx(8.0 * YARN.bending_stiffness, rel=1e-12)


def test_a_density_that_is_not_positive_is_refused() -> None:
    with pytest.raises(ParameterError, match="picks: got nan; expected a positive number"):
        weave_cell(PLAIN, ends=4.0, picks=np.nan, materials=FabricMaterials.of(YARN))
