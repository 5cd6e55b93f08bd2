# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Products with the exact Hessian are derivatives of the forces; those of Gauss and Newton are never negative."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.lattice import Lattice
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.energies.confinement import Confinement
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.energies.term import TermChoice
from tests.yarnrelax.hessian.dense_matrix import Products, forces_at, points_of, started
from tests.yarnrelax.solvers.test_cell_strain import deformed, sheared
from tests.yarnrelax.stockinette import fabric_of, flat_patch, hopf_link, periodic_patch, tube, woven_cell

KALDOR, LEAF = YarnMaterial.named("kaldor-simulation"), YarnMaterial.named("leaf")
FREE = RelaxCell()


def shaken(yarns: YarnSet, rest: float = 0.95) -> YarnSet:
    """The yarns out of balance, with rest lengths that stretch or compress them."""
    noise = np.random.default_rng(7).normal(scale=0.01, size=yarns.points.shape)
    return replace(yarns, points=yarns.points + noise, rest_length=rest * yarns.rest_length)


def curved(yarns: YarnSet, curvature: float) -> YarnSet:
    return replace(yarns, natural_curvature=np.full(len(yarns.points), curvature))


def of_unequal_radii(yarns: YarnSet) -> YarnSet:
    return replace(yarns, radius=yarns.radius * np.linspace(0.9, 1.2, len(yarns.radius)))


SCENES: dict[str, tuple[YarnSet, YarnMaterial]] = {
    "closed piece": (shaken(tube(2, 4)), LEAF),
    "compressed open piece": (shaken(flat_patch(2, 2), 1.1), KALDOR),
    "sheared cell": (shaken(sheared(periodic_patch(1, 1), 0.1)), KALDOR),
    "two rows": (shaken(periodic_patch(2, 1), 1.05), LEAF),
    "woven": (shaken(sheared(woven_cell(), 0.05)), KALDOR),
    "little natural curvature": (shaken(curved(periodic_patch(1, 1), 0.5)), KALDOR),
    "large natural curvature": (shaken(curved(periodic_patch(1, 1), 30.0)), KALDOR),
    "unequal radii": (shaken(of_unequal_radii(woven_cell())), KALDOR),
    "length penalty alone": (shaken(periodic_patch(1, 1)), YarnMaterial(0.0, 1e4, 0.0, 0.0, 0.0, 0.0, 0.0, 0.006)),
}
CELLS = {name: scene for name, scene in SCENES.items() if scene[0].lattice is not None}


def assert_close(found: np.ndarray, expected: np.ndarray) -> None:
    """Compare with central differences: errors of third order in a step of 1e-6, and rounding over the step."""
    np.testing.assert_allclose(found, expected, atol=2e-7 * np.abs(expected).max())


def derivative_of_forces(
    yarns: YarnSet, material: YarnMaterial, direction: np.ndarray, terms: list[TermChoice] | None = None
) -> np.ndarray:
    """Minus the derivative of the forces along a motion of the control points, shape (N, 3)."""
    simulation, step = started(yarns, material, terms or []), 1e-6
    places = points_of(simulation)
    ends = [forces_at(simulation, places + side * step * direction) for side in (1.0, -1.0)]
    return np.asarray((ends[1] - ends[0]) / (2 * step))


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_the_exact_product_is_the_derivative_of_the_forces(scene: tuple[YarnSet, YarnMaterial]) -> None:
    motion = np.random.default_rng(3).normal(size=scene[0].points.shape)
    assert_close(Products(started(*scene), exact=1.0).of(motion), derivative_of_forces(*scene, motion))


@pytest.mark.parametrize("scene", CELLS.values(), ids=CELLS)
def test_the_product_with_a_strain_is_the_change_of_the_forces_in_the_deformed_cell(
    scene: tuple[YarnSet, YarnMaterial],
) -> None:
    yarns, material = scene
    products, step = Products(started(yarns, material, cell=FREE), exact=1.0), 1e-6
    for strain in np.eye(3):
        ends = []
        for side in (1.0, -1.0):
            other = started(deformed(yarns, *(side * step * strain)), material)
            ends.append(forces_at(other, points_of(other)))
        motion = np.concatenate([np.zeros(yarns.points.shape), strain[None]])
        assert_close(products.of(motion)[:-1], (ends[1] - ends[0]) / (2 * step))


@pytest.mark.parametrize("scene", CELLS.values(), ids=CELLS)
def test_the_product_for_the_strains_is_the_second_derivative_of_the_energy(
    scene: tuple[YarnSet, YarnMaterial],
) -> None:
    """The slope of the energy by a strain is minus the force on the strains, which are relative to the current cell.

    Deformed by a, b or c, the legs and gaps of the first cell are those of the current cell over 1 + a, over 1 + b, or
    without c times their second component (``cell_strain``).
    """
    yarns, material = scene
    products, step = Products(started(yarns, material, cell=FREE), exact=1.0), 1e-5
    for axis, strain in enumerate(np.eye(3)):
        ends = []
        for size in (step, -step):
            other = started(deformed(yarns, *(size * strain)), material, cell=FREE)
            assert other.strain is not None
            other.assess()
            course, wale, shear = other.strain.net.numpy()[0]
            first = {0: course / (1 + size), 1: course, 2: course - size * shear}[axis]
            second, third = {0: (wale, shear), 1: (wale / (1 + size), shear / (1 + size)), 2: (wale, shear)}[axis]
            ends.append(np.array([first, second, third]))
        motion = np.concatenate([np.zeros(yarns.points.shape), strain[None]])
        expected = (ends[1] - ends[0]) / (2 * step)
        # larger than above, because the virial of stretch cancels against that of contact
        np.testing.assert_allclose(products.of(motion)[-1], expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("exact", [0.0, 0.7, 1.0])
@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_the_matrix_is_symmetric_and_that_of_gauss_and_newton_never_negative(
    scene: tuple[YarnSet, YarnMaterial], exact: float
) -> None:
    yarns, material = scene
    cell = FREE if yarns.lattice is not None else None
    matrix = Products(started(yarns, material, cell=cell), exact).matrix()
    largest = np.abs(matrix).max()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-13 * largest)  # rounding of float64 sums
    assert np.abs(matrix - np.diag(np.diag(matrix))).max() > 0.01 * largest
    if exact == 0.0:
        assert np.linalg.eigvalsh(matrix).min() > -1e-12 * largest


