# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Point loads in the relaxer: energy, force, and the strain that a load causes in a yarn."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.errors import ParameterError
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.collision.narrow_phase import make_candidates
from stitchmesh.yarnrelax.constraints.pins import Pins
from stitchmesh.yarnrelax.energies import evaluation
from stitchmesh.yarnrelax.energies.point_load import PointLoad
from stitchmesh.yarnrelax.model.state import make_state
from stitchmesh.yarnrelax.model.upload import put_model

EXACT = Quality("float64", 3, 3, 12, 0.2, 1e-6, 20_000)
"""Three Gauss points integrate the energy of a uniform stretch exactly."""
SPACING = 0.5


def straight_yarn(segments: int = 30) -> YarnSet:
    points = np.zeros((segments + 3, 3))
    points[:, 0] = SPACING * np.arange(segments + 3)
    return YarnSet.from_curves([points], closed=[False], radius=0.2)


def wavy_yarns() -> YarnSet:
    """A closed and an open yarn; the seed is fixed."""
    noise = np.random.default_rng(5)
    return YarnSet.from_curves(
        [noise.normal(size=(9, 3)), noise.normal(size=(7, 3)) + 5.0], closed=[True, False], radius=[0.01, 0.03]
    )


def load_of(yarns: YarnSet, choice: PointLoad, points: np.ndarray) -> tuple[float, np.ndarray]:
    """Energy [erg] and forces on the control points [dyn] of a point load alone, with control points at ``points``."""
    model = put_model(
        yarns, YarnMaterial.named("leaf"), quadrature_points=3, contact_samples=2, scalar=scalar_named("float64"),
        device=device_named("cpu"),
    )  # fmt: skip
    state, candidates, term = make_state(model, external=True), make_candidates(model, 1e-4), choice.on(model)
    state.points.assign(model.to_device(points))
    term.forces(state, candidates, model.launch)
    assert not term.stiffness().any()
    evaluation.gather_launch(model, state, model.empty(model.point_count), model.launch)
    return term.energy(state, candidates), state.force.numpy().astype(np.float64) / model.unit


def test_force_is_minus_the_gradient() -> None:
    yarns, choice = wavy_yarns(), PointLoad((100.0, -9.0, 30.0), [2, 11, 4])
    force = load_of(yarns, choice, yarns.points)[1]
    direction = np.random.default_rng(3).normal(size=yarns.points.shape)
    ends = [load_of(yarns, choice, yarns.points + side * direction)[0] for side in (0.5, -0.5)]
    # The energy is linear in the points, so the only error is rounding: 1e-16 of energies whose difference is of
    # about their own size.
    assert ends[0] - ends[1] == pytest.approx(-(force * direction).sum(), rel=1e-13)


def test_the_force_is_divided_equally_among_the_points() -> None:
    yarns = wavy_yarns()
    force = load_of(yarns, PointLoad((6.0, 0.0, -3.0), [2, 11, 4]), yarns.points)[1]
    expected = np.zeros_like(force)
    expected[[2, 4, 11]] = [2.0, 0.0, -1.0]
    np.testing.assert_allclose(force, expected, rtol=1e-15, atol=1e-15)  # rounding of the division


def test_the_strain_of_a_yarn_under_tension() -> None:
    """The tension is dE / d(lambda l) = 2 (k_len + k_length) (lambda - 1) / l.

    E = (k_len + k_length) (lambda - 1)^2 is the energy of a segment of rest length l.
    """
    yarns, tension = straight_yarn(), 1000.0
    material = YarnMaterial(2000.0, 1000.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    held, pulled = np.arange(4), len(yarns.points) - np.arange(1, 5)
    result = relax_yarns(
        yarns, material=material, quality=EXACT, device="cpu",
        terms=[PointLoad((tension, 0.0, 0.0), pulled), Pins(held)],
    )  # fmt: skip
    assert result.report["converged"]
    strain = tension * SPACING / (2.0 * (material.k_len + material.k_length))
    # Near the held control points, the strain of the spline is not uniform; ten segments away it is.
    np.testing.assert_allclose(result.yarns.strain[10:-10], strain, rtol=1e-3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"force": (0.0, 1.0)}, r"got force .* expected three finite numbers"),
        ({"force": (0.0, np.nan, 0.0)}, r"got force .* expected three finite numbers"),
        ({"force": 3.0}, r"got force .* expected three finite numbers"),
        ({"points": [0, 33]}, "got control point 33; expected 0 to 32"),
        ({"faces": [2]}, "got stitch face 2; no control point came from it"),
        ({}, "got neither control points nor stitch faces"),
    ],
)
def test_bad_point_loads_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=f"point load: {message}"):
        relax_yarns(straight_yarn(), device="cpu", terms=[PointLoad(**{"force": (1.0, 0.0, 0.0)} | options)])
