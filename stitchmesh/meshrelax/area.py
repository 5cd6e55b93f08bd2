# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Area force: a sub-quad below its rest area resists further loss of area, so that compressed fabric does not fold.

Springs depend on lengths only, and the mirror image of a stitch has the same sides and diagonals. If a fabric has more
rows than fit on its surface, for example on the instep of a sock, its springs are compressed, and all of them could
relax if stitches turned over. Let p and q be the diagonals of a sub-quad, n the unit normal of the surface,
A = n . (p x q) / 2, A_0 = r_course r_wale, a = A / A_0 and u = sqrt(A_0). The energy

    kappa u (a - 1 - ln a)    for a < 1, else 0

grows without bound as the area of the sub-quad vanishes. Below a = ``SMALLEST`` the energy continues as its tangent
line, whose force turns an inverted sub-quad back. The forces on p and q, for constant n, are

    f_p = kappa u (1 / a - 1) (q x n) / (2 A_0),    f_q = kappa u (1 / a - 1) (n x p) / (2 A_0)

Areas that add up to a constant exert no net force on a uniformly compressed fabric; the force resists only differences
of area. The second derivative of the energy is kappa u / (a A_0)^2 g g^T with the gradient g = (g_p, g_q) of A, plus
terms with the derivative of g. Twice the blocks g_p g_p^T and g_q g_q^T bound the first term from above and therefore
serve as Jacobians. The terms with the derivative of g may have either sign and are left out.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray

SMALLEST = 0.05
"""Area divided by rest area below which the force of a sub-quad does not increase further."""


def area_forces(
    first: FloatArray, second: FloatArray, normal: FloatArray, rest: FloatArray | float, stiffness: float
) -> tuple[FloatArray, FloatArray]:
    """Compute the forces on the two diagonals of sub-quads and their negative semidefinite Jacobians.

    Args:
        first: diagonal p from the lower left to the upper right corner [cm], shape (Q, 3).
        second: diagonal q from the lower right to the upper left corner [cm], shape (Q, 3).
        normal: unit normal of the surface at each sub-quad, shape (Q, 3); a zero vector gives no force.
        rest: rest area A_0 [cm^2] of each sub-quad, shape (Q,), or one for all sub-quads.
        stiffness: kappa, dimensionless.

    Returns:
        Forces on p and then forces on q, shape (2Q, 3), and their Jacobians [1/cm], shape (2Q, 3, 3).
    """
    gradient = 0.5 * np.concatenate([np.cross(second, normal), np.cross(normal, first)])
    part = np.einsum("qi,qi->q", gradient[: len(first)], first) / rest
    limited = np.clip(part, SMALLEST, 1.0)
    scale = stiffness / np.sqrt(rest)
    curvature = np.tile(np.where(limited < 1.0, (scale / rest) / limited**2, 0.0), 2)
    jacobian = (-2.0 * curvature)[:, None, None] * (gradient[:, :, None] * gradient[:, None, :])
    return np.tile(scale * (1.0 / limited - 1.0), 2)[:, None] * gradient, jacobian
