# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The sparse matrix is the derivative of the forces on control points and on the strains of cells."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.sparse import csc_array

from stitchmesh.compute.device import device_named
from stitchmesh.simulation.pair_lists import allocate_lists
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.assembled_hessian import HessianAssembly
from stitchmesh.yarnrelax.collision.step_limit import STRAIN_UNIT
from stitchmesh.yarnrelax.energies.confinement import Confinement
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.hessian import matrix_pattern, touching_segments
from stitchmesh.yarnrelax.renewal import renew_lagging
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.yarnrelax.hessian.scenes import (
    DOUBLE,
    FREE,
    KALDOR,
    SCENES,
    Scene,
    assembled_hessian,
    assert_close,
    forces_at,
    points_of,
    started,
)
from tests.yarnrelax.solvers.test_cell_strain import sheared
from tests.yarnrelax.stockinette import flat_patch, periodic_patch, shaken


def thicker(yarns: YarnSet) -> YarnSet:
    """Shaken yarns of larger radius: the loops of the formula hardly touch."""
    return shaken(yarns.with_radius(1.1 * yarns.radius), 1.0)


Moving = tuple[YarnSet, YarnMaterial, list[YarnChoice], RelaxCell | None]
FRICTION: dict[str, Moving] = {
    "open piece": (thicker(flat_patch(2, 2)), KALDOR, [Friction(0.3)], None),
    "periods that stay": (thicker(periodic_patch(1, 1)), KALDOR, [Friction((0.5, 0.2))], None),
    "free cell": (thicker(sheared(periodic_patch(1, 1), 0.1)), KALDOR, [Friction((0.2, 0.5))], FREE),
    "free cell between planes": (thicker(periodic_patch(2, 1)), KALDOR, [Friction(0.3), Confinement(0.1)], FREE),
}
MOVING: dict[str, Moving] = {
    name: (yarns, material, [], None if yarns.lattice is None else FREE) for name, (yarns, material) in SCENES.items()
} | {f"{name} with friction": scene for name, scene in FRICTION.items()}


def slid(yarns: YarnSet, material: YarnMaterial, terms: list[YarnChoice], cell: RelaxCell | None) -> YarnSimulation:
    """Yarns that have moved since their friction was renewed, so that some pairs stick and others slide."""
    simulation = started(yarns, material, terms, cell=cell)
    moved = np.random.default_rng(11).normal(scale=0.04, size=yarns.points.shape)
    forces_at(simulation, points_of(simulation) + moved)
    return simulation


@dataclass(frozen=True)
class Deformation:
    """A state of a simulation, and forces after motions u and strains E of it: places x are at (I + E) (x + u).

    Candidate lists, normal forces of friction and anchors stay.
    """

    simulation: YarnSimulation
    points: np.ndarray
    periods: np.ndarray

    @classmethod
    def of(cls, simulation: YarnSimulation) -> Deformation:
        on_lattice = simulation.model.on_lattice
        periods = simulation.model.constants.images.periods.numpy().copy() if on_lattice else np.zeros((2, 3))
        return cls(simulation, points_of(simulation), periods)

    def forces(self, motion: np.ndarray) -> np.ndarray:
        """Minus the derivatives of the energy by u and E, for coordinates of the solver, shape (3 E,) to (3 E,)."""
        simulation, count = self.simulation, len(self.points)
        moves = motion.reshape(-1, 3)
        state, f = simulation.state, np.eye(3)
        a, b, c = np.zeros(3)
        if simulation.strain is not None:
            a, b, c = moves[count] / float(STRAIN_UNIT)
            e1, e2 = simulation.strain.host_frame[0]
            f += a * np.outer(e1, e1) + b * np.outer(e2, e2) + c * np.outer(e1, e2)
            simulation.model.constants.images.periods.assign(self.periods @ f.T)
        force = forces_at(simulation, (self.points + moves[:count]) @ f.T) @ f
        if simulation.strain is None:
            return force.ravel()
        course, wale, shear = (state.segment_virial.numpy().sum(axis=0) + state.sample_virial.numpy().sum(axis=0))[:3]
        shear = shear / (1 + b)  # of the legs and gaps before the strain
        strains = np.array([(course - c * shear) / (1 + a), wale / (1 + b), shear])
        return np.append(force, strains / float(STRAIN_UNIT))

    def derivative(self, direction: np.ndarray, step: float) -> np.ndarray:
        """Second derivative of the energy along a direction."""
        ends = [self.forces(side * step * direction) for side in (1.0, -1.0)]
        self.forces(np.zeros_like(direction))
        return np.asarray((ends[1] - ends[0]) / (2 * step))


