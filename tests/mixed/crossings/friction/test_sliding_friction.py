# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Normal forces at crossings, and yarns that stick, slip, and stay where they were dragged."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial
from stitchmesh.mixed.crossings.crossing_term import CrossingElements, CrossingTerm
from stitchmesh.mixed.crossings.friction.normal_forces import contact_axes
from stitchmesh.mixed.crossings.friction.sliding_friction import SLIP_SHARE, SlidingFriction
from stitchmesh.mixed.term import MixedTerm
from tests.mixed.crossings.small_fabrics import (
    CPU,
    YARN,
    Fabric,
    differences,
    disturbed,
    energy_at,
    flat,
    force_at,
    hessian_at,
    plain_weave,
    split,
    vector_of,
)

COLUMNS, ROWS, SPACING = 9, 3, 0.25
PULLED = COLUMNS + np.arange(COLUMNS)
"""Nodes of the yarn in the middle, which is pulled at its last node."""
SOFT = replace(YARN, bending=0.0, shear=0.0)


def with_friction(
    fabric: Fabric, material: CrossingMaterial, scalar=wp.float64, **changes
) -> tuple[CrossingElements, CrossingTerm, SlidingFriction]:
    """The elements of a fabric and its terms of elasticity and friction."""
    elements = fabric.elements(material, **changes)
    yarns = CrossingTerm(elements, scalar, CPU)
    return elements, yarns, SlidingFriction(elements, yarns)


def rest_of(terms: Sequence[MixedTerm], values: np.ndarray, free: np.ndarray, residual: float) -> np.ndarray:
    """The state of equilibrium of the free entries, near a given one; ``residual`` is the largest force left [dyn]."""
    values = values.copy()
    for _ in range(100):
        force = sum(force_at(term, values) for term in terms)[free]
        if np.abs(force).max() < residual:
            return values
        matrix = sum(hessian_at(term, values, of=free) for term in terms)[free]
        step = np.zeros(len(values))
        step[free] = np.linalg.solve(matrix + 1e-9 * np.trace(matrix) * np.eye(len(force)), force)
        before, length = sum(energy_at(term, values) for term in terms), 1.0
        most = before + 1e-12 * abs(before)  # near rest, energies differ by rounding alone
        while sum(energy_at(term, values + length * step) for term in terms) > most and length > 1e-6:
            length /= 2
        values += length * step
    raise AssertionError(f"no equilibrium: forces of {np.abs(force).max()} dyn are left")


def take_step(
    terms: Sequence[MixedTerm],
    values: np.ndarray,
    free: np.ndarray,
    loaded: np.ndarray | None = None,
    residual: float = 1e-7,
) -> np.ndarray:
    """One static step from ``values`` with its updates before and after; ``loaded`` has other values that are not
    free."""
    for term in terms:
        term.begin_step(vector_of(*split(values)), 0.0, 0.0)
    values = rest_of(terms, values if loaded is None else loaded, free, residual)
    for term in terms:
        term.end_step(vector_of(*split(values)), 0.0, 0.0)
    return values


def pressing_at(friction, state):
    friction.begin_step(vector_of(*split(state)), 0.0, 1e-3)
    return friction.normal_forces.pressing.numpy()


def entry_of(node, c, count=COLUMNS * ROWS):
    """Entry of a coordinate in the values of a fabric."""
    return 3 * count + 2 * node + c


def tensions(values, yarn=PULLED):
    nodes, sliding = split(values)
    strain = np.diff(nodes[yarn, 0]) / np.diff(sliding[yarn, 0]) - 1
    return YARN.stretch_stiffness * strain


def test_tension_presses_by_the_crimp():
    fabric = plain_weave(5, 5, SPACING)
    _elements, _yarns, friction = with_friction(fabric, SOFT)
    stretched = fabric.position * [1.02, 1.0, 1.0]
    pressing = pressing_at(friction, flat(stretched, fabric.sliding)).reshape(5, 5)
    tension, crimped = 0.02 * YARN.stretch_stiffness, np.hypot(1.02 * SPACING, 2 * YARN.radius)
    np.testing.assert_allclose(pressing[1:-1, 1:-1], 2 * tension * YARN.radius / crimped, rtol=1e-10)


def test_bending_into_the_crimp_presses_without_tension():
    radius = 1e-3  # a small crimp, for which the closed form holds to (2 R / L)^2
    material = replace(YARN, radius=radius, bending=1e6)
    fabric = plain_weave(7, 7, SPACING)
    _elements, _yarns, friction = with_friction(fabric, material)
    pressing = pressing_at(friction, flat(fabric.position, fabric.sliding)).reshape(7, 7)
    expected = 16 * material.bending_stiffness * radius / SPACING**3
    assert pressing[3, 3] == pytest.approx(expected, rel=4 * (2 * radius / SPACING) ** 2)


