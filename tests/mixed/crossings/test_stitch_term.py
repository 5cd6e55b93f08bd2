# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wrapping and length of stitch contacts: derivatives, invariance, sides, extremes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial
from stitchmesh.mixed.crossings.stitch_term import StitchTerm, stitch_elements
from tests.mixed.crossings.small_fabrics import CPU, differences, energy_at, flat, force_at, hessian_at

YARN = CrossingMaterial.named("gong-2")
FLAT = np.array([[-0.1, 0.02, 0.0], [0.0, 0.0, 0.0], [0.0, 0.1, 0.0], [0.1, 0.09, 0.0], [-0.1, 0.1, 0.0]])
"""A contact between nodes 1 and 2, with legs to 0, 3 and 4."""
NODES = [[0, 1, 2, 3], [4, 2, 1, 3]]


def term_of(material=YARN, rest=np.pi / 2, scalar=wp.float64):
    return StitchTerm(stitch_elements(NODES, rest, FLAT, material), len(FLAT), scalar, CPU)


def state_of(size, seed=0):
    nodes = FLAT + size * np.random.default_rng(seed).normal(size=FLAT.shape)
    return flat(nodes, np.zeros((len(nodes), 2)))


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


def test_the_yarns_wrap_to_the_side_of_their_rest_angle():
    for side in (1.0, -1.0):
        elements = stitch_elements(NODES[:1], side * np.pi / 2, FLAT, YARN)
        term = StitchTerm(elements, len(FLAT), wp.float64, CPU)
        state = flat(FLAT, np.zeros((5, 2)))
        # flat: a quarter turn from rest
        assert energy_at(term, state) == pytest.approx(0.5 * YARN.wrapping * 0.1 * (np.pi / 2) ** 2, rel=1e-12)
        force = force_at(term, state)[:15].reshape(5, 3)
        assert side * force[0, 2] < 0 and side * force[3, 2] < 0 and force[4].tolist() == [0, 0, 0]


def test_a_contact_with_two_elements_has_its_length_once():
    stretched = FLAT.copy()
    stretched[[2, 3, 4], 1] += 0.02
    term = term_of(replace(YARN, wrapping=0.0))
    expected = 0.5 * YARN.stitch_length * 0.1 * 0.2**2
    assert energy_at(term, flat(stretched, np.zeros((5, 2)))) == pytest.approx(expected, rel=1e-12)


def test_forces_and_torques_add_up_to_zero():
    term = term_of()
    nodes = state_of(0.05, seed=1)[:15].reshape(5, 3)
    force = force_at(term, flat(nodes, np.zeros((5, 2))))[:15].reshape(5, 3)
    scale = np.abs(force).max()
    np.testing.assert_allclose(force.sum(axis=0), 0, atol=1e-12 * scale)  # rounding
    np.testing.assert_allclose(np.cross(nodes, force).sum(axis=0), 0, atol=1e-12 * scale)


def test_flattened_contacts_have_finite_forces():
    for nodes in (np.zeros((5, 3)), FLAT * [0, 1, 0], FLAT * [1, 1e-12, 0]):
        state = flat(nodes, np.zeros((5, 2)))
        term = term_of()
        for values in (force_at(term, state), hessian_at(term, state), hessian_at(term, state, exact=0.0)):
            assert np.isfinite(values).all()


def test_single_precision_has_the_forces_of_double_precision():
    state = state_of(0.03).astype(np.float32).astype(np.float64)
    exact = force_at(term_of(), state)
    rounded = force_at(term_of(scalar=wp.float32), state, wp.float32)
    # some ten operations of relative error 6e-8 on lengths and angles near 1
    np.testing.assert_allclose(rounded, exact, rtol=0, atol=1e-5 * np.abs(exact).max())


def test_wrong_elements_are_refused():
    with pytest.raises(ParameterError, match=r"element 0 has the nodes \[0, 1, 2, 9\]; expected four numbers from 0 to 4"):
        stitch_elements([[0, 1, 2, 9]], np.pi / 2, FLAT, YARN)
    with pytest.raises(ParameterError, match="the contact of element 0 has no length"):
        stitch_elements([[0, 1, 1, 3]], np.pi / 2, FLAT, YARN)


def test_a_weave_has_no_stitch_contacts():
    term = StitchTerm(stitch_elements(np.zeros((0, 4)), np.pi / 2, FLAT, YARN), 5, wp.float64, CPU)
    state = state_of(0.1)
    assert energy_at(term, state) == 0.0 and not force_at(term, state).any() and not hessian_at(term, state).any()
