# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The weight of crossing yarns, on positions and on coordinates."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.crossings.yarn_gravity import YarnGravity
from tests.mixed.crossings.small_fabrics import (
    CPU,
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
)

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


def test_fixed_coordinates_have_no_weight():
    fabric = plain_weave(3, 3)
    free = np.arange(9) % 2 == 0
    state = disturbed(fabric)
    assert not split(force_at(weight_of(fabric, slides=free), state))[1][~free].any()
    matrix = hessian_at(weight_of(fabric, slides=free), state)
    fixed = np.concatenate([np.zeros(27, dtype=bool), np.repeat(~free, 2)])
    assert not matrix[fixed].any() and not matrix[:, fixed].any()


def test_a_wrong_acceleration_is_refused():
    with pytest.raises(ParameterError, match="expected three finite numbers"):
        YarnGravity(plain_weave(2, 2).elements(), wp.float64, CPU, (0.0, np.inf, 0.0))
