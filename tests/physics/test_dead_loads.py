# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Gravity and point loads: their energies, forces, weights and masses, and what they refuse."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.lattice import Lattice
from stitchmesh.simulation.dead_load import EARTH, Gravity
from stitchmesh.simulation.wind import Wind
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.energies.point_load import PointLoad
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.model.material import point_masses
from tests.yarnrelax.one_term import OneTerm, on_device

LEAF = YarnMaterial.named("leaf")
FALL = -EARTH[1]


def wavy_yarns() -> YarnSet:
    """A closed and an open yarn with uneven rest lengths; the seed is fixed."""
    noise = np.random.default_rng(5)
    curves = [noise.normal(size=(9, 3)), noise.normal(size=(7, 3)) + 5.0]
    rest_lengths = [noise.uniform(0.5, 1.5, 9), noise.uniform(0.5, 1.5, 4)]
    return YarnSet.from_curves(curves, closed=[True, False], radius=0.01, rest_lengths=rest_lengths)


@pytest.mark.parametrize(
    "choice",
    [Gravity((100.0, -981.0, 30.0)), PointLoad((100.0, -9.0, 30.0), [2, 11, 4]), Wind((500.0, -90.0, 30.0))],
    ids=["gravity", "point", "wind"],
)
def test_force_is_minus_the_gradient(choice: YarnChoice) -> None:
    yarns = wavy_yarns()
    scene = OneTerm.of(on_device(yarns), choice)
    direction = np.random.default_rng(3).normal(size=yarns.points.shape)
    # The energy is linear in the points, so the only error is rounding: 1e-16 of energies whose difference is of
    # about their own size.
    assert scene.slope(yarns.points, direction, 0.5) == pytest.approx(-(scene.forces() * direction).sum(), rel=1e-13)


def test_the_forces_of_gravity_sum_to_the_weight() -> None:
    yarns = wavy_yarns()
    weight = LEAF.mass_per_length * yarns.rest_length.sum() * FALL
    # rounding of the masses and of a sum of a dozen terms
    force = OneTerm.of(on_device(yarns), Gravity()).forces()
    np.testing.assert_allclose(force.sum(axis=0), [0.0, -weight, 0.0], rtol=1e-14)


def test_a_stated_mass_goes_before_that_of_the_material() -> None:
    """The first yarn states three times the mass of the material, the second one states none."""
    yarns, usual = wavy_yarns(), LEAF.mass_per_length
    yarns = replace(yarns, radius=[0.01, 0.03], mass_per_length=[3.0 * usual, np.nan])
    mass = point_masses(on_device(yarns))
    own = np.bincount(yarns.segment_yarn, yarns.rest_length) * [3.0 * usual, usual]
    # rounding of a sum of a dozen terms
    assert np.bincount(yarns.point_yarn, mass) == pytest.approx(own, rel=1e-14)


def test_a_periodic_cell_weighs_as_much_as_its_yarn() -> None:
    points = np.arange(4)[:, None] * [1.0, 0.0, 0.0]
    lattice = Lattice(np.array([[4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]))
    loop = YarnSet.from_curves([points], closed=[True], radius=0.1, rest_lengths=[np.ones(4)])
    force = OneTerm.of(on_device(replace(loop, lattice=lattice, lattice_step=[[1, 0]])), Gravity()).forces()
    assert force[:, 1] == pytest.approx(-LEAF.mass_per_length * FALL, rel=1e-14)


def test_a_point_load_is_divided_equally_among_its_points() -> None:
    force = OneTerm.of(on_device(wavy_yarns()), PointLoad((6.0, 0.0, -3.0), [2, 11, 4])).forces()
    expected = np.zeros_like(force)
    expected[[2, 4, 11]] = [2.0, 0.0, -1.0]
    np.testing.assert_allclose(force, expected, rtol=1e-15, atol=1e-15)  # rounding of the division


@pytest.mark.parametrize("numbers", [(0.0, -981.0), (0.0, np.nan, 0.0), 981.0])
def test_a_vector_must_be_three_finite_numbers(numbers: Any) -> None:
    with pytest.raises(ParameterError, match="acceleration"):
        Gravity(numbers)
    with pytest.raises(ParameterError, match=r"point load: got force .* expected three finite numbers"):
        PointLoad(numbers)


@pytest.mark.parametrize(
    ("terms", "message"),
    [
        ([PointLoad((1.0, 0.0, 0.0), [0, 16])], "point load: got control point 16; expected 0 to 15"),
        ([PointLoad((1.0, 0.0, 0.0), faces=[2])], "point load: got stitch face 2; no control point came from it"),
        ([PointLoad((1.0, 0.0, 0.0))], "point load: got neither control points nor stitch faces"),
        ([Gravity()], "mass_per_length"),
    ],
)
def test_bad_loads_are_refused(terms: list[YarnChoice], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        relax_yarns(wavy_yarns(), material=replace(LEAF, mass_per_length=0.0), device="cpu", terms=terms)
