# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pins hold control points and whole loops at their positions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.constraints.pins import Pins
from stitchmesh.yarnrelax.model.state import make_state
from tests.yarnrelax.one_term import on_device
from tests.yarnrelax.stockinette import flat_patch

MATTER = YarnMaterial.named("leaf")
HELD = 1e-6
"""Rounding of coordinates of about ten radii in single precision, over the radius."""


def tight_patch() -> YarnSet:
    """Two rows of three stitches whose rest lengths are a tenth shorter than their lengths."""
    patch = flat_patch(2, 3)
    return replace(patch, rest_length=0.9 * patch.rest_length)


def test_pinned_points_have_no_force_and_take_no_step() -> None:
    yarns = tight_patch()
    model = on_device(yarns)
    values = np.random.default_rng(2).normal(size=yarns.points.shape)
    force, step = model.upload(values, 3), model.upload(values, 3)
    held = Pins([4, 0, 71]).on(model)
    held.filter_forces(force, model.launch)
    held.filter_steps(make_state(model), step, model.empty(model.point_count), model.launch)
    for vectors in (force.numpy(), step.numpy()):
        assert np.flatnonzero((vectors == 0.0).all(axis=1)).tolist() == [0, 4, 71]
        free = np.delete(np.arange(len(values)), [0, 4, 71])
        assert np.array_equal(vectors[free], values[free])
    coupling = held.coupling()  # whose rows are the coordinates of the pinned points
    assert coupling.compliance is None
    assert np.array_equal((coupling.rows @ values.ravel()).reshape(-1, 3), values[[0, 4, 71]])


def test_pinned_loops_do_not_move_while_the_others_relax() -> None:
    yarns = tight_patch()
    pins = Pins(points=[20], faces=[0, 5])
    result = relax_yarns(yarns, material=MATTER, quality="draft", device="cpu", terms=[pins])
    assert result.report["converged"]
    moved = np.linalg.norm(result.yarns.points - yarns.points, axis=1) / yarns.radius[0]
    held = np.zeros(len(moved), dtype=bool)
    held[20] = True
    held[(yarns.face == 0) | (yarns.face == 5)] = True
    assert moved[held].max() < HELD * 10
    assert np.median(moved[~held]) > 0.1


def test_yarns_with_all_points_pinned_are_at_rest_immediately() -> None:
    yarns = tight_patch()
    pins = Pins(np.arange(len(yarns.points)))
    result = relax_yarns(yarns, material=MATTER, quality="draft", device="cpu", terms=[pins])
    assert result.report["converged"]
    assert result.report["residual"] == 0.0
    assert result.report["iterations"] == 0
    np.testing.assert_allclose(result.yarns.points, yarns.points, atol=HELD * 10 * yarns.radius[0])


@pytest.mark.parametrize(
    ("pins", "message"),
    [
        (Pins([0, 72]), r"control point 72; expected 0 to 71"),
        (Pins([-1]), r"control point -1; expected"),
        (Pins(faces=[2, 6, 9]), r"stitch face 6, 9; no control point"),
        (Pins(faces=[-1]), r"stitch face -1"),
        (Pins(), r"neither control points nor stitch faces"),
        (Pins([0.5]), r"type float64; expected whole numbers"),
    ],
)
def test_bad_pins_are_refused(pins: Pins, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        relax_yarns(tight_patch(), material=MATTER, device="cpu", terms=[pins])
