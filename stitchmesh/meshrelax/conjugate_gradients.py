# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conjugate gradients with constraints (Baraff and Witkin 1998, section 5.3).

Each vertex may move only in its allowed directions: the tangent plane, the tangent of a border, or no direction. The
solution contains only allowed directions, and only the residual in these directions must vanish. The filter that
removes all other directions is part of the preconditioner. The algorithm uses the residual only after preconditioning,
so that no separate filter is needed.
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
        matrix: matrix of the system, shape (3V, 3V).
        right: right-hand side, shape (3V,).
        filtered_preconditioner: symmetric preconditioner, positive definite in the allowed directions and zero in all
            others.
        tolerance: residual over the right-hand side at which the solution has converged, both in the norm of the
            preconditioner.
        max_iterations: largest number of iterations; also after these the solution is a descent direction.

    Returns:
        The solution, shape (3V,), and the number of iterations.
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
