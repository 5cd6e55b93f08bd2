# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wale strut: consecutive wale edges want to lie in one line (Yuksel et al. 2012, equation 4).

For a wale edge from i to j and the next from j to k, with d = x_i - x_k, the force on i is

    f = -kappa (|d| / r - 1) d / |d|,    r = max(r_wale, |x_i - x_j| + |x_k - x_j|)

and the opposite on k. By the triangle inequality r is never shorter than d, so the strut only ever pushes. With r held
and n = d / |d| the Jacobian by d is -kappa [n n^T / r + (1/r - 1/|d|) (I - n n^T)]; its last term is never negative
and is dropped.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray

SHORTEST = 1e-9
"""Length over rest length below which a strut has no direction to push in."""


def strut_force(
    lower: FloatArray, upper: FloatArray, wale: float, stiffness: float
) -> tuple[FloatArray, FloatArray]:
    """Force on the lower end and its semidefinite Jacobian by the span of the strut.

    Args:
        lower: from the middle vertex to the lower one, x_i - x_j [cm], shape (S, 3).
        upper: from the middle vertex to the upper one, x_k - x_j [cm], shape (S, 3).
        wale: rest length of a wale edge [cm].
        stiffness: kappa, free of units.

    Returns:
        Forces, shape (S, 3), and Jacobians [1/cm], shape (S, 3, 3).
    """
    span = lower - upper
    rest = np.maximum(wale, np.linalg.norm(lower, axis=1) + np.linalg.norm(upper, axis=1))
    length = np.linalg.norm(span, axis=1)
    normal = span / np.maximum(length, SHORTEST * rest)[:, None]
    jacobian = (-stiffness / rest)[:, None, None] * (normal[:, :, None] * normal[:, None, :])
    return (-stiffness * (length / rest - 1.0))[:, None] * normal, jacobian
