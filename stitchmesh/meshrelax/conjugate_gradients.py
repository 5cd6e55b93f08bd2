# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conjugate gradients within constraints (Baraff and Witkin 1998, section 5.3).

Each vertex has a projector onto the directions in which it may move: the tangent plane, the tangent of a border, or
none. The solution stays in them, and the residual is only asked to vanish there. The preconditioner is the inverse of
each vertex's diagonal block within its allowed directions; as it removes the residual's forbidden part wherever the
residual is used, that part needs no filter of its own.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import bsr_array

from stitchmesh.mesh import FloatArray


def filtered_preconditioner(diagonal: FloatArray, projector: FloatArray) -> bsr_array:
    """Inverse of the diagonal blocks within the allowed directions.

    Args:
        diagonal: symmetric positive definite blocks, shape (V, 3, 3).
        projector: projectors onto the allowed directions, shape (V, 3, 3).
    """
    forbidden = np.eye(3) - projector
    inverse = projector @ np.linalg.inv(projector @ diagonal @ projector + forbidden) @ projector
    count = len(diagonal)
    return bsr_array((inverse, np.arange(count), np.arange(count + 1)), shape=(3 * count, 3 * count))


def filtered_conjugate_gradients(
    matrix: bsr_array,
    right: FloatArray,
    preconditioner: bsr_array,
    *,
    tolerance: float,
    max_iterations: int,
) -> tuple[FloatArray, int]:
    """Solve a symmetric positive definite system within the allowed directions.

    Args:
        matrix: shape (3V, 3V).
        right: right-hand side, shape (3V,).
        preconditioner: from ``filtered_preconditioner``.
        tolerance: residual over right-hand side at which to stop, both in the preconditioner's norm.
        max_iterations: iterations after which to stop anyway; the iterate then still descends.

    Returns:
        The solution, shape (3V,), and the iterations taken.
    """
    solution = np.zeros_like(right)
    residual = right.copy()
    direction = preconditioner @ residual
    size = float(residual @ direction)
    goal = tolerance**2 * size
    for iteration in range(max_iterations):
        if size <= goal:
            return solution, iteration
        image = matrix @ direction
        length = size / float(direction @ image)
        solution += length * direction
        residual -= length * image
        conditioned = preconditioner @ residual
        previous, size = size, float(residual @ conditioned)
        direction *= size / previous
        direction += conditioned
    return solution, max_iterations
