# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation of the periods of a cell: forces on the strains, relaxed states, loads, and held components."""

from __future__ import annotations

from dataclasses import astuple, replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.lattice import Lattice
from stitchmesh.quality import PRESETS
from stitchmesh.simulation.dead_load import Gravity
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns, yarn_energies
from stitchmesh.yarnrelax.cell_stress import cell_stress, cell_stresses
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell
from tests.yarnrelax.stockinette import flat_patch, periodic_patch, woven_cell

KALDOR = YarnMaterial.named("kaldor-simulation")
EXACT = replace(PRESETS["draft"], precision="float64", tolerance=1e-6)


def sheared(yarns: YarnSet, shear: float) -> YarnSet:
    """The yarns and their lattice, sheared along the courses."""
    assert yarns.lattice is not None
    matrix = np.array([[1.0, shear, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    return replace(yarns, points=yarns.points @ matrix.T, lattice=Lattice(yarns.lattice.periods @ matrix.T))


def deformed(yarns: YarnSet, a: float, b: float, c: float) -> YarnSet:
    """The yarns and their lattice after F = ((1 + a, c), (0, 1 + b)), for courses along x."""
    assert yarns.lattice is not None
    matrix = np.array([[1.0 + a, c, 0.0], [0.0, 1.0 + b, 0.0], [0.0, 0.0, 1.0]])
    return replace(yarns, points=yarns.points @ matrix.T, lattice=Lattice(yarns.lattice.periods @ matrix.T))


def strain_forces(yarns: YarnSet) -> np.ndarray:
    """Forces of all energies on the strains [erg]."""
    simulation = YarnSimulation.start(yarns, KALDOR, EXACT, device_named("cpu"), cell=RelaxCell())
    assert simulation.strain is not None
    simulation.assess_cells()
    return np.asarray(simulation.strain.net.numpy()[0])


def test_forces_on_strains_are_minus_the_gradient() -> None:
    yarns = sheared(periodic_patch(1, 1), 0.1)
    counts = {"quadrature_points": EXACT.quadrature_points, "contact_samples": EXACT.contact_samples}
    step = 1e-6  # central differences: truncation error 1e-12, and rounding over the step, 1e-10
    force = strain_forces(yarns)
    for axis in range(3):
        ends = [
            sum(yarn_energies(deformed(yarns, *(side * step * np.eye(3)[axis])), KALDOR, **counts).values())
            for side in (1.0, -1.0)
        ]
        assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(-force[axis], rel=1e-6, abs=1e-6 * np.abs(force).max())


def size_of(yarns: YarnSet) -> tuple[float, float, float]:
    """Length of the first period, and components of the second period across and along the first [cm]."""
    assert yarns.lattice is not None
    first, second = yarns.lattice.periods
    along = first / np.linalg.norm(first)
    return float(np.linalg.norm(first)), float(np.linalg.norm(np.cross(along, second))), float(second @ along)


@pytest.fixture(scope="module")
def at_rest() -> YarnSet:
    """A stitch relaxed in a free cell."""
    result = relax_yarns(periodic_patch(1, 1), material=KALDOR, quality=EXACT, device="cpu", cell=RelaxCell())
    assert result.report["converged"] and result.report["certificate"] == "unchanged"
    return result.yarns


def test_a_free_cell_has_no_stress_at_rest(at_rest: YarnSet) -> None:
    terms = np.abs(strain_forces(replace(at_rest, rest_length=at_rest.lengths))).max()
    # The residual is below its tolerance: 1e-6 of the sum of the magnitudes of all terms. This sum is at most ten times
    # the strain force of the energies without stretch.
    assert np.abs(strain_forces(at_rest)).max() < 1e-5 * max(terms, 1.0)


def test_a_free_cell_equals_its_tiling(at_rest: YarnSet) -> None:
    cell, rows, stitches = RelaxCell(), 2, 1
    tiles = relax_yarns(periodic_patch(rows, stitches), material=KALDOR, quality=EXACT, device="cpu", cell=cell)
    one, many = size_of(at_rest), size_of(tiles.yarns)
    # The tolerance of 1e-6 on forces leaves strains of 1e-6 times the ratio of stretch stiffness to bending stiffness,
    # which is some hundreds.
    assert many[0] / stitches == pytest.approx(one[0], rel=1e-3)
    assert many[1] / rows == pytest.approx(one[1], rel=1e-3)


@pytest.mark.parametrize(
    ("cell", "kept"),
    [(RelaxCell(course=None), (0,)), (RelaxCell(wale=None), (1,)), (RelaxCell(shear=False), (2,))],
)  # fmt: skip
def test_held_components_do_not_change(cell: RelaxCell, kept: tuple[int, ...]) -> None:
    yarns = sheared(periodic_patch(1, 1), 0.05)
    result = relax_yarns(yarns, material=KALDOR, quality=EXACT, device="cpu", cell=cell)
    before, after = np.array(size_of(yarns)), np.array(size_of(result.yarns))
    if 2 in kept:  # the shear angle is kept while the height changes
        before[2] *= after[0] / before[0]
    for axis in range(3):
        moved = abs(after[axis] - before[axis]) / before[0]
        assert moved < 1e-12 if axis in kept else moved > 1e-4  # rounding; a free component does change


@pytest.mark.parametrize("along", ["course", "wale"])
def test_a_load_is_the_derivative_of_the_energy(along: str) -> None:
    """Virtual work: if the length is held, the energy at rest changes by the load times the change of length."""
    load = 200.0
    free, held = (RelaxCell(**{along: value}) for value in (load, None))
    loaded = relax_yarns(periodic_patch(1, 1), material=KALDOR, quality=EXACT, device="cpu", cell=free)
    axis = 0 if along == "course" else 1
    length = size_of(loaded.yarns)[axis]
    step = 2e-3
    ends = []
    for side in (1.0, -1.0):
        strain = [0.0, 0.0, 0.0]
        strain[axis] = side * step
        start = deformed(loaded.yarns, *strain)
        ends.append(relax_yarns(start, material=KALDOR, quality=EXACT, device="cpu", cell=held).report["energy"])
    # truncation error of second order in a step of 2e-3, and an error of 1e-6 in an energy of 100 erg
    assert (ends[0] - ends[1]) / (2 * step * length) == pytest.approx(load, rel=0.01)


def test_new_images_are_found_when_a_cell_shrinks() -> None:
    """In a cell of twice the size, yarns do not touch. When the cell shrinks, they touch and do not interpenetrate."""
    yarns = deformed(woven_cell(), 1.0, 1.0, 0.0)
    shorter = replace(yarns, rest_length=woven_cell().rest_length)
    result = relax_yarns(shorter, material=KALDOR, quality="draft", device="cpu", cell=RelaxCell())
    assert result.report["min_distance_over_radius"] > 1.0
    assert size_of(result.yarns)[0] < 0.75 * size_of(yarns)[0]


def bent(yarns: YarnSet, curvature: float, axis: int) -> YarnSet:
    """Yarns bent around a cylinder, to first order in the curvature."""
    moved = yarns.points.copy()
    moved[:, axis] -= curvature * yarns.points[:, axis] * yarns.points[:, 2]
    moved[:, 2] += curvature * yarns.points[:, axis] ** 2 / 2
    return replace(yarns, points=moved)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"terms": [Gravity()]}, "got Gravity beside it, which does not act"),
        ({"yarns": flat_patch(1, 1)}, "repeat on no lattice"),
        ({"quality": replace(EXACT, solver="dynamics")}, "no mass to relax with"),
    ],
)
def test_options_that_exclude_a_free_cell_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        relax_yarns(**{"yarns": periodic_patch(1, 1), "cell": RelaxCell(), "device": "cpu"} | options)


