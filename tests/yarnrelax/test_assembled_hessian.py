# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The sparse matrix is the derivative of the forces on control points and on the strains of cells."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.sparse import csc_array

from stitchmesh.compute.device import device_named
from stitchmesh.lattice import lattice_frame
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell
from stitchmesh.yarnrelax.assembled_hessian import HessianAssembly
from stitchmesh.yarnrelax.collision.broad_phase import allocate_lists
from stitchmesh.yarnrelax.collision.budget import STRAIN_UNIT
from stitchmesh.yarnrelax.energies.confinement import Confinement
from stitchmesh.yarnrelax.energies.term import TermChoice
from stitchmesh.yarnrelax.friction.friction import Friction, FrictionTerm
from stitchmesh.yarnrelax.hessian import matrix_pattern, touching_segments
from stitchmesh.yarnrelax.renewal import renew_lagging
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.yarnrelax.hessian.scenes import (
    CELLS,
    DOUBLE,
    FREE,
    KALDOR,
    LEAF,
    SCENES,
    Scene,
    assembled_hessian,
    assert_close,
    derivative_of_forces,
    forces_at,
    of_unequal_radii,
    points_of,
    shaken,
    started,
)
from tests.yarnrelax.solvers.test_cell_strain import deformed, sheared
from tests.yarnrelax.stockinette import flat_patch, hopf_link, periodic_patch, woven_cell


def thicker(yarns: YarnSet) -> YarnSet:
    """Shaken yarns of larger radius: the loops of the formula hardly touch."""
    return shaken(yarns.with_radius(1.1 * yarns.radius), 1.0)


FRICTION: dict[str, tuple[YarnSet, list[TermChoice], RelaxCell | None]] = {
    "open piece": (thicker(flat_patch(2, 2)), [Friction(0.3)], None),
    "periods that stay": (thicker(periodic_patch(1, 1)), [Friction((0.5, 0.2))], None),
    "free cell": (thicker(sheared(periodic_patch(1, 1), 0.1)), [Friction((0.2, 0.5))], FREE),
    "free cell of two rows between planes": (thicker(periodic_patch(2, 1)), [Friction(0.3), Confinement(0.1)], FREE),
    "free woven cell of unequal radii": (thicker(of_unequal_radii(woven_cell())), [Friction(0.3)], FREE),
}


def slid(yarns: YarnSet, terms: list[TermChoice], cell: RelaxCell | None) -> YarnSimulation:
    """Yarns that have moved since their friction was renewed, so that some pairs stick and others slide."""
    simulation = started(yarns, KALDOR, terms, cell=cell)
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


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_it_is_the_derivative_of_the_forces(scene: Scene) -> None:
    simulation = started(*scene)
    motion = np.random.default_rng(3).normal(size=scene[0].points.shape)
    found = assembled_hessian(simulation) @ motion.ravel()
    assert_close(found.reshape(-1, 3), derivative_of_forces(simulation, motion))


