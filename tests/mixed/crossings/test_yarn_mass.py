# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mass and weight of crossing yarns: kinetic energy, symmetric and positive blocks, straight yarns, forces."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from stitchmesh.mixed.crossings.yarn_mass import SLIDING_INERTIA, YarnGravity, YarnMass
from tests.mixed.crossings.small_fabrics import (
    CPU,
    RUN,
    YARN,
    differences,
    disturbed,
    energy_at,
    flat,
    force_at,
    hessian_at,
    plain_weave,
    single_yarn,
    split,
    vector_of,
)


def mass_at(fabric, state, **changes):
    mass = YarnMass(fabric.elements(**changes), wp.float64, CPU)
    mass.update_launches(vector_of(*split(state)), RUN)
    return mass


def blocks_of(mass):
    """The block of each node, of its place and its two coordinates; shape (N, 5, 5)."""
    blocks = np.zeros((mass.count, 5, 5))
    blocks[:, range(3), range(3)] = mass.mass.numpy()[:, None]
    blocks[:, [3, 4], [3, 4]] = mass.sliding_mass.numpy()
    for column, coupling in zip((3, 4), mass.coupling, strict=True):
        blocks[:, :3, column] = blocks[:, column, :3] = coupling.numpy()
    return blocks


def test_the_energy_is_that_of_the_velocities_at_both_ends_of_each_segment():
    fabric = plain_weave(3, 2)
    state = disturbed(fabric)
    nodes, sliding = split(state)
    velocity = np.random.default_rng(1).normal(size=len(state))
    moving, running = split(velocity)
    expected = 0.0
    links = fabric.yarns.links
    for i, c in np.argwhere(links[:, ::2] >= 0):
        j, d = divmod(links[i, 2 * c], 2)
        rest = sliding[j, d] - sliding[i, c]
        w = (nodes[j] - nodes[i]) / rest
        for place, number, family in ((moving[i], i, c), (moving[j], j, d)):
            speed, least = place - w * running[number, family], w * running[number, family]
            expected += 0.25 * YARN.density * rest * (speed @ speed + SLIDING_INERTIA * least @ least)
    both = np.concatenate([moving, running], axis=1)
    energy = 0.5 * np.einsum("ni,nij,nj->", both, blocks_of(mass_at(fabric, state)), both)
    assert energy == pytest.approx(expected, rel=1e-12)  # rounding


def test_blocks_are_positive_and_fixed_coordinates_have_no_mass():
    fabric = plain_weave(3, 3)
    slides = np.arange(9) % 2 == 0
    blocks = blocks_of(mass_at(fabric, disturbed(fabric), slides=slides))
    assert (blocks[:, [3, 4], [3, 4]] > 0).all(axis=1).tolist() == [bool(slide) for slide in slides]
    for block in blocks:
        moves = np.diag(block) > 0
        assert not block[~moves].any()
        assert np.linalg.eigvalsh(block[np.ix_(moves, moves)]).min() > 0


def test_a_straight_yarn_alone_slides_with_the_least_inertia():
    nodes = np.column_stack([np.arange(5) * 0.2, np.zeros(5), np.zeros(5)])
    yarn = single_yarn(nodes)
    blocks = blocks_of(mass_at(yarn, flat(nodes, yarn.sliding)))
    slides = np.array([1.0, 0.0, 0.0, 1.0, 0.0])  # nodes move along a yarn that rests
    # the least inertia of sliding is 1e-3 of the mass of a node: relative errors of 1e3 roundings
    expected = SLIDING_INERTIA * YARN.density * 0.8
    assert (slides @ blocks @ slides).sum() == pytest.approx(expected, rel=1e-11)


def test_nodes_that_merge_and_nodes_without_yarn_have_finite_blocks():
    fabric = plain_weave(2, 2)
    weightless = mass_at(fabric, flat(fabric.position, fabric.sliding), alpha=np.zeros(4))
    assert not blocks_of(weightless).any()
    merged = mass_at(fabric, flat(0 * fabric.position, 0 * fabric.sliding))
    assert np.isfinite(blocks_of(merged)).all()


PULL = (30.0, -900.0, 200.0)


def weight_of(fabric, **changes):
    return YarnGravity(fabric.elements(**changes), wp.float64, CPU, PULL)


def test_forces_are_derivatives_and_products_leave_the_coupling_out():
    fabric = plain_weave(3, 3)
    term, state = weight_of(fabric), disturbed(fabric)
    slope = differences(lambda values: energy_at(term, values), state, 0.1)
    # the energy is bilinear: differences are exact but for rounding
    np.testing.assert_allclose(force_at(term, state), -slope, rtol=0, atol=1e-12 * np.abs(slope).max())
    assert not hessian_at(term, state).any()


def test_the_whole_weight_is_that_of_the_yarn():
    fabric = plain_weave(4, 3)
    state = disturbed(fabric)
    sliding = split(state)[1]
    u, v = sliding[:, 0].reshape(3, 4), sliding[:, 1].reshape(3, 4)
    mass = YARN.density * ((u[:, -1] - u[:, 0]).sum() + (v[-1] - v[0]).sum())
    np.testing.assert_allclose(
        split(force_at(weight_of(fabric), state))[0].sum(axis=0), mass * np.array(PULL), rtol=1e-12
    )


def test_yarn_over_a_crossing_runs_to_its_lower_side():
    hanging = single_yarn(np.array([[0.0, -0.3, 0.0], [0.0, 0.0, 0.0], [0.0, -0.2, 0.0]]))
    slide = split(force_at(YarnGravity(hanging.elements(), wp.float64, CPU), flat(hanging.position, hanging.sliding)))[
        1
    ]
    # the coordinate of the node grows with the yarn on the side of node 0, which hangs lower by 0.05 cm in its middle
    assert slide[1, 0] == pytest.approx(YARN.density * 981.0 * 0.05, rel=1e-12)
