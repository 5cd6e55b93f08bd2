# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Shear force, which moves the angles of sub-quads towards right angles (Yuksel et al. 2012, equation 3).

At a corner j with neighbours i and k, let a = x_i - x_j, b = x_k - x_j and m = x_j - (x_i + x_k) / 2. The forces are

    f_j = -kappa (a . b) m / u^3,    f_i = f_k = -f_j / 2

Lengths are measured in units of u = sqrt(r_course r_wale), so that kappa is dimensionless as in the other forces. With
the weights c = (-1/2, 1, -1/2) of (i, j, k), m is the weighted sum of the positions, and the force on each vertex is
f_j times the weight of the vertex. The derivative of a . b consists of -2 c m . dx and a part along (a - b). The
Jacobian of f_j with respect to m is taken as

    -kappa (max(a . b, 0) I + 2 m m^T) / u^3

The maximum keeps the matrix negative semidefinite. The part along (a - b) is left out, because its matrix would not be
symmetric.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray


def shear_force(first: FloatArray, second: FloatArray, unit: float, stiffness: float) -> tuple[FloatArray, FloatArray]:
    """Compute the force on corners and its negative semidefinite Jacobian with respect to m.

    Args:
        first: vector from the corner to one neighbour, x_i - x_j [cm], shape (S, 3).
        second: vector from the corner to the other neighbour, x_k - x_j [cm], shape (S, 3).
        unit: size u of a stitch [cm].
        stiffness: kappa, dimensionless.

    Returns:
        Forces, shape (S, 3), and Jacobians [1/cm], shape (S, 3, 3).
    """
    scale = stiffness / unit**3
    cosine = np.einsum("si,si->s", first, second)
    middle = -0.5 * (first + second)
    jacobian = (-2.0 * scale) * (middle[:, :, None] * middle[:, None, :])
    jacobian[:, [0, 1, 2], [0, 1, 2]] -= (scale * np.maximum(cosine, 0.0))[:, None]
    return (-scale * cosine)[:, None] * middle, jacobian
