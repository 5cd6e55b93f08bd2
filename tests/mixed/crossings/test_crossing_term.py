# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Energies of the star of a crossing node: derivatives, invariance, closed forms, extremes."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.crossings.crossing_material import FabricMaterials
from stitchmesh.mixed.crossings.crossing_term import CrossingTerm, crossing_elements
from stitchmesh.mixed.mixed_vector import MixedBlocks
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
    softened,
    split,
    vector_of,
)

ONLY = {
    "stretch": {"bending": 0.0, "shear": 0.0, "contact": 0.0},
    "bending": {"young": 1e-6, "shear": 0.0, "contact": 0.0},
    "shear": {"young": 1e-6, "bending": 0.0, "contact": 0.0},
    "contact": {"young": 1e-6, "bending": 0.0, "shear": 0.0},
    "all": {},
}
"""Stiffnesses that leave one energy of the star; stretch cannot be absent."""


def term_of(fabric, material=YARN, scalar=wp.float64, **changes):
    return CrossingTerm(fabric.elements(material, **changes), scalar, CPU, block_scalar=scalar)


@pytest.mark.parametrize("energy", ONLY)
def test_forces_and_products_are_derivatives(energy):
    fabric = plain_weave(3, 3, spacing=0.19)
    term = term_of(fabric, softened(**ONLY[energy]))
    state = disturbed(fabric)
    force = force_at(term, state)
    slope = differences(lambda values: energy_at(term, values), state, 1e-4)
    # differences of fourth order with a step of 1e-3 of a spacing: 1e-12 of the largest, and rounding of 1e-16 / 1e-4
    np.testing.assert_allclose(force, -slope, rtol=0, atol=1e-8 * np.abs(slope).max())
    matrix = differences(lambda values: -force_at(term, values), state, 1e-4)
    np.testing.assert_allclose(hessian_at(term, state), matrix, rtol=0, atol=1e-7 * np.abs(matrix).max())


def test_the_other_matrix_is_never_negative_and_equals_the_exact_one_at_rest():
    fabric = plain_weave(3, 3, spacing=0.19)
    term = term_of(fabric)
    for size in (0.1, 0.4, 1.5):  # up to yarns that are folded and nodes that have passed one another
        matrix = hessian_at(term, disturbed(fabric, size=size), exact=0.0)
        np.testing.assert_allclose(matrix, matrix.T, rtol=0, atol=1e-12 * np.abs(matrix).max())
        assert np.linalg.eigvalsh(matrix).min() > -1e-12 * np.abs(matrix).max()  # rounding
    rest = flat(fabric.position, fabric.sliding)
    exact = hessian_at(term, rest)
    np.testing.assert_allclose(hessian_at(term, rest, exact=0.0), exact, rtol=0, atol=1e-9 * np.abs(exact).max())


def test_a_share_of_the_exact_matrix_lies_between_both():
    fabric = plain_weave(3, 3)
    term, state = term_of(fabric, softened(bending=0.0, shear=0.0)), disturbed(fabric)
    ends = hessian_at(term, state, exact=0.0), hessian_at(term, state, exact=1.0)
    np.testing.assert_allclose(
        hessian_at(term, state, exact=0.25), 0.75 * ends[0] + 0.25 * ends[1], rtol=1e-9, atol=1e-6
    )


def test_rigid_motion_costs_nothing_and_forces_and_torques_add_up_to_zero():
    fabric = plain_weave(4, 3, spacing=0.19)
    term = term_of(fabric)
    state = disturbed(fabric)
    nodes, sliding = split(state)
    rotation = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    moved = flat(nodes @ rotation.T + [1.0, -2.0, 0.5], sliding)
    assert energy_at(term, moved) == pytest.approx(energy_at(term, state), rel=1e-12)
    force, _slide = split(force_at(term, state))
    scale = np.abs(force).max()
    np.testing.assert_allclose(split(force_at(term, moved))[0], force @ rotation.T, rtol=0, atol=1e-10 * scale)
    np.testing.assert_allclose(force.sum(axis=0), 0, atol=1e-12 * scale)
    np.testing.assert_allclose(np.cross(nodes, force).sum(axis=0), 0, atol=1e-12 * scale)
    # yarn that slides along as a whole costs nothing either
    shifted = flat(nodes, sliding + np.array([0.3, -0.2]))
    assert energy_at(term, shifted) == pytest.approx(energy_at(term, state), rel=1e-12)
    rest = flat(fabric.position @ rotation.T, fabric.sliding)
    assert energy_at(term, rest) < 1e-20
    assert np.abs(force_at(term, rest)).max() < 1e-8 * YARN.stretch_stiffness


