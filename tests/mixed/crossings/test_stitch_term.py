# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wrapping and length of stitch contacts: derivatives, invariance, sides, extremes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from stitchmesh.mixed.cloth.seams import cloth_from_panels
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial, FabricMaterials
from stitchmesh.mixed.crossings.crossing_term import CrossingTerm, crossing_elements
from stitchmesh.mixed.crossings.friction.normal_forces import contact_axes
from stitchmesh.mixed.crossings.stitch_term import StitchTerm, stitch_elements
from stitchmesh.mixed.layout.knit import lay_knit
from stitchmesh.mixed.mixed_vector import MixedBlocks
from tests.mixed.cloth.panel_shapes import rectangle
from tests.mixed.crossings.small_fabrics import (
    CPU,
    RUN,
    differences,
    energy_at,
    flat,
    force_at,
    hessian_at,
    plain_weave,
    stitch_contact,
)

YARN = CrossingMaterial.named("gong-2")
CONTACT = stitch_contact()
COUNT = len(CONTACT.position)


def term_of(material=YARN, scalar=wp.float64, fabric=CONTACT, **changes):
    return StitchTerm(stitch_elements(fabric.yarns, fabric.elements(), material, **changes), COUNT, scalar, CPU)


def state_of(size, seed=0):
    nodes = CONTACT.position + size * np.random.default_rng(seed).normal(size=CONTACT.position.shape)
    return flat(nodes, CONTACT.sliding)


@pytest.mark.parametrize("changes", [{"stitch_length": 0.0}, {"wrapping": 0.0}, {}])
def test_forces_and_products_are_derivatives(changes):
    term, state = term_of(replace(YARN, **changes)), state_of(0.03)
    slope = differences(lambda values: energy_at(term, values), state, 1e-4)
    # differences of fourth order: 1e-3 of the length of a contact to the fourth power
    np.testing.assert_allclose(force_at(term, state), -slope, rtol=0, atol=1e-7 * np.abs(slope).max())
    matrix = differences(lambda values: -force_at(term, values), state, 1e-5)
    np.testing.assert_allclose(hessian_at(term, state), matrix, rtol=0, atol=1e-7 * np.abs(matrix).max())
    eigenvalues = np.linalg.eigvalsh(hessian_at(term, state, exact=0.0))
    assert eigenvalues.min() > -1e-12 * eigenvalues.max()  # rounding


def test_legs_near_the_axis_fade_out_smoothly():
    term = term_of(replace(YARN, stitch_length=0.0))
    steps = []
    for angle in (0.7, 0.45, 0.2, 0.02, 1e-4):
        nodes = CONTACT.position.copy()
        nodes[0] = 0.1 * np.array([-np.sin(angle), np.cos(angle), 0.03])
        state = flat(nodes, CONTACT.sliding)
        slope = differences(lambda values: energy_at(term, values), state, 1e-3 * 0.1 * angle)
        force = force_at(term, state)
        # differences of fourth order of a function that changes over the distance of the leg from the axis
        np.testing.assert_allclose(force, -slope, rtol=0, atol=1e-6 * np.abs(force).max())
        matrix = differences(lambda values: -force_at(term, values), state, 1e-3 * 0.1 * angle)
        np.testing.assert_allclose(hessian_at(term, state), matrix, rtol=0, atol=1e-6 * np.abs(matrix).max())
        steps.append(np.abs(force).max())
    # bounded by the energy of a turn of pi over the length of the leg, of which f takes 1 / FADE at most
    assert max(steps) < 10 * np.pi**2 * YARN.wrapping


def test_the_legs_turn_to_the_side_on_which_the_new_loop_comes_in():
    for side in (1, -1):  # a purl stitch, and the knit stitch of the contact
        for mirror in (1.0, -1.0):  # the contact at the left of a loop and that at its right
            yarns = replace(CONTACT.yarns, side=np.where(np.arange(COUNT) == 1, side, CONTACT.yarns.side))
            place = CONTACT.position * [mirror, 1.0, 1.0]
            yarns = replace(yarns, position=place[:, :2], stitch_left=[mirror > 0])
            fabric = replace(CONTACT, yarns=yarns, position=place)
            term = term_of(fabric=fabric)
            state = flat(place, fabric.sliding)
            # flat: a quarter turn from rest
            assert energy_at(term, state) == pytest.approx(0.5 * YARN.wrapping * 0.1 * (np.pi / 2) ** 2, rel=1e-12)
            force = force_at(term, state)[: 3 * COUNT].reshape(-1, 3)
            assert side * force[0, 2] > 0 and side * force[3, 2] > 0
            assert not force[4:].any()


