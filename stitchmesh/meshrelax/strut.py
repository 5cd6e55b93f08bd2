# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wale strut: consecutive wale edges want to lie in one line (Yuksel et al. 2012, equation 4).

For a wale edge from i to j and the next from j to k, with d = x_i - x_k, the force on i is

    f = -kappa (|d| / r - 1) d / |d|,    r = max(r_wale, |x_i - x_j| + |x_k - x_j|)

and the opposite on k. By the triangle inequality r is never shorter than d, so the strut only ever pushes. Where r is
the length of the two edges it changes with them: when the ends part along n = d / |d| by s, r grows by s |d| / r in a
strut bent evenly, and the force changes along n by

    -(kappa / r) (1 - (|d| / r)^2) s,    or -(kappa / r) s where r = r_wale

which vanishes on a straight wale, as the force does. Taking r for constant there makes the iteration unstable. The
part across n, (1/|d| - 1/r) kappa, is never negative and is dropped, so the Jacobian stays negative semidefinite.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray

SHORTEST = 1e-9
"""Length over rest length below which a strut has no direction to push in."""


def strut_force(lower: FloatArray, upper: FloatArray, wale: float, stiffness: float) -> tuple[FloatArray, FloatArray]:
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
    edges = np.linalg.norm(lower, axis=1) + np.linalg.norm(upper, axis=1)
    rest = np.maximum(wale, edges)
    length = np.linalg.norm(span, axis=1)
    normal = span / np.maximum(length, SHORTEST * rest)[:, None]
    along = (-stiffness / rest) * np.where(edges > wale, 1.0 - (length / rest) ** 2, 1.0)
    jacobian = along[:, None, None] * (normal[:, :, None] * normal[:, None, :])
    return (-stiffness * (length / rest - 1.0))[:, None] * normal, jacobian
