# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Shear: sub-quads want right angles (Yuksel et al. 2012, equation 3).

At a corner j with neighbours i and k, let a = x_i - x_j, b = x_k - x_j and m = x_j - (x_i + x_k) / 2. The forces are

    f_j = -kappa (a . b) m / u^3,    f_i = f_k = -f_j / 2

with lengths measured in u = sqrt(r_course r_wale), which makes kappa free of units as in the other forces. With the
weights c = (-1/2, 1, -1/2) of (i, j, k), m = sum c x and every vertex's force is c times f_j. As a.b changes by
-2 c m . dx plus a part along (a - b), the Jacobian of f_j by m is

    -kappa (max(a . b, 0) I + 2 m m^T) / u^3

where the clamp and the part left out, which no symmetric matrix holds, keep it negative semidefinite.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray


def shear_force(first: FloatArray, second: FloatArray, unit: float, stiffness: float) -> tuple[FloatArray, FloatArray]:
    """Force on the corner itself and its semidefinite Jacobian by m.

    Args:
        first: from the corner to one neighbour, x_i - x_j [cm], shape (S, 3).
        second: from the corner to the other neighbour, x_k - x_j [cm], shape (S, 3).
        unit: size of a stitch u [cm].
        stiffness: kappa, free of units.

    Returns:
        Forces, shape (S, 3), and Jacobians [1/cm], shape (S, 3, 3).
    """
    scale = stiffness / unit**3
    cosine = np.einsum("si,si->s", first, second)
    middle = -0.5 * (first + second)
    jacobian = (-2.0 * scale) * (middle[:, :, None] * middle[:, None, :])
    jacobian[:, [0, 1, 2], [0, 1, 2]] -= (scale * np.maximum(cosine, 0.0))[:, None]
    return (-scale * cosine)[:, None] * middle, jacobian