def test_a_yarn_that_is_pressed_along_its_axis_leaves_the_part_of_the_other_one():
    radius = 1e-3  # a small crimp, as above
    material = replace(YARN, radius=radius, bending=1e3)
    fabric = plain_weave(7, 7, SPACING)
    _elements, _yarns, friction = with_friction(fabric, material)
    pressing = pressing_at(friction, flat(fabric.position * [0.9, 1.0, 1.0], fabric.sliding)).reshape(7, 7)
    expected = 8 * material.bending_stiffness * radius / SPACING**3
    # 0.1 k_s 4 R / L of compression is more than the bending of the pressed yarns
    assert 0.1 * material.stretch_stiffness * 4 * radius / SPACING > 4 * expected
    assert pressing[3, 3] == pytest.approx(expected, rel=4 * (2 * radius / SPACING) ** 2)


def test_normal_forces_do_not_depend_on_the_place_or_on_the_side_that_is_looked_at():
    fabric = plain_weave(5, 4, SPACING)
    state = disturbed(fabric, size=0.05)
    nodes, sliding = split(state)
    rotation = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    rotation *= np.linalg.det(rotation)
    expected = pressing_at(with_friction(fabric, YARN)[2], state)
    assert (expected > 0).sum() > 5
    turned = pressing_at(with_friction(fabric, YARN)[2], flat(nodes @ rotation.T + 3.0, sliding))
    np.testing.assert_allclose(turned, expected, rtol=1e-7, atol=1e-7 * expected.max())  # 3 cm of 0.25: 12 roundings
    mirrored = pressing_at(with_friction(fabric, YARN)[2], flat(nodes * [1, -1, 1], sliding))
    assert (mirrored > 0).sum() > 5


def test_the_yarns_of_a_stitch_contact_pull_across_its_axis():
    # u: 0 1 2 3 and v: 4 1 2 5; the axis joins nodes 1 and 2, and each yarn pulls to its side
    link = np.full((6, 4), -1)
    for yarn, c in (((0, 1, 2, 3), 0), ((4, 1, 2, 5), 1)):
        for before, after in itertools.pairwise(yarn):
            own, other = (c if before in (1, 2) else 0), (c if after in (1, 2) else 0)
            link[before, 2 * own], link[after, 2 * other + 1] = 2 * after + other, 2 * before + own
    np.testing.assert_array_equal(contact_axes(link), [-1, 0, 1, -1, -1, -1])


def test_forces_and_products_are_derivatives_on_both_sides_of_the_limit():
    fabric = plain_weave(3, 3, SPACING)
    _elements, _yarns, friction = with_friction(fabric, YARN)
    state = disturbed(fabric, size=0.02)
    friction.begin_step(vector_of(*split(state)), 0.0, 0.0)
    slope = differences(lambda values: energy_at(friction, values), state, 1e-7)
    force = force_at(friction, state)
    np.testing.assert_allclose(
        force, -slope, rtol=0, atol=1e-5 * np.abs(force).max()
    )  # rounding of 1e-16 / 1e-7 in sums
    matrix = differences(lambda values: -force_at(friction, values), state, 1e-7)
    np.testing.assert_allclose(hessian_at(friction, state), matrix, rtol=0, atol=1e-7 * YARN.friction_stiffness)
    assert np.unique(np.abs(force[27:]).round(6)).size > 2


def test_the_part_of_damping_has_the_stiffness_of_the_beginning_of_the_step():
    fabric = plain_weave(3, 3, SPACING)
    _elements, _yarns, friction = with_friction(fabric, YARN)
    start, state = disturbed(fabric, size=0.02), disturbed(fabric, size=0.03)
    friction.begin_step(vector_of(*split(start)), 0.0, 1e-3)
    expected = 0.25 * hessian_at(friction, state) + 0.75 * hessian_at(friction, start)
    assert not np.allclose(hessian_at(friction, state), hessian_at(friction, start))
    friction.damped = 0.75
    np.testing.assert_allclose(hessian_at(friction, state), expected, rtol=1e-13)  # rounding


