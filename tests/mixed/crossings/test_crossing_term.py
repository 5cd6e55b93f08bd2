# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Energies of the star of a crossing node: derivatives, invariance, closed forms, extremes."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from stitchmesh.mixed.crossings.crossing_term import CrossingTerm
from tests.mixed.crossings.small_fabrics import (
    CPU,
    YARN,
    differences,
    disturbed,
    energy_at,
    force_at,
    hessian_at,
    plain_weave,
    single_yarn,
    softened,
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
    return CrossingTerm(fabric.elements(material, **changes), scalar, CPU)


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