@pytest.mark.parametrize(
    "scene",
    [
        pytest.param(scene, id=name, marks=[pytest.mark.nightly] if name == "periods that stay with friction" else [])
        for name, scene in MOVING.items()
    ],
)
def test_it_is_the_derivative_of_all_forces(scene: Moving) -> None:
    """Its rows of points and of strains times a motion of both, and times motions of the strains alone."""
    yarns, _material, _terms, cell = scene
    simulation = slid(*scene)
    found = assembled_hessian(simulation)
    deformation, size, count = Deformation.of(simulation), found.shape[0], 3 * len(yarns.points)
    for direction in [np.random.default_rng(3).normal(size=size), *np.eye(size)[count:]]:
        # Second derivatives of friction are continuous also at full slip and without slip, where the third one steps;
        # no pair of these states is within 1e-6 of either.
        product, expected = found @ direction, deformation.derivative(direction, 1e-6)
        assert_close(product[:count], expected[:count])
        if cell is not None:
            assert_close(product[count:], expected[count:])


def assert_canonical(matrix: csc_array) -> None:
    """Check that rows ascend in each column and that the matrix equals its transpose to the last bit."""
    copy = csc_array((matrix.data, matrix.indices.copy(), matrix.indptr.copy()), shape=matrix.shape)
    assert copy.has_canonical_format
    assert (matrix != matrix.T).nnz == 0


def test_the_matrix_of_a_batch_has_the_matrices_of_its_cells_as_blocks() -> None:
    given = [(thicker(periodic_patch(1, 1)), KALDOR), (thicker(periodic_patch(2, 1)), KALDOR.scaled(1.5))]
    moved = [np.random.default_rng(k).normal(scale=0.04, size=yarns.points.shape) for k, (yarns, _) in enumerate(given)]

    def matrix_of(cells: list[Scene], moves: list[np.ndarray]) -> tuple[YarnSimulation, csc_array]:
        simulation = YarnSimulation(cells, DOUBLE, device_named("cpu"), [Friction(0.3)], cells=[FREE] * len(cells))
        forces_at(simulation, points_of(simulation) + np.concatenate(moves))
        return simulation, assembled_hessian(simulation)

    batch, whole = matrix_of(given, moved)
    assert_canonical(whole)
    own_entries = 0
    for number in range(2):
        _alone, own = matrix_of(given[number : number + 1], moved[number : number + 1])
        entries = np.arange(*batch.model.point_start[number : number + 2])
        entries = np.append(entries, batch.model.point_count + number)
        rows = (3 * entries[:, None] + np.arange(3)).ravel()
        found = whole[rows][:, rows]
        # the table of images is another one, and with it the order of sums
        np.testing.assert_allclose(found.toarray(), own.toarray(), atol=1e-13 * np.abs(own).max())
        own_entries += own.nnz
    assert whole.nnz == own_entries


def test_places_are_found_again_when_other_segments_touch_only() -> None:
    simulation = slid(*FRICTION["open piece"])
    assembly = HessianAssembly(simulation)
    first = assembly.matrix()
    points = points_of(simulation)
    for size, same in ((1e-6, True), (0.3, False)):
        forces_at(simulation, points + np.random.default_rng(2).normal(scale=size, size=points.shape))
        kept, anew = assembly.matrix(), assembled_hessian(simulation)
        assert np.shares_memory(kept.indices, first.indices) == same
        for name in ("data", "indices", "indptr"):
            np.testing.assert_array_equal(getattr(kept, name), getattr(anew, name))
        assert np.abs(kept.data).max() > 0.0 and not np.shares_memory(kept.data, first.data)
    assert kept.nnz != first.nnz
    np.testing.assert_array_equal(assembly.matrix(forces_are_found=True).data, kept.data)


def test_longer_candidate_lists_and_new_contacts_of_friction_are_taken_over() -> None:
    """A simulation replaces these arrays while its assembly is kept."""
    simulation = slid(*FRICTION["free cell"])
    assembly = HessianAssembly(simulation)
    assembly.matrix()
    model, capacity = simulation.model, simulation.candidates.lists.shape[1] + 8
    simulation.candidates.lists = allocate_lists(model.sample_count, capacity, model.device)
    simulation.search.generation += 1
    simulation.search_contacts()
    renew_lagging(simulation, np.ones(1, dtype=bool))
    kept, anew = assembly.matrix(), assembled_hessian(simulation)
    np.testing.assert_array_equal(kept.toarray(), anew.toarray())


def test_lists_without_room_are_made_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = slid(*FRICTION["free cell"])
    expected = assembled_hessian(simulation).toarray()
    monkeypatch.setattr(touching_segments, "CAPACITY", 1)
    monkeypatch.setattr(matrix_pattern, "CAPACITY", 1)
    np.testing.assert_array_equal(assembled_hessian(simulation).toarray(), expected)


def test_single_precision_gives_nearly_the_same_matrix() -> None:
    yarns, material, terms, cell = FRICTION["free cell"]
    double = slid(yarns, material, terms, cell)
    single = YarnSimulation.start(
        yarns, material, replace(DOUBLE, precision="float32"), device_named("cpu"), terms, cell=cell
    )
    forces_at(single, points_of(double))
    found, expected = assembled_hessian(single).toarray(), assembled_hessian(double).toarray()
    # Coordinates of ten units are rounded at 1e-6, which a slip of 0.05 units makes 2e-5 of the stiffness.
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())
    assert_canonical(assembled_hessian(single))
