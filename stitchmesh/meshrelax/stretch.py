# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stretch force: springs along edges and along the diagonals of sub-quads (Yuksel et al. 2012, equation 2).

With d = x_i - x_j and rest length r, the force on i is

    f = kappa (r / |d| - 1) d / |d|

and the force on j is the opposite. The force grows without bound as the length of the edge vanishes, and its pull never
exceeds kappa. It is minus the gradient of kappa (|d| - r ln |d|). With n = d / |d|, its Jacobian with respect to d is

    kappa [ -(r / |d|^2) n n^T + ((r / |d| - 1) / |d|) (I - n n^T) ]

The last term is positive for a compressed spring and is then dropped, so that the matrix is negative semidefinite.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray

SHORTEST = 1e-2
"""The force uses at least this length over the rest length, so that the force of a vanished edge is finite."""


def stretch_force(span: FloatArray, rest: FloatArray, stiffness: float) -> tuple[FloatArray, FloatArray]:
    """Compute the force on the first end of springs and its negative semidefinite Jacobian with respect to the span.

    Args:
        span: vector from the second end to the first, x_i - x_j [cm], shape (S, 3).
        rest: rest lengths [cm], shape (S,).
        stiffness: kappa, dimensionless.

    Returns:
        Forces, shape (S, 3), and Jacobians [1/cm], shape (S, 3, 3). The force of a span of length zero is zero.
    """
    true_length = np.sqrt(np.einsum("si,si->s", span, span))
    length = np.maximum(true_length, SHORTEST * rest)
    normal = span / length[:, None]
    excess = rest / length - 1.0
    along = -stiffness * rest / length**2
    across = stiffness * np.minimum(excess, 0.0) / length
    jacobian = (along - across)[:, None, None] * (normal[:, :, None] * normal[:, None, :])
    jacobian[:, [0, 1, 2], [0, 1, 2]] += across[:, None]
    return (stiffness * excess)[:, None] * normal, jacobian
