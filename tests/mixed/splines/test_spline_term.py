# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The term of B-spline yarns: derivatives, rigid motion, the balance of the layout, and the guard against passing."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.launch import launch
from stitchmesh.errors import SolverError
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.splines.spline_pieces import SplineMaterial, spline_pieces
from stitchmesh.mixed.splines.spline_term import SplineTerm
from stitchmesh.yarn import YarnSet
from tests.mixed.splines.jersey import CPU, RADIUS, built, jersey
from tests.mixed.triangles.derivatives import rotation, slope

RUN = partial(launch, device=CPU)
STEP = 2e-7
"""Step of differences [cm]: small beside the distance, a thousandth of a radius, at which pairs begin to touch."""


def term_of(scene) -> SplineTerm:
    return next(term for term in scene.system.terms if isinstance(term, SplineTerm))


def shaken(scene, scalar=wp.float64):
    """The start with random displacements of a fiftieth of a radius, and a random direction."""
    random = np.random.default_rng(3)
    v, p, s = scene.positions.numpy()
    state = MixedVector.from_numpy(
        v + random.normal(size=v.shape) * RADIUS / 50, p + random.normal(size=p.shape) * RADIUS / 50, s, scalar, CPU
    )
    direction = MixedVector.from_numpy(random.normal(size=v.shape), random.normal(size=p.shape), 0 * s, scalar, CPU)
    return state, direction


def moved(state: MixedVector, direction: MixedVector, distance: float) -> MixedVector:
    result = state.copy()
    result.values.assign(state.values.numpy() + distance * direction.values.numpy())
    return result


def forces(term: SplineTerm, state: MixedVector) -> np.ndarray:
    force = state.like()
    term.forces(state, force, RUN)
    return force.values.numpy()


def product(term: SplineTerm, state: MixedVector, direction: MixedVector, exact: float = 1.0) -> np.ndarray:
    term.exact = exact
    term.linearize(state, RUN)
    result = state.like()
    term.products(direction, result, RUN)
    return result.values.numpy()


def test_forces_and_products_are_derivatives():
    scene = built("middle")
    term, (state, direction) = term_of(scene), shaken(scene)
    term.begin_step(state, 0.0, 0.0)
    rise = slope(lambda d: term.energy(moved(state, direction, d)), STEP)
    along = direction.values.numpy()
    # rounding of an energy of 1e4 erg, 1e-12, over the step
    assert rise == pytest.approx(-forces(term, state) @ along, abs=1e-4)
    change = slope(lambda d: -forces(term, moved(state, direction, d)), STEP)
    found = product(term, state, direction)
    # rounding of forces of 1e3 dyn, 1e-13, over the step, beside products of 1e6 dyn / cm
    np.testing.assert_allclose(found, change, atol=1e-6 * np.abs(found).max())


def test_the_matrix_far_from_rest_is_never_negative_and_has_the_blocks_of_the_diagonal():
    scene = built("middle")
    term, (state, direction) = term_of(scene), shaken(scene)
    term.begin_step(state, 0.0, 0.0)
    along = direction.values.numpy()
    assert along @ product(term, state, direction, exact=0.0) > 0.0
    blocks = MixedBlocks.zeros(state.vertex_count, state.node_count, wp.float64, CPU)
    term.diagonal(blocks, RUN)
    vertices, nodes, sliding = (np.zeros_like(part) for part in state.numpy())
    for node in (5, 50):
        columns = []
        for axis in range(3):
            nodes[node, axis] = 1.0
            unit = MixedVector.from_numpy(vertices, nodes, sliding, wp.float64, CPU)
            columns.append(product(term, state, unit, exact=0.0)[3 * state.vertex_count :].reshape(-1)[3 * node :][:3])
            nodes[node, axis] = 0.0
        block = blocks.nodes.numpy()[node]
        # pairs of samples that both depend on a control point are left out
        np.testing.assert_allclose(block, np.array(columns).T, atol=1e-9 * np.abs(block).max())