def pulled(material, amounts, feed=0.0, residual=1e-7):
    """A weave whose nodes are held, with its middle yarn pulled at its last node by amounts, one after the other.

    A share of each amount is fed at the first node.
    """
    fabric = plain_weave(COLUMNS, ROWS, SPACING)
    _elements, yarns, friction = with_friction(fabric, material)
    values = flat(fabric.position * [1.02, 1.0, 1.0], fabric.sliding)
    free = np.array([entry_of(node, 0) for node in PULLED[1:-1]])
    for amount in amounts:
        loaded = values.copy()
        loaded[entry_of(PULLED[-1], 0)] = fabric.sliding[PULLED[-1], 0] - amount
        loaded[entry_of(PULLED[0], 0)] = fabric.sliding[PULLED[0], 0] - feed * amount
        values = take_step([yarns, friction], values, free, loaded, residual)
    return fabric, friction, values, free


def test_a_yarn_that_slips_has_the_tensions_of_a_capstan():
    """The force on a coordinate is P = 1/2 k_s (|w|^2 - 1) from each side, and at each crossing P' - P = mu N.

    With N = (T + T') R / L' and P near T, T' / T is near (1 + q) / (1 - q), q = mu R / L'. The yarn turns by 4 R / L'
    at each crossing, and (1 + q) / (1 - q) is near e^(2 q): half of the angle of a capstan, because the other yarn
    has no tension and N is the mean of what both yarns need.
    """
    material = replace(SOFT, friction=0.8)
    _fabric, _friction, values, _free = pulled(material, np.linspace(0.02, 1.0, 50), feed=1.0)
    tension, q = tensions(values), 0.8 * YARN.radius / np.hypot(1.02 * SPACING, 2 * YARN.radius)
    push = tension * (1 + 0.5 * tension / YARN.stretch_stiffness)
    # the yarn runs through with tensions that no longer change, so that the limits of the step before are those of now
    np.testing.assert_allclose(np.diff(push), q * (tension[1:] + tension[:-1]), rtol=1e-6)
    strain = tension.max() / YARN.stretch_stiffness
    np.testing.assert_allclose(tension[1:] / tension[:-1], np.exp(2 * q), rtol=q**3 + strain)


def test_a_yarn_below_its_limit_does_not_drift():
    _fabric, friction, values, free = pulled(SOFT, [1e-7])
    _unused, yarns, _other = with_friction(_fabric, SOFT)
    anchors = friction.anchor.numpy().copy()
    np.testing.assert_array_equal(anchors, _fabric.sliding)
    first = values
    for _ in range(20):
        values = take_step([yarns, friction], values, free, residual=1e-6)
    # the anchors follow the normal forces, which the rest of each search changes; the pull is 1e-7 cm
    np.testing.assert_allclose(friction.anchor.numpy(), anchors, rtol=0, atol=1e-11)
    np.testing.assert_allclose(values, first, rtol=0, atol=1e-12)


def test_other_normal_forces_let_go_only_what_is_beyond_its_limit():
    fabric = plain_weave(3, 3, SPACING)
    _elements, _yarns, friction = with_friction(fabric, SOFT)
    stretched = [flat(fabric.position * [scale, scale, 1.0], fabric.sliding) for scale in (1.05, 1.02)]
    entries = [entry_of(4, 0, 9), entry_of(4, 1, 9)]
    friction.begin_step(vector_of(*split(stretched[0])), 0.0, 1e-3)
    high, lengths = friction.limit.numpy()[4].copy(), friction.slip_length.numpy()[4].copy()
    for state in stretched:
        state[entries] += np.array([0.02, 0.9]) * lengths  # shares of 0.0396 and 0.99 of the limit
    held = force_at(friction, stretched[0])[entries]
    friction.begin_step(vector_of(*split(stretched[1])), 0.0, 1e-3)
    low = friction.limit.numpy()[4]
    assert (low < 0.9 * high).all() and low[0] > 0.0396 * high[0]
    found = force_at(friction, stretched[1])[entries]
    # coordinates of 0.25 cm are rounded to 1e-13 of the slip length
    np.testing.assert_allclose(found, [held[0], -low[1]], rtol=1e-9)


def test_the_force_rises_to_the_limit_and_the_anchor_is_dragged_beyond_it():
    fabric = plain_weave(3, 3, SPACING)
    _elements, _yarns, friction = with_friction(fabric, replace(SOFT, friction_stiffness=1e5))
    rest = flat(fabric.position * [1.05, 1.05, 1.0], fabric.sliding)
    friction.begin_step(vector_of(*split(rest)), 0.0, 0.0)
    limit, slip_length = friction.limit.numpy()[4, 0], friction.slip_length.numpy()[4, 0]
    assert limit == pytest.approx(0.5 * friction.normal_forces.pressing.numpy()[4])
    assert slip_length == pytest.approx(2 * limit / 1e5) and slip_length > SLIP_SHARE * YARN.radius
    entry = entry_of(4, 0, 9)
    for part, force in ((-0.5, 0.75), (0.25, 0.4375), (1.0, 1.0), (-3.0, 1.0)):
        state = rest.copy()
        state[entry] += part * slip_length
        # m (s / e) (2 - s / e); coordinates of 0.25 cm are rounded to 1e-13 of the slip length
        assert force_at(friction, state)[entry] == pytest.approx(-np.sign(part) * force * limit, rel=1e-10)
        friction.end_step(vector_of(*split(state)), 0.0, 0.0)
        dragged = friction.anchor.numpy()[4, 0] - fabric.sliding[4, 0]
        assert dragged == pytest.approx((part + 1.0) * slip_length if part < -1.0 else 0.0, abs=1e-10 * slip_length)