def test_uniform_stretch_of_a_plain_weave_is_that_of_its_yarns_in_parallel():
    fabric = plain_weave(6, 5)
    stretched = fabric.position * [1.05, 1.02, 1.0]
    lengths = 5 * 5 * 0.25, 6 * 4 * 0.25  # of all u yarns and of all v yarns
    expected = 0.5 * YARN.stretch_stiffness * (lengths[0] * 0.05**2 + lengths[1] * 0.02**2)
    term = term_of(fabric)
    assert energy_at(term, flat(stretched, fabric.sliding)) == pytest.approx(expected, rel=1e-10)
    force = split(force_at(term, flat(stretched, fabric.sliding)))[0].reshape(5, 6, 3)
    assert -force[:, 0, 0].sum() == pytest.approx(-5 * 0.05 * YARN.stretch_stiffness, rel=1e-10)


def test_a_trellis_shears_by_its_four_quadrants():
    fabric = plain_weave(3, 3)
    angle = 0.2
    sheared = fabric.position.copy()
    sheared[:, 0] += np.sin(angle) * fabric.position[:, 1]
    sheared[:, 1] *= np.cos(angle)
    quadrants = 4 * 1 + 2 * 4 + 1 * 4  # of the inner node, of four at a border, of four at a corner
    expected = quadrants * 0.5 * YARN.shear * YARN.radius**2 * 0.25 * angle**2
    assert energy_at(term_of(fabric), flat(sheared, fabric.sliding)) == pytest.approx(expected, rel=1e-10)


def test_a_roll_has_the_energy_of_a_rod_of_rigidity_b_pi_r2():
    """A yarn of 24 segments around a circle of radius r: 1/2 EI / r^2 for each length, with EI = B pi R^2."""
    count, radius = 24, 1.3
    turn = 2 * np.pi / count * np.arange(count)
    nodes = radius * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    chord = 2 * radius * np.sin(np.pi / count)
    straight = np.column_stack([np.arange(count) * chord, np.zeros((count, 2))])
    yarn = single_yarn(straight)
    rigidity = YARN.bending * np.pi * YARN.radius**2
    expected = 0.5 * rigidity / radius**2 * chord * (count - 2)
    # the discrete curvature is 2 pi / (count chord), above 1 / radius by (pi / count)^2 / 6
    assert energy_at(term_of(yarn), flat(nodes, yarn.sliding)) == pytest.approx(
        expected, rel=0.5 * (np.pi / count) ** 2
    )


def test_parallel_yarns_touch_below_four_radii_where_the_yarn_changes_its_side():
    fabric = plain_weave(3, 1, spacing=0.5)
    term = term_of(fabric, softened(bending=0.0))
    sliding = fabric.sliding.copy()
    sliding[1, 0] = 0.15  # 0.05 cm below 4 R = 0.2 cm
    contact = 0.5 * YARN.contact * 0.5 * 0.05**2
    nodes = fabric.position.copy()
    nodes[1, 0] = 0.15  # without stretch
    nodes[2, 0] = sliding[2, 0] = 0.5
    assert energy_at(term, flat(nodes, sliding)) == pytest.approx(contact, rel=1e-10)
    dense = plain_weave(3, 1, spacing=0.1)
    assert energy_at(term_of(dense), flat(dense.position, dense.sliding)) < 1e-20  # a denser layout has no contact


def test_the_weight_of_blending_scales_energies_and_zero_leaves_them_out():
    fabric = plain_weave(3, 3)
    state = disturbed(fabric, size=0.05)
    whole = energy_at(term_of(fabric), state)
    assert energy_at(term_of(fabric, alpha=np.full(9, 0.3)), state) == pytest.approx(0.3 * whole, rel=1e-12)
    assert energy_at(term_of(fabric, alpha=np.full(9, 1e-6)), state) == pytest.approx(1e-6 * whole, rel=1e-12)
    assert energy_at(term_of(fabric, alpha=np.zeros(9)), state) == 0.0


