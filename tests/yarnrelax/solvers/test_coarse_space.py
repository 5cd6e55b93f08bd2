# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The coarse matrices are those of rigid motions of pieces of yarn and of strains, and are inverted cell by cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.collision.budget import STRAIN_UNIT
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers import coarse_motions
from stitchmesh.yarnrelax.solvers.coarse_inverse import Inverses
from stitchmesh.yarnrelax.solvers.coarse_motions import put_groups, suits_coarse_space
from stitchmesh.yarnrelax.solvers.coarse_space import CoarseSpace
from tests.yarnrelax.hessian.dense_matrix import DOUBLE, Products, points_of, started
from tests.yarnrelax.stockinette import periodic_patch, tube, woven_cell

KALDOR, FREE = YarnMaterial.named("kaldor-simulation"), RelaxCell()
SCENES: dict[str, tuple[YarnSet, RelaxCell | None]] = {
    "free cell": (periodic_patch(2, 2), FREE),
    "cell without shear": (periodic_patch(2, 1), RelaxCell(shear=False)),
    "cell with its periods": (periodic_patch(2, 1), None),
    "piece": (tube(3, 5), None),
}
MIXED = [periodic_patch(1, 1), woven_cell(), periodic_patch(2, 3)]


@dataclass
class Assembled:
    """A coarse space with the matrix of its motions, the motions as columns, and the Hessian of the entries."""

    space: CoarseSpace
    matrix: np.ndarray
    motions: np.ndarray
    hessian: np.ndarray


def assembled(yarns: YarnSet, cell: RelaxCell | None) -> Assembled:
    """The coarse space of one cell or piece."""
    simulation = started(yarns, KALDOR, cell=cell)
    products = Products(simulation, 0.0)
    level, damping = simulation.model.empty(products.entries), simulation.model.empty(products.entries)
    space = CoarseSpace(simulation.model, 0 if cell is None else 1)
    space.matrix_launches(products.hessian, simulation.state.points, level, damping, simulation.model.launch)
    unit = np.ones(3 * products.entries)
    unit[3 * len(yarns.points) :] = float(STRAIN_UNIT)
    hessian = products.matrix() / np.outer(unit, unit)
    count = 6 * space.count
    lower = space.matrix.numpy().reshape(count, count)
    motions = motions_of(space, points_of(simulation), np.zeros(3) if cell is None else cell.free)
    return Assembled(space, np.tril(lower) + np.tril(lower, -1).T, motions, hessian)


def motions_of(space: CoarseSpace, points: np.ndarray, free: np.ndarray) -> np.ndarray:
    """The motions of all groups and of the free strains as columns, shape (3 E, 6 G)."""
    group, middle, size = (getattr(space.groups, name).numpy() for name in ("of_point", "middle", "size"))
    motions = np.zeros((len(points) + space.strains, 3, len(middle), 6))
    for i, g in enumerate(group.tolist()):
        motions[i, :, g, :3] = np.eye(3)
        motions[i, :, g, 3:] = np.cross(np.eye(3), (points[i] - middle[g]) / size[g]).T
    if space.strains:
        motions[-1, :, -1, :3] = np.diag(free)
    return motions.reshape(3 * len(motions), -1)


@pytest.fixture(scope="module", params=SCENES.values(), ids=SCENES)
def scene(request: pytest.FixtureRequest) -> Assembled:
    return assembled(*request.param)


def test_the_matrix_is_that_of_the_motions_where_the_piece_does_not_move_as_a_whole(scene: Assembled) -> None:
    expected = scene.motions.T @ scene.hessian @ scene.motions
    used = np.diagonal(expected) > 0.0
    more = (scene.matrix - expected)[np.ix_(used, used)]
    # REGULAR raises the diagonal, and a motion as a whole is added for each of its directions and no other
    values = np.linalg.eigvalsh(more)
    mean = float(np.mean(np.diagonal(expected)[: 6 * (scene.space.count - scene.space.strains)]))
    whole = values > 1e-2 * mean
    assert whole.sum() == (3 if scene.space.model.on_lattice else 6)
    # 1e-7 of the mean, and the rounding of sums in double precision
    assert np.abs(values[~whole]).max() < 1.01e-7 * mean + 1e-12 * np.abs(expected).max()
    alone = np.diagonal(scene.matrix)[~used]  # strains that are held, and unknowns without a meaning
    assert alone == pytest.approx(1.0 + 1e-7 * mean)
    assert np.abs(scene.matrix[np.ix_(used, ~used)]).max(initial=0.0) < 1e-12 * np.abs(expected).max()