def test_forces_and_torques_add_up_to_zero():
    state = state_of(0.05, seed=1)
    nodes = state[: 3 * COUNT].reshape(-1, 3)
    force = force_at(term_of(), state)[: 3 * COUNT].reshape(-1, 3)
    scale = np.abs(force).max()
    np.testing.assert_allclose(force.sum(axis=0), 0, atol=1e-12 * scale)  # rounding
    np.testing.assert_allclose(np.cross(nodes, force).sum(axis=0), 0, atol=1e-12 * scale)


def test_flattened_contacts_have_finite_forces():
    for scale in (0.0, [0.0, 1.0, 0.0], [1.0, 1e-12, 1.0]):
        state = flat(CONTACT.position * scale, CONTACT.sliding)
        for values in (
            force_at(term_of(), state),
            hessian_at(term_of(), state),
            hessian_at(term_of(), state, exact=0.0),
        ):
            assert np.isfinite(values).all()


def test_diagonal_blocks_are_those_of_the_matrix():
    term, state = term_of(), state_of(0.03)
    matrix = hessian_at(term, state)
    blocks = MixedBlocks.zeros(0, COUNT, wp.float64, CPU)
    term.diagonal(blocks, RUN)
    for i in range(COUNT):
        own = slice(3 * i, 3 * i + 3)
        np.testing.assert_allclose(blocks.nodes.numpy()[i], matrix[own, own], rtol=0, atol=1e-12 * np.abs(matrix).max())


def test_the_weight_of_blending_scales_and_contacts_with_nodes_outside_are_left_out():
    state = state_of(0.02)
    whole = energy_at(term_of(), state)
    assert energy_at(term_of(alpha=np.full(COUNT, 0.25)), state) == pytest.approx(0.25 * whole, rel=1e-12)
    part = crossing_elements(CONTACT.yarns, FabricMaterials.of(YARN), nodes=[0, 1, 3, 4, 5])
    assert len(stitch_elements(CONTACT.yarns, part, YARN).nodes) == 0
    short = crossing_elements(CONTACT.yarns, FabricMaterials.of(YARN), nodes=[1, 2, 3])
    elements = stitch_elements(CONTACT.yarns, short, YARN)
    assert elements.wrapping.tolist() == [0.0] and elements.length_stiffness.tolist() == [YARN.stitch_length]


def test_a_weave_has_no_stitch_contacts():
    fabric = plain_weave(3, 3)
    term = StitchTerm(stitch_elements(fabric.yarns, fabric.elements(), YARN), 9, wp.float64, CPU)
    state = flat(fabric.position, fabric.sliding)
    assert energy_at(term, state) == 0.0 and not force_at(term, state).any() and not hessian_at(term, state).any()


def test_a_knit_as_laid_out_has_the_energy_of_its_wrapping_alone():
    cloth = cloth_from_panels([rectangle(5.0, 4.0)], [], edge_length=1.0)
    yarns = lay_knit(cloth, [[1]], wale_spacing=0.5, course_spacing=0.4)
    elements = crossing_elements(yarns, FabricMaterials.of(YARN))
    stitches = stitch_elements(yarns, elements, YARN)
    nodes = np.column_stack([yarns.position, np.zeros(yarns.node_count)])
    state = flat(nodes, yarns.rest_sliding)
    assert energy_at(CrossingTerm(elements, wp.float64, CPU), state) < 1e-15
    wraps = stitches.wrapping > 0
    assert wraps.sum() > 0.8 * len(wraps) > 50
    assert (contact_axes(elements.link)[stitches.nodes[:, 1:3]] >= 0).all()
    expected = (0.5 * stitches.wrapping * (np.pi / 2) ** 2).sum()
    term = StitchTerm(stitches, elements.count, wp.float64, CPU)
    assert energy_at(term, state) == pytest.approx(expected, rel=1e-10)
    # the links and heads of a stockinette turn to the back; what their axes turn around is pushed to the front
    force = force_at(term, state)[: nodes.size].reshape(-1, 3)
    moment = (force[:, 2] * (yarns.position[:, 0] - 2.5) ** 2).sum()
    assert moment < 0 and np.abs(force[:, :2]).max() < 1e-9 * np.abs(force[:, 2]).max()