def test_fixed_coordinates_have_no_force_and_no_rows_and_columns():
    fabric = plain_weave(3, 3)
    slides = np.arange(9) % 2 == 0
    state = disturbed(fabric)
    held, free = term_of(fabric, slides=slides), term_of(fabric)
    moves = np.concatenate([np.ones(27, dtype=bool), np.repeat(slides, 2)])
    np.testing.assert_array_equal(force_at(held, state), np.where(moves, force_at(free, state), 0.0))
    matrix = hessian_at(held, state)
    np.testing.assert_array_equal(matrix[np.ix_(moves, moves)], hessian_at(free, state)[np.ix_(moves, moves)])
    assert not matrix[~moves].any() and not matrix[:, ~moves].any()


def test_bending_beyond_the_yield_curvature_stays():
    straight = np.column_stack([np.arange(3) * 0.2, np.zeros((3, 2))])
    yarn = single_yarn(straight)
    for angle, kept in ((0.05, 0.0), (0.5, 0.3), (-0.5, 0.3)):
        term = term_of(yarn, softened(yield_curvature=1.0))  # 1 / cm over 0.2 cm: 0.2 rad
        bent = straight.copy()
        bent[2, :2] = [0.2 + 0.2 * np.cos(angle), 0.2 * np.sin(angle)]
        for _ in range(3):  # the second and third step change nothing
            term.end_step(vector_of(bent, yarn.sliding), 0.0, 0.0)
        assert term.turn.numpy()[1, 0] == pytest.approx(kept, abs=1e-12)
        force = split(force_at(term, flat(bent, yarn.sliding)))[0]
        moment = 0.2 * np.linalg.norm(force[2])  # 2 k_b (t - r) / D
        assert moment == pytest.approx(2 * YARN.bending_stiffness * min(abs(angle), 0.2) / 0.4, rel=1e-9)


@pytest.mark.nightly
def test_extremes_have_finite_forces_and_products():
    """In single precision, which overflows first."""
    fabric = plain_weave(3, 3)
    position, sliding = fabric.position, fabric.sliding
    merged, passed = sliding.copy(), sliding.copy()
    merged[4] = merged[3] + [1e-9, 0.25]
    passed[4, 0] = passed[3, 0] - 0.1
    folded = position.copy()
    folded[5] = folded[3]
    states = {
        "merged along the yarn": (position, merged),
        "passed one another": (position, passed),
        "all coordinates zero": (position, 0 * sliding),
        "all nodes at one place": (0 * position, sliding),
        "all of it": (0 * position, 0 * sliding),
        "folded": (folded, sliding),
        "straight": (position, sliding),
        "stretched by 1000": (1000 * position, sliding),
    }
    term = term_of(fabric, scalar=wp.float32)
    for name, (nodes, places) in states.items():
        state = flat(nodes, places)
        assert np.isfinite(energy_at(term, state, wp.float32)), name
        assert np.isfinite(force_at(term, state, wp.float32)).all(), name
        for exact in (0.0, 1.0):
            assert np.isfinite(hessian_at(term, state, exact, wp.float32)).all(), name


def test_nodes_that_merge_are_pushed_apart_with_bounded_stiffness():
    straight = np.column_stack([np.arange(3) * 0.25, np.zeros((3, 2))])
    yarn = single_yarn(straight)
    term = term_of(yarn)
    nodes = straight.copy()
    nodes[1, 0] = 0.0  # the nodes 0 and 1 lie at one place
    rest_stiffness = YARN.stretch_stiffness / 0.25
    for place in (0.03, 0.01, 0.0, -0.02):
        state = flat(nodes, np.column_stack([[0.0, place, 0.5], np.zeros(3)]))
        assert force_at(term, state)[9 + 2] > 0  # the coordinate of node 1 grows
        assert np.abs(hessian_at(term, state)[11, 11]) < 1e3 * rest_stiffness


def test_single_precision_has_the_forces_of_double_precision():
    fabric = plain_weave(5, 5)
    state = disturbed(fabric, size=0.05).astype(np.float32).astype(np.float64)
    exact, rounded = force_at(term_of(fabric), state), force_at(term_of(fabric, scalar=wp.float32), state, wp.float32)
    # differences of coordinates of 1 cm over 0.25 cm: a strain of 1e-6 at most
    np.testing.assert_allclose(rounded, exact, rtol=0, atol=2e-6 * YARN.stretch_stiffness)
    exact, rounded = (
        hessian_at(term_of(fabric), state),
        hessian_at(term_of(fabric, scalar=wp.float32), state, 1.0, wp.float32),
    )
    np.testing.assert_allclose(rounded, exact, rtol=0, atol=1e-5 * np.abs(exact).max())