def test_a_load_that_is_no_number_and_yarns_without_a_lattice_are_refused() -> None:
    with pytest.raises(ParameterError, match="got a load of nan dyn along the courses"):
        RelaxCell(course=float("nan"))
    with pytest.raises(ParameterError, match="repeat on no lattice"):
        cell_stress(flat_patch(2, 2), KALDOR)


@pytest.mark.parametrize("axis", [0, 1])
def test_the_moment_is_the_derivative_of_the_energy(axis: int) -> None:
    """The piece touches none of its images, so that the energy of the bent piece can be computed.

    Contacts are switched off: if control points move along a parabola, the samples between them do not stay on the
    parabola, which changes the energy of yarns that are not in equilibrium.
    """
    piece, alone = flat_patch(3, 3), replace(KALDOR, k_contact=0.0)
    noise = np.random.default_rng(5).normal(scale=0.01, size=piece.points.shape)
    piece = replace(piece, points=piece.points + noise)
    piece = replace(piece, points=piece.points - np.concatenate(piece.sampled(4)).mean(axis=0))
    far = Lattice(np.array([[100.0, 0.0, 0.0], [0.0, 100.0, 0.0]]))
    lone = replace(piece, lattice=far, lattice_step=np.zeros((piece.yarn_count, 2)))
    stress = cell_stress(lone, alone)
    moment = (stress.course_moment, stress.wale_moment)[axis] * far.area
    step = 1e-6  # central differences: errors as in the test of forces on strains
    ends = [sum(yarn_energies(bent(piece, side * step, axis), alone).values()) for side in (1.0, -1.0)]
    assert (ends[1] - ends[0]) / (2 * step) == pytest.approx(moment, rel=1e-5)


