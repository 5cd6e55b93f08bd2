# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wale strut: a force that straightens consecutive wale edges (Yuksel et al. 2012, equation 4).

For a wale edge from i to j and the next wale edge from j to k, with d = x_i - x_k, the force on i is

    f = -kappa (|d| / r - 1) d / |d|,    r = max(r_wale, |x_i - x_j| + |x_k - x_j|)

and the force on k is the opposite. By the triangle inequality r is at least |d|, so that a strut only pushes. If r is
the summed length of the two edges, it depends on the positions. When the ends of a symmetrically bent strut move apart
by s along n = d / |d|, r grows by s |d| / r, and the force along n changes by

    -(kappa / r) (1 - (|d| / r)^2) s,    or by -(kappa / r) s if r = r_wale

This change vanishes for a straight wale, and so does the force. A Jacobian with constant r would make the iteration
unstable. The derivative perpendicular to n, (1/|d| - 1/r) kappa, is never negative. It is dropped, so that the Jacobian
is negative semidefinite.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray

SHORTEST = 1e-9
"""Length divided by rest length below which the direction of a strut, and with it the force, is reduced to zero."""


def strut_force(
    lower: FloatArray, upper: FloatArray, wale: FloatArray | float, stiffness: float
) -> tuple[FloatArray, FloatArray]:
    """Compute the force on the lower end of struts and its negative semidefinite Jacobian with respect to the span d.

    Args:
        lower: vector from the middle vertex to the lower vertex, x_i - x_j [cm], shape (S, 3).
        upper: vector from the middle vertex to the upper vertex, x_k - x_j [cm], shape (S, 3).
        wale: rest length of the wale edges [cm] of each strut, shape (S,), or one for all struts.
        stiffness: kappa, dimensionless.

    Returns:
        Forces, shape (S, 3), and Jacobians [1/cm], shape (S, 3, 3).
    """
    span = lower - upper
    edges = np.linalg.norm(lower, axis=1) + np.linalg.norm(upper, axis=1)
    rest = np.maximum(wale, edges)
    length = np.linalg.norm(span, axis=1)
    normal = span / np.maximum(length, SHORTEST * rest)[:, None]
    along = (-stiffness / rest) * np.where(edges > wale, 1.0 - (length / rest) ** 2, 1.0)
    jacobian = along[:, None, None] * (normal[:, :, None] * normal[:, None, :])
    return (-stiffness * (length / rest - 1.0))[:, None] * normal, jacobian