def test_the_inverse_is_that_of_the_matrix_and_symmetric(scene: Assembled) -> None:
    space = scene.space
    Inverses(space.model, space.groups, space.matrix).invert(np.ones(1, dtype=bool))
    inverse = space.matrix.numpy().reshape(scene.matrix.shape)
    assert np.array_equal(inverse, inverse.T)
    exact = np.linalg.inv(scene.matrix)
    # rounding times the condition of the matrix
    assert np.abs(inverse - exact).max() < 1e-14 * np.linalg.cond(scene.matrix) * np.abs(exact).max()


def with_matrices(cells: list[YarnSet]) -> tuple[YarnSimulation, CoarseSpace]:
    """Cells with their coarse matrices inverted."""
    simulation = YarnSimulation(
        [(yarns, KALDOR) for yarns in cells], DOUBLE, device_named("cpu"), cells=[FREE] * len(cells)
    )
    assert simulation.newton is not None and simulation.newton.coarse is not None
    simulation.newton_step(np.ones(len(cells), dtype=bool), np.ones(len(cells)))
    return simulation, simulation.newton.coarse


def matrices_of(space: CoarseSpace) -> list[np.ndarray]:
    """The matrix of each cell."""
    sizes = (6 * np.diff(space.groups.of_cell.numpy())) ** 2
    return np.split(space.matrix.numpy().copy(), np.cumsum(sizes)[:-1])


def test_the_inverse_of_each_cell_of_a_batch_has_the_bits_of_the_cell_alone() -> None:
    batch = matrices_of(with_matrices(MIXED)[1])
    for yarns, matrix in zip(MIXED, batch, strict=True):
        assert np.array_equal(matrices_of(with_matrices([yarns])[1])[0], matrix)


def test_a_cell_that_does_not_move_keeps_its_inverse() -> None:
    simulation, space = with_matrices(MIXED)
    before = matrices_of(space)
    simulation.newton_step(np.array([True, False, True]), np.ones(3))
    same = [np.array_equal(*pair) for pair in zip(before, matrices_of(space), strict=True)]
    assert same == [False, True, False]


def test_a_cell_that_is_too_large_has_no_groups_and_others_keep_theirs(monkeypatch: pytest.MonkeyPatch) -> None:
    points = [len(yarns.points) for yarns in MIXED]
    assert max(points) == points[2]
    model = with_matrices(MIXED)[0].model
    whole = put_groups(model, 3)
    monkeypatch.setattr(coarse_motions, "LARGEST_CELL", points[2] - 1)
    part = put_groups(model, 3)
    first = whole.of_cell.numpy()
    assert part.of_cell.numpy().tolist() == [*first[:3].tolist(), first[2]]
    assert (part.of_point.numpy()[-points[2] :] == -1).all() and suits_coarse_space(model)
    simulation, space = with_matrices(MIXED)
    assert all(np.abs(matrix).max() > 0.0 for matrix in matrices_of(space)[:2])
    assert np.isfinite(simulation.state.points.numpy()).all()
    large = YarnSimulation.start(MIXED[2], KALDOR, DOUBLE, device_named("cpu"), cell=FREE)
    assert large.newton is not None and large.newton.coarse is None


def test_long_yarns_are_divided_into_runs_that_stay_short() -> None:
    """Beyond 4,080 control points there are more groups, not longer ones."""
    model = YarnSimulation.start(periodic_patch(20, 30), KALDOR, DOUBLE, device_named("cpu")).model
    groups = put_groups(model, 0)
    length = groups.last.numpy() - groups.first.numpy()
    assert length.max() <= 1.5 * coarse_motions.LONGEST_RUN  # a yarn is divided into a whole number of groups
    assert 6 * len(length) > coarse_motions.MOST_UNKNOWNS
    assert np.array_equal(np.bincount(groups.of_point.numpy()), length)


def test_cells_with_few_groups_do_not_need_the_steps_of_cells_with_many() -> None:
    """Steps are launched in parts, as many as the largest cell that takes part needs; the rest is left out."""
    simulation, space = with_matrices([periodic_patch(1, 1), periodic_patch(8, 8)])
    inverses = space._inverses
    firsts = [first for first, _part in inverses._parts]
    assert firsts[0] == 0 and inverses.counts[0] in firsts and inverses.counts[1] > firsts[-1]
    launched = []
    inverses._parts = [(first, Recorded(launched, first)) for first in firsts]
    simulation.newton_step(np.array([True, False]), np.ones(2))
    assert launched == [first for first in firsts if first < inverses.counts[0]] != firsts


@dataclass
class Recorded:
    """Launches that only note that they ran."""

    launched: list[int]
    first: int

    def launch(self) -> None:
        """Note the first step of these launches."""
        self.launched.append(self.first)
