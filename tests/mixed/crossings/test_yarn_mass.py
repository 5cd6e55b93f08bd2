# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mass of crossing yarns: kinetic energy, symmetry, blocks and their inverses, straight yarns."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from stitchmesh.mixed.crossings.yarn_mass import SLIDING_INERTIA, YarnMass
from tests.mixed.crossings.small_fabrics import (
    CPU,
    RUN,
    YARN,
    disturbed,
    flat,
    plain_weave,
    single_yarn,
    split,
    vector_of,
)


def mass_at(fabric, state, scalar=wp.float64, regular=False, **changes):
    mass = YarnMass(fabric.elements(**changes), scalar, CPU, regular=regular)
    mass.update_launches(vector_of(*split(state), scalar), RUN)
    return mass


def matrix_of(launches, size, scalar=wp.float64):
    columns = []
    for unit in np.eye(size):
        direction = vector_of(*split(unit), scalar)
        product = direction.like()
        launches(direction, product, RUN)
        columns.append(flat(*product.numpy()[1:]))
    return np.stack(columns, axis=1)


def test_the_matrix_is_that_of_the_velocity_along_each_segment():
    fabric = plain_weave(3, 2)
    state = disturbed(fabric)
    nodes, sliding = split(state)
    velocity = np.random.default_rng(1).normal(size=len(state))
    moving, running = split(velocity)
    expected, (points, weights) = 0.0, np.polynomial.legendre.leggauss(2)  # exact for the square of a linear function
    links = fabric.yarns.links
    for i, c in np.argwhere(links[:, ::2] >= 0):
        j, d = divmod(links[i, 2 * c], 2)
        rest = sliding[j, d] - sliding[i, c]
        w = (nodes[j] - nodes[i]) / rest
        first, second = moving[i] - w * running[i, c], moving[j] - w * running[j, d]
        for point, weight in zip(0.5 + 0.5 * points, 0.5 * weights, strict=True):
            speed = (1 - point) * first + point * second
            expected += 0.5 * YARN.density * rest * weight * speed @ speed
    matrix = matrix_of(mass_at(fabric, state).product_launches, len(state))
    np.testing.assert_allclose(matrix, matrix.T, rtol=0, atol=1e-15 * np.abs(matrix).max())  # rounding
    assert 0.5 * velocity @ matrix @ velocity == pytest.approx(expected, rel=1e-12)
    assert np.linalg.eigvalsh(matrix).min() > -1e-14 * np.abs(matrix).max()


def test_the_total_mass_is_that_of_the_yarn_and_moves_as_a_whole():
    fabric = plain_weave(4, 3)
    state = disturbed(fabric)
    mass = mass_at(fabric, state)
    _nodes, sliding = split(state)
    u = sliding[:, 0].reshape(3, 4)
    v = sliding[:, 1].reshape(3, 4)
    yarn = (u[:, -1] - u[:, 0]).sum() + (v[-1] - v[0]).sum()
    assert mass.mass.numpy().sum() == pytest.approx(YARN.density * yarn, rel=1e-12)
    translation = np.concatenate([np.tile([1.0, 0, 0], 12), np.zeros(24)])
    for launches in (mass.product_launches, mass.block_launches):
        product = vector_of(*split(translation)).like()
        launches(vector_of(*split(translation)), product, RUN)
        assert product.numpy()[1].sum(axis=0)[0] == pytest.approx(YARN.density * yarn, rel=1e-12)


@pytest.mark.parametrize("fixed", [False, True])
def test_blocks_are_symmetric_and_positive_and_solved_exactly(fixed):
    fabric = plain_weave(3, 3)
    state = disturbed(fabric)
    mass = mass_at(fabric, state, slides=np.arange(9) % 2 == 0 if fixed else np.ones(9))
    blocks = matrix_of(mass.block_launches, len(state))
    np.testing.assert_array_equal(blocks, blocks.T)
    moves = np.diag(blocks) > 0
    assert moves.sum() == (27 + 2 * 5 if fixed else 45)
    own = blocks[np.ix_(moves, moves)]
    assert np.linalg.eigvalsh(own).min() > 0
    solved = matrix_of(mass.solve_launches, len(state))
    assert not solved[~moves].any()
    # the least inertia of sliding is 1e-3 of the mass of a node: relative errors of 1e3 roundings
    np.testing.assert_allclose(solved[np.ix_(moves, moves)] @ own, np.eye(moves.sum()), rtol=0, atol=1e-11)


def test_a_straight_yarn_alone_slides_with_the_least_inertia_and_single_precision_solves_its_block():
    nodes = np.column_stack([np.arange(5) * 0.2, np.zeros(5), np.zeros(5)])
    yarn = single_yarn(nodes)
    state = flat(nodes, yarn.sliding)
    consistent = matrix_of(mass_at(yarn, state).product_launches, 25)
    sliding = np.concatenate([np.tile([1.0, 0, 0], 5), np.tile([1.0, 0], 5)])  # nodes move along a yarn that rests
    assert np.abs(consistent @ sliding).max() < 1e-15
    for scalar, tolerance in ((wp.float64, 1e-11), (wp.float32, 1e-3)):  # 1 / SLIDING_INERTIA roundings
        mass = mass_at(yarn, state, scalar)
        blocks, solved = matrix_of(mass.block_launches, 25, scalar), matrix_of(mass.solve_launches, 25, scalar)
        moves = np.diag(blocks) > 0
        assert moves.sum() == 20
        product = (blocks @ solved)[np.ix_(moves, moves)]
        np.testing.assert_allclose(product, np.eye(20), rtol=0, atol=tolerance)
        assert sliding @ blocks @ sliding == pytest.approx(SLIDING_INERTIA * YARN.density * 0.8, rel=tolerance)


def test_nodes_that_merge_and_nodes_without_yarn_have_finite_inverses():
    fabric = plain_weave(2, 2)
    weightless = mass_at(fabric, flat(fabric.position, fabric.sliding), alpha=np.zeros(4))
    assert not matrix_of(weightless.solve_launches, 20).any()
    merged = mass_at(fabric, flat(0 * fabric.position, 0 * fabric.sliding))
    assert np.isfinite(matrix_of(merged.solve_launches, 20)).all()
