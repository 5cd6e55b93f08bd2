# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Static equilibria of small cloths by Newton's method with whole matrices."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stitchmesh.mixed.term import MixedTerm
from tests.mixed.triangles.derivatives import FloatArray, energy_of, forces_of, hessian_of


def equilibrium(terms: Sequence[MixedTerm], vertices: FloatArray, free: np.ndarray, steps: int = 100) -> FloatArray:
    """The vertices at rest.

    Args:
        terms: energies in double precision.
        vertices: start, shape (V, 3).
        free: whether each coordinate may move, shape (V, 3).
        steps: largest number of Newton steps.
    """
    index, part = np.flatnonzero(free.ravel()), 0.0
    for _step in range(steps):
        force = sum(forces_of(term, vertices) for term in terms).ravel()[index]
        size = max(float(np.abs(forces_of(term, vertices)).max()) for term in terms)
        if np.abs(force).max() < 1e-9 * size:
            return vertices
        matrix = sum(hessian_of(term, vertices, part) for term in terms)[np.ix_(index, index)]
        move = np.zeros(vertices.size)
        move[index] = np.linalg.solve(matrix + 1e-12 * np.abs(matrix).max() * np.eye(len(index)), force)
        if move[index] @ force <= 0.0:
            part = 0.0
            continue
        vertices, length = _lowered(terms, vertices, move.reshape(-1, 3))
        part = 1.0 if length == 1.0 else 0.0
    raise AssertionError(f"no equilibrium in {steps} steps: the largest force is {np.abs(force).max():g}")


def _lowered(terms: Sequence[MixedTerm], vertices: FloatArray, move: FloatArray) -> tuple[FloatArray, float]:
    """The vertices moved by the largest halved step that lowers the energy, and the part of the step."""
    before, length = sum(energy_of(term, vertices) for term in terms), 1.0
    while length > 1e-6 and sum(energy_of(term, vertices + length * move) for term in terms) > before:
        length /= 2.0
    return vertices + length * move, length