def test_forces_turn_with_the_cloth():
    """Yarns of the region and carried yarns beside it: no direction in space is another one than the others."""
    cloth, yarns, _pinned = jersey()
    scene = built("middle")
    term, turn, shift, found = term_of(scene), rotation(), np.array([3.0, -2.0, 5.0]), []
    for axes, offset in ((np.eye(3), np.zeros(3)), (turn, shift)):
        places = yarns.curves.points[scene.region.nodes] @ axes.T + offset
        state = MixedVector.from_numpy(
            cloth.vertices @ axes.T + offset, places, np.zeros((len(places), 2)), wp.float64, CPU
        )
        term.begin_step(state, 0.0, 0.0)
        found.append(forces(term, state)[: -2 * len(places)].reshape(-1, 3) @ axes)
    assert np.abs(found[0]).max() > 1.0  # weights that differ from loop to loop leave forces in the ring
    np.testing.assert_allclose(found[1], found[0], atol=1e-8)  # rounding of some hundred dyn, 1e-12
    np.testing.assert_allclose(found[0].sum(axis=0), 0.0, atol=1e-8)  # no load from outside


@pytest.mark.nightly
def test_single_precision_agrees():
    single, double = built("middle", scalar=wp.float32), built("middle")
    state, _ = shaken(double)
    rounded = MixedVector.from_numpy(*state.numpy(), wp.float32, CPU)
    terms = term_of(single), term_of(double)
    for term, at in zip(terms, (rounded, state), strict=True):
        term.begin_step(at, 0.0, 0.0)
    # strains and gaps are differences of coordinates of 1 cm, rounded to 1e-7, over lengths of a radius
    assert terms[0].energy(rounded) == pytest.approx(terms[1].energy(state), rel=1e-4)
    found, expected = forces(terms[0], rounded), forces(terms[1], state)
    np.testing.assert_allclose(found, expected, atol=5e-3 * np.abs(expected).max())


def test_no_sum_of_moves_leads_a_yarn_through_another_one():
    along = np.linspace(-1.0, 1.0, 9)
    lower = np.stack([along, 0 * along, 0 * along], axis=1)
    upper = np.stack([0 * along, along, 0 * along + 4 * RADIUS], axis=1)
    curves = YarnSet.from_curves([lower, upper], closed=[False, False], radius=RADIUS)
    term = SplineTerm(spline_pieces(curves), SplineMaterial.named(radius=RADIUS), wp.float64, CPU)
    points, down = curves.points.copy(), np.zeros((18, 3))
    down[9:, 2] = -1.0
    none = np.zeros((18, 2))
    direction = MixedVector.from_numpy([], down, none, wp.float64, CPU)
    with pytest.raises(SolverError, match="too close"):
        for _ in range(100):
            part = term.step_limit(MixedVector.from_numpy([], points, none, wp.float64, CPU), direction)
            assert 0.0 <= part < 1.0
            points = points + part * down
    assert points[9:, 2].min() > 0.0  # the axes have not met
    together = MixedVector.from_numpy([], down * 0.0 + [5.0, -3.0, 1.0], none, wp.float64, CPU)
    start = MixedVector.from_numpy([], curves.points, none, wp.float64, CPU)
    assert term.step_limit(start, together) == 1.0  # no distance changes
    away = MixedVector.from_numpy([], -0.01 * down, none, wp.float64, CPU)
    assert term.step_limit(MixedVector.from_numpy([], curves.points, none, wp.float64, CPU), away) == 1.0


def test_pieces_hold_the_segments_that_exist_once():
    _cloth, yarns, _pinned = jersey()
    curves = yarns.curves
    alpha = np.where(np.random.default_rng(0).random(len(curves.rest_length)) < 0.8, 0.5, 0.0)
    pieces = spline_pieces(curves, alpha=alpha)
    assert len(pieces.alpha) == (alpha > 0.0).sum() == len(pieces.curves.rest_length)
    assert len(np.unique(pieces.node[pieces.curves.segment_points], axis=0)) == len(pieces.alpha)
    ring = YarnSet.from_curves([np.random.default_rng(1).normal(size=(7, 3))], closed=[True], radius=0.1)
    assert spline_pieces(ring).curves.closed.all()
    cut = spline_pieces(ring, alpha=[1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0])
    assert not cut.curves.closed.any() and len(cut.alpha) == 6
    np.testing.assert_array_equal(cut.curves.rest_length, ring.rest_length[[3, 4, 5, 6, 0, 1]])
    assert spline_pieces(ring, alpha=np.zeros(7)).curves is None