def test_a_yarn_that_is_pulled_out_until_hardly_any_is_left_keeps_the_order_of_its_nodes():
    """Of 2 cm of yarn between held ends 1 mm is left, half a merging distance for each segment."""
    amounts = np.linspace(0.1, 1.9, 19)
    _fabric, _friction, values, _free = pulled(SOFT, amounts, residual=1.0)
    rest = np.diff(split(values)[1][PULLED, 0])
    assert (rest > 0.0).all() and rest.sum() == pytest.approx(0.1, rel=1e-12)


def test_a_run_that_is_resumed_has_the_same_bits():
    material = replace(YARN, yield_curvature=0.5, friction=0.01)
    fabric = plain_weave(4, 4, SPACING)
    path = [vector_of(*split(disturbed(fabric, seed=step, size=0.05))) for step in range(6)]

    def run(terms, states):
        for before, after in itertools.pairwise(states):
            for term in terms:
                term.begin_step(before, 0.0, 0.0)
            for term in terms:
                term.end_step(after, 0.0, 0.0)

    _elements, *terms = with_friction(fabric, material)
    run(terms, path[:4])
    kept = {name: array.numpy().copy() for term in terms for name, array in term.arrays().items()}
    run(terms, path[3:])
    _elements, *resumed = with_friction(fabric, material)
    for term in resumed:
        term.resume(kept)
    run(resumed, path[3:])
    for own, other in zip(terms, resumed, strict=True):
        for name, array in own.arrays().items():
            if name in ("yarn rest angles", "friction anchors"):
                assert (array.numpy() != kept[name]).any()
            np.testing.assert_array_equal(other.arrays()[name].numpy(), array.numpy())
        np.testing.assert_array_equal(force_at(other, disturbed(fabric)), force_at(own, disturbed(fabric)))


@pytest.mark.parametrize("mu", [0.0, 1e6])
def test_no_and_endless_friction_are_finite(mu):
    fabric = plain_weave(3, 3, SPACING)
    _elements, _yarns, friction = with_friction(
        fabric, replace(YARN, friction=mu, friction_stiffness=1e6 if mu else 0.0)
    )
    for state in (
        flat(fabric.position, fabric.sliding),
        disturbed(fabric),
        flat(0 * fabric.position, 0 * fabric.sliding),
    ):
        friction.begin_step(vector_of(*split(state)), 0.0, 1e-3)
        assert np.isfinite(energy_at(friction, state)) and np.isfinite(force_at(friction, state)).all()
        friction.end_step(vector_of(*split(state)), 0.0, 0.0)
        assert np.isfinite(friction.anchor.numpy()).all()


def test_limits_stay_while_an_equilibrium_is_sought_and_change_with_its_end():
    fabric = plain_weave(3, 3, SPACING)
    _elements, _yarns, friction = with_friction(fabric, YARN)
    states = [vector_of(fabric.position * scale, fabric.sliding) for scale in (1.01, 1.02)]
    limits = []
    for state, time_step in ((states[0], 0.0), (states[1], 0.0), (states[1], 1e-3), (states[0], 0.0)):
        friction.begin_step(state, 0.0, time_step)
        limits.append(friction.limit.numpy()[4, 0])
    assert limits[0] == limits[1] < limits[2] == limits[3]
    friction.end_step(states[0], 0.0, 0.0)
    friction.begin_step(states[0], 0.0, 0.0)
    assert friction.limit.numpy()[4, 0] == limits[0]


def test_fixed_coordinates_and_ends_have_no_friction():
    fabric = plain_weave(3, 3, SPACING)
    _elements, _yarns, friction = with_friction(fabric, YARN, slides=np.arange(9) != 4)
    state = disturbed(fabric, size=0.05)
    friction.begin_step(vector_of(*split(state)), 0.0, 0.0)
    force = split(force_at(friction, state))[1]
    assert not force[4].any() and force[1].any()
