# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Area: a sub-quad smaller than at rest resists losing more of it, so that squeezed fabric does not fold.

Springs know lengths only. Where a fabric has more rows than its surface has room for, as on the instep of a sock, they
are shorter than at rest, and all of them may grow at once if a stitch turns over: its mirror image has the same sides
and diagonals. With p and q the diagonals of a sub-quad, n the unit normal of the surface, A = n . (p x q) / 2,
A_0 = r_course r_wale, a = A / A_0 and u = sqrt(A_0), the energy

    kappa u (a - 1 - ln a)    for a < 1, else 0

grows without bound as a stitch vanishes; below a = ``SMALLEST`` it goes on as a straight line, which turns a stitch
back. The forces on p and q, with n held, are

    f_p = kappa u (1 / a - 1) (q x n) / (2 A_0),    f_q = kappa u (1 / a - 1) (n x p) / (2 A_0)

A pressure whose areas add up to a constant leaves the evenly squeezed fabric alone and resists what is uneven: the
curvature of the energy, kappa u / (a A_0)^2 times the square of the gradient g = (g_p, g_q) of A. Twice the blocks
g_p g_p^T and g_q g_q^T bound it from above, so they are the Jacobians; the change of g, of either sign, is left out.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray

SMALLEST = 0.05
"""Part of its rest area below which a sub-quad pushes no harder."""


def area_forces(
    first: FloatArray, second: FloatArray, normal: FloatArray, rest: float, stiffness: float
) -> tuple[FloatArray, FloatArray]:
    """Forces on the two diagonals of sub-quads and their semidefinite Jacobians.

    Args:
        first: from the lower left corner to the upper right one, p [cm], shape (Q, 3).
        second: from the lower right corner to the upper left one, q [cm], shape (Q, 3).
        normal: unit normals of the surface, shape (Q, 3); a zero has no force.
        rest: area at rest A_0 [cm^2].
        stiffness: kappa, free of units.

    Returns:
        Forces, those on p before those on q, shape (2Q, 3), and Jacobians [1/cm], shape (2Q, 3, 3).
    """
    gradient = 0.5 * np.concatenate([np.cross(second, normal), np.cross(normal, first)])
    part = np.einsum("qi,qi->q", gradient[: len(first)], first) / rest
    limited = np.tile(np.clip(part, SMALLEST, 1.0), 2)
    scale = stiffness / np.sqrt(rest)
    curvature = np.where(limited < 1.0, (scale / rest) / limited**2, 0.0)
    jacobian = (-2.0 * curvature)[:, None, None] * (gradient[:, :, None] * gradient[:, None, :])
    return (scale * (1.0 / limited - 1.0))[:, None] * gradient, jacobian
