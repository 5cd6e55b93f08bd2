# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""L's test of convergence, eq 5."""

from __future__ import annotations

import sys
from importlib import import_module

import numpy as np
import pytest
from numpy.typing import NDArray

from stitchmesh.compute.device import device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import make_state
from stitchmesh.yarnrelax.model.upload import put_model
from tests.gallery import ROOT
from tests.yarnrelax.stockinette import flat_patch

sys.path.insert(0, str(ROOT / "benchmarks"))
leaf_convergence = import_module("leaf_convergence")
GradientNorms, first_converged = leaf_convergence.GradientNorms, leaf_convergence.first_converged


def norms(*values: float) -> NDArray[np.float64]:
    return np.array(values)


def test_it_asks_for_a_small_gradient_and_a_level_one() -> None:
    assert first_converged(norms(10.0, 5.0, 5.0, 0.9, 0.5)) is None  # level while large, small while falling
    assert first_converged(norms(10.0, 5.0, 0.9, 0.9, 0.5)) == 3
    assert first_converged(norms(10.0, 10.0, 10.0)) is None


@pytest.mark.parametrize(("change", "found"), [(0.9e-5, 2), (-0.9e-5, 2), (1.1e-5, None), (-1.1e-5, None)])
def test_level_means_a_change_of_at_most_a_hundred_thousandth(change: float, found: int | None) -> None:
    assert first_converged(norms(1.0, 0.05, 0.05 * (1.0 + change))) == found


@pytest.mark.parametrize(("part", "found"), [(0.1, 2), (0.1001, None)])
def test_small_means_a_tenth_of_the_first(part: float, found: int | None) -> None:
    assert first_converged(norms(7.0, 7.0 * part, 7.0 * part)) == found


def test_it_may_be_asked_to_hold_for_a_while() -> None:
    history = norms(10.0, 0.9, 0.9, 0.5, 0.5, 0.5)
    assert first_converged(history, in_a_row=2) == 5
    assert first_converged(history, in_a_row=3) is None


def test_a_run_that_has_not_begun_has_not_converged() -> None:
    assert first_converged(norms()) is None
    assert first_converged(norms(0.0)) is None


def test_yarns_without_any_force_converge_at_once() -> None:
    assert first_converged(norms(0.0, 0.0)) == 1


def test_what_is_not_a_number_never_converges() -> None:
    assert first_converged(norms(1.0, np.nan, np.nan)) is None


def model_of_a_patch() -> Model:
    material, scalar, device = YarnMaterial.named("leaf"), scalar_named("float64"), device_named("cpu")
    return put_model(flat_patch(2, 2), material, quadrature_points=3, contact_samples=3, scalar=scalar, device=device)


def test_the_ring_hands_out_the_norms_in_their_order() -> None:
    model = model_of_a_patch()
    state, kept = make_state(model), GradientNorms(model, 4)
    gradients = np.random.default_rng(1).normal(size=(7, model.point_count, 3))
    expected = np.sqrt((gradients**2).sum(axis=(1, 2)))
    seen = []
    for k, gradient in enumerate(gradients):
        state.force.assign(gradient)
        kept.launches(state, model.launch)
        if k in (2, 6):
            seen += list(kept.new())
    assert len(kept.new()) == 0
    np.testing.assert_allclose(seen, expected, rtol=1e-14)  # sums of squares in another order


def test_a_ring_that_is_too_short_keeps_the_newest() -> None:
    model = model_of_a_patch()
    state, kept = make_state(model), GradientNorms(model, 2)
    for size in (1.0, 2.0, 3.0):
        state.force.assign(np.full((model.point_count, 3), size))
        kept.launches(state, model.launch)
    scale = np.sqrt(3 * model.point_count)
    np.testing.assert_allclose(kept.new(), [2.0 * scale, 3.0 * scale], rtol=1e-14)
