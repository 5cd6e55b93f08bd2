# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conjugate gradients within constraints (Baraff and Witkin 1998, section 5.3).

Each vertex may move in some directions only: the tangent plane, the tangent of a border, or none. The solution stays
in them, and the residual is only asked to vanish there. The filter that removes the other directions is part of the
preconditioner: wherever the residual is used it has passed through it, so it needs no filter of its own.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import bsr_array

from stitchmesh.mesh import FloatArray
from stitchmesh.meshrelax.preconditioner import Preconditioner


def modified_conjugate_gradients(
    matrix: bsr_array,
    right: FloatArray,
    filtered_preconditioner: Preconditioner,
    *,
    tolerance: float,
    max_iterations: int,
) -> tuple[FloatArray, int]:
    """Solve a symmetric positive definite system within the allowed directions.

    Args:
        matrix: shape (3V, 3V).
        right: right-hand side, shape (3V,).
        filtered_preconditioner: symmetric, positive definite within the allowed directions and blind to the others.
        tolerance: residual over right-hand side at which to stop, both in the preconditioner's norm.
        max_iterations: iterations after which to stop anyway; the iterate then still descends.

    Returns:
        The solution, shape (3V,), and the iterations taken.
    """
    solution = np.zeros_like(right)
    residual = right.copy()
    direction = filtered_preconditioner(residual)
    size = float(residual @ direction)
    goal = tolerance**2 * size
    for iteration in range(max_iterations):
        if size <= goal:
            return solution, iteration
        image = matrix @ direction
        length = size / float(direction @ image)
        solution += length * direction
        residual -= length * image
        conditioned = filtered_preconditioner(residual)
        previous, size = size, float(residual @ conditioned)
        direction *= size / previous
        direction += conditioned
    return solution, max_iterations
