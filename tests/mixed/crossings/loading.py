# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Steps of static equilibrium of small fabrics with friction, by Newton's method with dense matrices."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import warp as wp

from stitchmesh.mixed.crossings.crossing_elements import CrossingElements
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial
from stitchmesh.mixed.crossings.crossing_term import CrossingTerm
from stitchmesh.mixed.crossings.friction.sliding_friction import SlidingFriction
from stitchmesh.mixed.term import MixedTerm
from tests.mixed.crossings.small_fabrics import (
    CPU,
    Fabric,
    energy_at,
    force_at,
    hessian_at,
    split,
    vector_of,
)


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
