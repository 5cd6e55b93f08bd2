# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The convergence test of Leaf et al. 2018 (L), equation 5."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.measures.solver.leaf_convergence import GradientNorms, first_converged
from stitchmesh.compute.device import device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import make_state
from stitchmesh.yarnrelax.model.upload import put_model
from tests.yarnrelax.stockinette import flat_patch


def norms(*values: float) -> NDArray[np.float64]:
    return np.array(values)


def test_the_gradient_must_be_both_small_and_constant() -> None:
    assert first_converged(norms(10.0, 5.0, 5.0, 0.9, 0.5)) is None  # constant while large, small while decreasing
    assert first_converged(norms(10.0, 5.0, 0.9, 0.9, 0.5)) == 3
    assert first_converged(norms(10.0, 10.0, 10.0)) is None


@pytest.mark.parametrize(("change", "found"), [(0.9e-5, 2), (-0.9e-5, 2), (1.1e-5, None), (-1.1e-5, None)])
def test_constant_means_a_relative_change_of_at_most_1e_5(change: float, found: int | None) -> None:
    assert first_converged(norms(1.0, 0.05, 0.05 * (1.0 + change))) == found


@pytest.mark.parametrize(("part", "found"), [(0.1, 2), (0.1001, None)])
def test_small_means_at_most_a_tenth_of_the_first_gradient(part: float, found: int | None) -> None:
    assert first_converged(norms(7.0, 7.0 * part, 7.0 * part)) == found


def test_the_test_can_be_required_for_several_iterations_in_a_row() -> None:
    history = norms(10.0, 0.9, 0.9, 0.5, 0.5, 0.5)
    assert first_converged(history, in_a_row=2) == 5
    assert first_converged(history, in_a_row=3) is None


def test_a_run_without_iterations_has_not_converged() -> None:
    assert first_converged(norms()) is None
    assert first_converged(norms(0.0)) is None


def test_yarns_without_force_converge_at_the_first_iteration() -> None:
    assert first_converged(norms(0.0, 0.0)) == 1


def test_a_nan_never_converges() -> None:
    assert first_converged(norms(1.0, np.nan, np.nan)) is None


def model_of_a_patch() -> Model:
    material, scalar, device = YarnMaterial.named("leaf"), scalar_named("float64"), device_named("cpu")
    return put_model(flat_patch(2, 2), material, quadrature_points=3, contact_samples=3, scalar=scalar, device=device)


def test_the_ring_buffer_returns_the_norms_in_order() -> None:
    model = model_of_a_patch()
    state, norms_on_device = make_state(model), GradientNorms(model, 4)
    gradients = np.random.default_rng(1).normal(size=(7, model.point_count, 3))
    expected = np.sqrt((gradients**2).sum(axis=(1, 2)))
    seen = []
    for k, gradient in enumerate(gradients):
        state.force.assign(gradient)
        norms_on_device.launches(state, model.launch)
        if k in (2, 6):
            seen += list(norms_on_device.new())
    assert len(norms_on_device.new()) == 0
    np.testing.assert_allclose(seen, expected, rtol=1e-14)  # float64 rounding: the squares are added in another order


def test_a_ring_buffer_that_is_too_short_keeps_the_newest_norms() -> None:
    model = model_of_a_patch()
    state, norms_on_device = make_state(model), GradientNorms(model, 2)
    for size in (1.0, 2.0, 3.0):
        state.force.assign(np.full((model.point_count, 3), size))
        norms_on_device.launches(state, model.launch)
    scale = np.sqrt(3 * model.point_count)
    np.testing.assert_allclose(norms_on_device.new(), [2.0 * scale, 3.0 * scale], rtol=1e-14)