def test_elements_with_nodes_that_are_not_simulated_are_left_out():
    fabric = plain_weave(4, 4)
    chosen = np.array([0, 1, 4, 5, 6])
    state = disturbed(fabric, size=0.05)
    nodes, sliding = split(state)
    part = crossing_elements(fabric.yarns, FabricMaterials.of(YARN), nodes=chosen)
    assert part.link[1].tolist() == [-1, 0, 7, -1] and (part.stretch > 0).sum() == 5 and (part.bending > 0).sum() == 1
    lengths = [np.linalg.norm(nodes[j] - nodes[i]) for i, j in ((0, 1), (4, 5), (5, 6))]
    lengths += [np.linalg.norm(nodes[j] - nodes[i]) for i, j in ((0, 4), (1, 5))]
    rest = [sliding[1, 0] - sliding[0, 0], sliding[5, 0] - sliding[4, 0], sliding[6, 0] - sliding[5, 0]]
    rest += [sliding[4, 1] - sliding[0, 1], sliding[5, 1] - sliding[1, 1]]
    stretch = sum(0.5 * YARN.stretch_stiffness * (a - b) ** 2 / b for a, b in zip(lengths, rest, strict=True))
    soft = crossing_elements(fabric.yarns, FabricMaterials.of(softened(**ONLY["stretch"])), nodes=chosen)
    term = CrossingTerm(soft, wp.float64, CPU)
    assert energy_at(term, flat(nodes[chosen], sliding[chosen])) == pytest.approx(stretch, rel=1e-12)


def test_coordinates_are_free_between_nodes_that_have_coordinates():
    fabric = plain_weave(5, 5)
    alpha = np.ones(25)
    alpha[4::5] = 0.5  # the last column
    slides = crossing_elements(fabric.yarns, FabricMaterials.of(YARN), alpha=alpha).slides.reshape(5, 5, 2)
    expected = np.zeros((5, 5, 2), dtype=bool)
    expected[:, 1:3, 0] = expected[1:-1, :4, 1] = True  # not at ends, and not beside the last column along u
    np.testing.assert_array_equal(slides, expected)


def test_wrong_nodes_and_shapes_are_refused():
    yarns, materials = plain_weave(3, 2).yarns, FabricMaterials.of(YARN)
    for nodes in ([1, 0], [0, 6], [[0]]):
        with pytest.raises(ParameterError, match="nodes: expected ascending numbers from 0 to 5"):
            crossing_elements(yarns, materials, nodes=nodes)
    with pytest.raises(ParameterError, match=r"alpha has the shape \(5,\); expected \(6,\)"):
        crossing_elements(yarns, materials, alpha=np.ones(5))
    with pytest.raises(ParameterError, match=r"slides has the shape \(6,\); expected \(6, 2\)"):
        crossing_elements(yarns, materials, slides=np.ones(6))


def test_rounded_blocks_have_the_products_of_single_precision_and_none_for_a_translation():
    fabric = plain_weave(3, 4, spacing=0.19)
    slides = np.arange(12) != 5
    state = disturbed(fabric)
    exact = hessian_at(term_of(fabric, slides=slides), state)
    term = CrossingTerm(fabric.elements(slides=slides), wp.float64, CPU)
    rounded = hessian_at(term, state)
    # a block is rounded by 6e-8 of its largest entry, and a few of them are added up
    np.testing.assert_allclose(rounded, exact, rtol=0, atol=5e-7 * np.abs(exact).max())
    np.testing.assert_array_equal(rounded[:36].reshape(12, 3, -1).sum(axis=0) != 0, False)
    np.testing.assert_allclose(rounded, rounded.T, rtol=0, atol=5e-7 * np.abs(exact).max())
    blocks = MixedBlocks.zeros(0, 12, wp.float64, CPU)
    term.diagonal(blocks, RUN)
    for i in range(12):
        own, slide = slice(3 * i, 3 * i + 3), slice(36 + 2 * i, 38 + 2 * i)
        for found, expected in ((blocks.nodes, exact[own, own]), (blocks.sliding, exact[slide, slide])):
            np.testing.assert_allclose(found.numpy()[i], expected, rtol=0, atol=5e-7 * np.abs(exact).max())