def test_the_exact_matrix_is_negative_somewhere_where_yarns_are_compressed() -> None:
    """Otherwise the test before this one would say nothing about the matrix of Gauss and Newton."""
    matrix = Products(started(*SCENES["compressed open piece"]), exact=1.0).matrix()
    assert np.linalg.eigvalsh(matrix).min() < -1e-3 * np.abs(matrix).max()


def test_both_matrices_are_equal_for_straight_yarn_with_its_rest_length() -> None:
    line = np.arange(8)[:, None] * [0.1, 0.0, 0.0]
    yarns = YarnSet.from_curves([line], closed=[False], radius=0.125)
    yarns = replace(yarns, rest_length=yarns.lengths)
    ends = [Products(started(yarns, LEAF), exact).matrix() for exact in (0.0, 1.0)]
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-12 * np.abs(ends[1]).max())


def test_a_motion_of_the_piece_as_a_whole_has_no_product() -> None:
    yarns, material = SCENES["closed piece"]
    products = Products(started(yarns, material), exact=0.0)
    shift = np.tile([0.3, -0.2, 0.5], (len(yarns.points), 1))
    largest = np.abs(products.of(np.random.default_rng(1).normal(size=shift.shape))).max()
    np.testing.assert_allclose(products.of(shift), 0.0, atol=1e-12 * largest)


@pytest.mark.parametrize("exact", [0.0, 1.0])
@pytest.mark.parametrize("basis", [[[1, 0], [1, 1]], [[1, 0], [-2, 1]]])
def test_the_choice_of_periods_does_not_change_the_product(basis: list[list[int]], exact: float) -> None:
    yarns, material = SCENES["sheared cell"]
    assert yarns.lattice is not None
    periods = Lattice(np.array(basis) @ yarns.lattice.periods)
    motion = np.random.default_rng(3).normal(size=(len(yarns.points) + 1, 3))
    one = Products(started(yarns, material, cell=FREE), exact).of(motion)
    other = Products(started(replace(yarns, lattice=periods), material, cell=FREE), exact).of(motion)
    np.testing.assert_allclose(other, one, atol=1e-12 * np.abs(one).max())  # rounding


def test_the_image_in_which_a_yarn_is_written_does_not_change_the_product() -> None:
    yarns, material = SCENES["two rows"]
    assert yarns.lattice is not None
    yarn = np.repeat(np.arange(yarns.yarn_count), np.diff(yarns.start))
    moved = replace(yarns, points=yarns.points + np.array([[0, 0], [2, -1]])[yarn] @ yarns.lattice.periods)
    motion = np.random.default_rng(3).normal(size=(len(yarns.points) + 1, 3))
    one, other = (Products(started(each, material, cell=FREE), 0.5).of(motion) for each in (yarns, moved))
    np.testing.assert_allclose(other, one, atol=1e-10 * np.abs(one).max())  # coordinates are larger


def test_pairs_that_do_not_touch_have_no_product() -> None:
    """Two linked rings that are apart; a motion of one of them against the other changes no energy."""
    yarns = hopf_link(1.0)
    motion = np.zeros(yarns.points.shape)
    motion[24:] = [0.1, 0.2, 0.3]
    product = Products(started(yarns, LEAF), exact=1.0).of(motion)
    np.testing.assert_allclose(product, 0.0, atol=1e-12 * LEAF.k_contact)


TERMS: dict[str, tuple[YarnSet, list[TermChoice]]] = {
    "shape below and above its threshold": (flat_patch(7, 8), [KeepShape(fabric_of(7, 8, closed=False))]),
    "confinement": (periodic_patch(2, 2), [Confinement(0.1)]),
}


@pytest.mark.parametrize("scene", TERMS.values(), ids=TERMS)
def test_the_products_of_terms_are_derivatives_of_their_forces(scene: tuple[YarnSet, list[TermChoice]]) -> None:
    yarns, terms = scene
    random = np.random.default_rng(5)
    lift = np.linspace(0.0, 0.5, len(yarns.points))[:, None] * [0.0, 0.0, 1.0] * (yarns.lattice is None)
    places = random.normal(scale=0.02, size=yarns.points.shape) + lift
    motion = random.normal(size=yarns.points.shape)
    ends = []
    for choices in (terms, []):
        simulation = started(yarns, LEAF, choices)
        moved = points_of(simulation) + places / simulation.model.cells[0].unit
        step = 1e-6
        force = [forces_at(simulation, moved + side * step * motion) for side in (1.0, -1.0)]
        simulation.state.points.assign(moved)
        ends.append((Products(simulation, exact=1.0).of(motion), (force[1] - force[0]) / (2 * step)))
    (product, derivative), (without, derivative_without) = ends
    assert np.abs(product - without).max() > 0.0
    difference = derivative - derivative_without
    # rounding of all forces over the step
    np.testing.assert_allclose(product - without, difference, atol=1e-6 * np.abs(derivative).max())
    np.testing.assert_allclose(product - without, difference, atol=1e-3 * np.abs(difference).max())