@pytest.mark.parametrize("scene", CELLS.values(), ids=CELLS)
def test_its_block_of_the_strains_is_the_second_derivative_of_the_energy(scene: Scene) -> None:
    """The slope of the energy by a strain is minus the force on the strains, which are relative to the current cell.

    Deformed by a, b or c, the legs and gaps of the first cell are those of the current cell over 1 + a, over 1 + b, or
    without c times their second component (``cell_strain``).
    """
    yarns, material = scene
    found, step = assembled_hessian(started(yarns, material, cell=FREE)).toarray()[-3:, -3:], 1e-5
    for axis, strain in enumerate(np.eye(3)):
        ends = []
        for size in (step, -step):
            other = started(deformed(yarns, *(size * strain)), material, cell=FREE)
            assert other.strain is not None
            other.assess_cells()
            course, wale, shear = other.strain.net.numpy()[0]
            first = {0: course / (1 + size), 1: course, 2: course - size * shear}[axis]
            second, third = {0: (wale, shear), 1: (wale / (1 + size), shear / (1 + size)), 2: (wale, shear)}[axis]
            ends.append(np.array([first, second, third]))
        expected = (ends[1] - ends[0]) / (2 * step) / float(STRAIN_UNIT) ** 2
        # larger than elsewhere, because the virial of stretch cancels against that of contact
        np.testing.assert_allclose(found[axis], expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("scene", CELLS.values(), ids=CELLS)
def test_its_border_is_the_derivative_of_the_forces_on_points_that_move_before_the_cell_deforms(scene: Scene) -> None:
    """The energy of points (I + E) (x + u) has the derivative (I + E)^T g by u, with the gradient g there."""
    yarns, material = scene
    assert yarns.lattice is not None
    count = 3 * len(yarns.points)
    border = assembled_hessian(started(yarns, material, cell=FREE)).toarray()[:count, count:] * float(STRAIN_UNIT)
    e1, e2, _normal = lattice_frame(yarns.lattice.periods)
    step = 1e-6
    for column, matrix in enumerate((np.outer(e1, e1), np.outer(e2, e2), np.outer(e1, e2))):
        ends = []
        for side in (1.0, -1.0):
            other = started(deformed(yarns, *(side * step * np.eye(3)[column])), material)
            ends.append(forces_at(other, points_of(other)) @ (np.eye(3) + side * step * matrix))
        assert_close(border[:, column], ((ends[1] - ends[0]) / (2 * step)).ravel())


def test_planes_add_blocks_at_the_points_beyond_them() -> None:
    ends = []
    for terms in ([Confinement(0.1)], []):
        simulation = started(shaken(periodic_patch(2, 2)), LEAF, terms)
        motion = np.random.default_rng(5).normal(size=(simulation.model.point_count, 3))
        matrix = assembled_hessian(simulation)
        ends.append((matrix, (matrix @ motion.ravel()).reshape(-1, 3), derivative_of_forces(simulation, motion)))
    (matrix, product, derivative), (without, product_without, derivative_without) = ends
    added = derivative - derivative_without
    # rounding of all forces over the step
    np.testing.assert_allclose(product - product_without, added, atol=2e-7 * np.abs(derivative).max())
    row, column = (matrix - without).nonzero()
    assert len(row) > 0 and np.array_equal(row // 3, column // 3)
    assert np.array_equal(np.unique(row // 3), np.flatnonzero(added.any(axis=1)))


def test_some_pairs_of_the_scenes_stick_and_some_slide() -> None:
    """The stiffness across the slip is mu N phi'(s) / s, which is above mu N / e before the full slip e only."""
    for yarns, terms, cell in FRICTION.values():
        simulation = slid(yarns, terms, cell)
        friction = simulation.terms[0]
        assert isinstance(friction, FrictionTerm)
        pairs = friction.pair_stiffness(simulation.state, simulation.model.launch)
        listed = np.arange(pairs.entries.shape[1]) < pairs.count.numpy()[:, None]
        xx, yy, zz, xy, xz, yz = pairs.stiffness.numpy()[listed].T
        matrices = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
        press = np.linalg.norm(friction.contacts.press.numpy()[listed], axis=1)
        size = np.linalg.eigvalsh(matrices)[:, 2] / (float(friction.law[0]) * press) * float(friction.law[3])
        assert np.count_nonzero(size > 1.0) > 4 and np.count_nonzero(size < 1.0) > 4


@pytest.mark.parametrize("scene", FRICTION.values(), ids=FRICTION)
def test_it_is_the_derivative_of_all_forces_with_friction(
    scene: tuple[YarnSet, list[TermChoice], RelaxCell | None],
) -> None:
    """Its rows of points and of strains times motions of points, of strains and of both."""
    yarns, terms, cell = scene
    simulation = slid(yarns, terms, cell)
    found = assembled_hessian(simulation)
    without = assembled_hessian(slid(yarns, [term for term in terms if not isinstance(term, Friction)], cell))
    assert np.abs(found - without).max() > 1e-4 * np.abs(found).max()
    deformation, size, count = Deformation.of(simulation), found.shape[0], 3 * len(yarns.points)
    for direction in [*np.random.default_rng(3).normal(size=(3, size)), *np.eye(size)[count:]]:
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


@pytest.mark.parametrize("scene", FRICTION.values(), ids=FRICTION)
def test_its_rows_ascend_and_it_is_symmetric_to_the_last_bit(
    scene: tuple[YarnSet, list[TermChoice], RelaxCell | None],
) -> None:
    assert_canonical(assembled_hessian(slid(*scene)))


def test_a_common_motion_changes_no_force() -> None:
    """Without a lattice the energy depends on differences of places only; anchors do not move the whole piece."""
    yarns, terms, cell = FRICTION["open piece"]
    found = assembled_hessian(slid(yarns, terms, cell))
    shift = np.tile([0.3, -0.2, 0.5], len(yarns.points))
    np.testing.assert_allclose(found @ shift, 0.0, atol=1e-12 * np.abs(found).max())  # rounding of sums


def test_yarns_that_do_not_touch_have_the_blocks_of_their_segments_only() -> None:
    """Two linked rings of 24 control points that are apart; each point shares segments with three on each side."""
    found = assembled_hessian(started(hopf_link(1.0), KALDOR))
    assert found.nnz == 48 * 7 * 9
    assert abs(found[:72, 72:]).sum() == 0.0


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
    capacity = simulation.candidates.lists.shape[1] + 8
    simulation.candidates.lists = allocate_lists(simulation.model, simulation.model.sample_count, capacity)
    simulation.discard_launches()
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
    yarns, terms, cell = FRICTION["free cell"]
    double = slid(yarns, terms, cell)
    single = YarnSimulation.start(
        yarns, KALDOR, replace(DOUBLE, precision="float32"), device_named("cpu"), terms, cell=cell
    )
    forces_at(single, points_of(double))
    found, expected = assembled_hessian(single).toarray(), assembled_hessian(double).toarray()
    # Coordinates of ten units are rounded at 1e-6, which a slip of 0.05 units makes 2e-5 of the stiffness.
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())
    assert_canonical(assembled_hessian(single))
