# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stretch: springs along edges and sub-quad diagonals (Yuksel et al. 2012, equation 2).

With d = x_i - x_j and rest length r, the force on i is

    f = kappa (r / |d| - 1) d / |d|

and the opposite on j. It grows without bound as the edge vanishes, and never pulls harder than kappa. It is minus the
gradient of kappa (|d| - r ln |d|), and with n = d / |d| its Jacobian by d is

    kappa [ -(r / |d|^2) n n^T + ((r / |d| - 1) / |d|) (I - n n^T) ]

whose last term, positive where the spring is compressed, is dropped there: the matrix stays negative semidefinite.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray

SHORTEST = 1e-2
"""Length over rest length below which a spring counts as that long, so that a vanished edge stays finite."""


def stretch_force(span: FloatArray, rest: FloatArray, stiffness: float) -> tuple[FloatArray, FloatArray]:
    """Force on the first end and its semidefinite Jacobian by the span.

    Args:
        span: from the second end to the first, x_i - x_j [cm], shape (S, 3).
        rest: rest lengths [cm], shape (S,).
        stiffness: kappa, free of units.

    Returns:
        Forces, shape (S, 3), and Jacobians [1/cm], shape (S, 3, 3). A span of no length has no force.
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