def test_the_moment_of_a_contact_is_its_force_times_its_height() -> None:
    """Straight yarns along the wales: two yarns above the middle plane touch, two yarns below it do not."""
    along = np.arange(8)[:, None] * [0.0, 0.1, 0.0]
    places = [[0.0, 0.0, 0.4], [0.2, 0.0, 0.4], [0.0, 0.0, -0.4], [0.6, 0.0, -0.4]]
    rest = [np.full(8, 0.1)] * 4
    yarns = YarnSet.from_curves([along + p for p in places], closed=[True] * 4, radius=0.125, rest_lengths=rest)
    lattice = Lattice(np.array([[2.0, 0.0, 0.0], [0.0, 0.8, 0.0]]))
    stress = cell_stress(replace(yarns, lattice=lattice, lattice_step=np.tile([0, 1], (4, 1))), KALDOR)
    assert stress.course < 0.0
    assert stress.course_moment == pytest.approx(0.4 * stress.course, rel=1e-12)
    assert stress.wale_moment == pytest.approx(0.4 * stress.wale, rel=1e-12)  # contact forces have wale components


def test_stress_is_the_derivative_of_the_energy_and_equal_for_every_tiling() -> None:
    yarns = sheared(periodic_patch(1, 1), 0.1)
    assert yarns.lattice is not None
    found = cell_stress(yarns, KALDOR, quadrature_points=3, contact_samples=3)
    tension = -strain_forces(yarns) / yarns.lattice.area
    assert (found.course, found.wale, found.shear) == pytest.approx(tuple(tension), rel=1e-9)
    tiles = cell_stress(sheared(periodic_patch(2, 3), 0.1), KALDOR, quadrature_points=3, contact_samples=3)
    assert astuple(tiles) == pytest.approx(astuple(found), rel=1e-9, abs=1e-9)  # rounding of sums


def test_the_stress_of_many_cells_is_that_of_each() -> None:
    cells = [sheared(periodic_patch(1, 1), 0.1), woven_cell(), periodic_patch(2, 3)]
    for own, found in zip(cells, cell_stresses([(yarns, KALDOR) for yarns in cells], 3, 3, "cpu"), strict=True):
        alone = cell_stress(own, KALDOR, quadrature_points=3, contact_samples=3, device="cpu")
        assert astuple(found) == pytest.approx(astuple(alone), rel=1e-9, abs=1e-9)  # rounding of sums
