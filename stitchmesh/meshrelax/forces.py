# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The forces of mesh relaxation: the forces of Yuksel et al. 2012, section 6.1, and the area force of stitches."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stitchmesh.compute.threads import each_block
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.meshrelax.placement import PlacedPoints
from stitchmesh.meshrelax.sub_quads import Springs

STRETCH, SHEAR, WALE = 2.0, 0.2, 2.0
"""Dimensionless stiffnesses of Yuksel et al. 2012."""
AREA = 1.0
"""Dimensionless stiffness of areas. With 0.2, stitches of openwork on the instep of a sock keep moving."""
SMALLEST_AREA = 0.05
"""Area divided by rest area below which the force of a sub-quad does not increase further."""

ELEMENTS_OF_BLOCK = 8192
"""Elements whose forces are computed at once."""
Term = Callable[[slice], tuple[FloatArray, FloatArray]]
"""Computes the forces and the Jacobians of some elements of one kind."""


def force_groups(springs: Springs) -> list[tuple[IntArray, list[float]]]:
    """Return for each kind of force the points of its elements, shape (n, m), and their m weights (``assembly``)."""
    groups = [
        (springs.stretch_ends, [1.0, -1.0]),
        (springs.corners, [-0.5, 1.0, -0.5]),
        (springs.struts[:, [0, 2]], [1.0, -1.0]),
    ]
    if springs.area_force:
        groups += [(springs.quads[:, [2, 0]], [1.0, -1.0]), (springs.quads[:, [3, 1]], [1.0, -1.0])]
    return groups


def element_forces(springs: Springs, placement: PlacedPoints) -> tuple[FloatArray, FloatArray]:
    """Compute the force and the negative semidefinite Jacobian of each element.

    The elements are springs, corners of sub-quads and struts, in this order. If the area force acts, the first
    diagonals and then the second diagonals of sub-quads follow.

    Args:
        springs: vertices and rest lengths of the elements.
        placement: placement of the vertices.

    Returns:
        Forces, shape (elements, 3), and Jacobians [1/cm], shape (elements, 3, 3).
    """
    position = placement.position

    def stretch(some: slice) -> tuple[FloatArray, FloatArray]:
        i, j = position[springs.stretch_ends[some].T]
        return stretch_force(i - j, springs.stretch_rest[some], STRETCH)

    def shear(some: slice) -> tuple[FloatArray, FloatArray]:
        i, j, k = position[springs.corners[some].T]
        return shear_force(i - j, k - j, springs.unit, SHEAR)

    def strut(some: slice) -> tuple[FloatArray, FloatArray]:
        i, j, k = position[springs.struts[some].T]
        return strut_force(i - j, k - j, springs.strut_rest[some], WALE)

    def area(some: slice) -> tuple[FloatArray, FloatArray]:
        a, b, c, d = position[springs.quads[some].T]
        normal = unit_vectors(placement.normal[springs.quads[some]].sum(axis=1))
        return area_forces(c - a, d - b, normal, springs.quad_area[some], AREA)

    quads = len(springs.quads) if springs.area_force else 0
    counts = [len(springs.stretch_ends), len(springs.corners), len(springs.struts), quads, quads]
    first = np.cumsum([0, *counts])
    force, jacobian = np.empty((first[-1], 3)), np.empty((first[-1], 3, 3))
    for kind, term in enumerate((stretch, shear, strut, area)):

        def evaluate(some: slice, kind: int = kind, term: Term = term) -> None:
            size = some.stop - some.start
            own_force, own_jacobian = term(some)
            for part in range(len(own_force) // size):  # the area force acts on two diagonals
                at = slice(first[kind + part] + some.start, first[kind + part] + some.stop)
                force[at], jacobian[at] = (values[part * size :][:size] for values in (own_force, own_jacobian))

        each_block(evaluate, counts[kind], ELEMENTS_OF_BLOCK)
    return force, jacobian


def stretch_force(span: FloatArray, rest: FloatArray, stiffness: float) -> tuple[FloatArray, FloatArray]:
    """Compute the force on the first end of springs and its negative semidefinite Jacobian with respect to the span.

    The springs are along edges and along the diagonals of sub-quads (Yuksel et al. 2012, equation 2). With d = x_i -
    x_j and rest length r, the force on i is

        f = kappa (r / |d| - 1) d / |d|

    and the force on j is the opposite. The force grows without bound as the length of the edge vanishes, and its pull
    never exceeds kappa. It is minus the gradient of kappa (|d| - r ln |d|). With n = d / |d|, its Jacobian with respect
    to d is

        kappa [ -(r / |d|^2) n n^T + ((r / |d| - 1) / |d|) (I - n n^T) ]

    The last term is positive for a compressed spring and is then dropped, so that the matrix is negative semidefinite.

    Args:
        span: vector from the second end to the first, x_i - x_j [cm], shape (S, 3).
        rest: rest lengths [cm], shape (S,).
        stiffness: kappa, dimensionless.

    Returns:
        Forces, shape (S, 3), and Jacobians [1/cm], shape (S, 3, 3). The force of a span of length zero is zero.
    """
    true_length = np.sqrt(np.einsum("si,si->s", span, span))
    # The stretch force uses at least this length over the rest length, so that it stays finite for a vanished edge.
    length = np.maximum(true_length, 1e-2 * rest)
    normal = span / length[:, None]
    excess = rest / length - 1.0
    along = -stiffness * rest / length**2
    across = stiffness * np.minimum(excess, 0.0) / length
    jacobian = (along - across)[:, None, None] * (normal[:, :, None] * normal[:, None, :])
    jacobian[:, [0, 1, 2], [0, 1, 2]] += across[:, None]
    return (stiffness * excess)[:, None] * normal, jacobian


def shear_force(first: FloatArray, second: FloatArray, unit: float, stiffness: float) -> tuple[FloatArray, FloatArray]:
    """Compute the force on corners and its negative semidefinite Jacobian with respect to m.

    The force moves the angles of sub-quads towards right angles (Yuksel et al. 2012, equation 3). At a corner j with
    neighbours i and k, let a = x_i - x_j, b = x_k - x_j and m = x_j - (x_i + x_k) / 2. The forces are

        f_j = -kappa (a . b) m / u^3,    f_i = f_k = -f_j / 2

    Lengths are measured in units of u = sqrt(r_course r_wale), so that kappa is dimensionless as in the other forces.
    With the weights c = (-1/2, 1, -1/2) of (i, j, k), m is the weighted sum of the positions, and the force on each
    vertex is f_j times the weight of the vertex. The derivative of a . b consists of -2 c m . dx and a part along (a -
    b). The Jacobian of f_j with respect to m is taken as

        -kappa (max(a . b, 0) I + 2 m m^T) / u^3

    The maximum keeps the matrix negative semidefinite. The part along (a - b) is left out, because its matrix would not
    be symmetric.

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


def strut_force(
    lower: FloatArray, upper: FloatArray, wale: FloatArray | float, stiffness: float
) -> tuple[FloatArray, FloatArray]:
    """Compute the force on the lower end of struts and its negative semidefinite Jacobian with respect to the span d.

    A strut straightens consecutive wale edges (Yuksel et al. 2012, equation 4). For a wale edge from i to j and the
    next wale edge from j to k, with d = x_i - x_k, the force on i is

        f = -kappa (|d| / r - 1) d / |d|,    r = max(r_wale, |x_i - x_j| + |x_k - x_j|)

    and the force on k is the opposite. By the triangle inequality r is at least |d|, so that a strut only pushes. If r
    is the summed length of the two edges, it depends on the positions. When the ends of a symmetrically bent strut move
    apart by s along n = d / |d|, r grows by s |d| / r, and the force along n changes by

        -(kappa / r) (1 - (|d| / r)^2) s,    or by -(kappa / r) s if r = r_wale

    This change vanishes for a straight wale, and so does the force. A Jacobian with constant r would make the iteration
    unstable. The derivative perpendicular to n, (1/|d| - 1/r) kappa, is never negative. It is dropped, so that the
    Jacobian is negative semidefinite.

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
    # Length divided by rest length below which the direction of a strut, and with it the force, is reduced to zero.
    normal = span / np.maximum(length, 1e-9 * rest)[:, None]
    along = (-stiffness / rest) * np.where(edges > wale, 1.0 - (length / rest) ** 2, 1.0)
    jacobian = along[:, None, None] * (normal[:, :, None] * normal[:, None, :])
    return (-stiffness * (length / rest - 1.0))[:, None] * normal, jacobian


def area_forces(
    first: FloatArray, second: FloatArray, normal: FloatArray, rest: FloatArray | float, stiffness: float
) -> tuple[FloatArray, FloatArray]:
    """Compute the forces on the two diagonals of sub-quads and their negative semidefinite Jacobians.

    A sub-quad below its rest area resists further loss of area, so that compressed fabric does not fold. Springs depend
    on lengths only, and the mirror image of a stitch has the same sides and diagonals. If a fabric has more rows than
    fit on its surface, for example on the instep of a sock, its springs are compressed, and all of them could relax if
    stitches turned over. Let p and q be the diagonals of a sub-quad, n the unit normal of the surface, A = n . (p x q)
    / 2, A_0 = r_course r_wale, a = A / A_0 and u = sqrt(A_0). The energy

        kappa u (a - 1 - ln a)    for a < 1, else 0

    grows without bound as the area of the sub-quad vanishes. Below a = ``SMALLEST_AREA`` the energy continues as its
    tangent line, whose force turns an inverted sub-quad back. The forces on p and q, for constant n, are

        f_p = kappa u (1 / a - 1) (q x n) / (2 A_0),    f_q = kappa u (1 / a - 1) (n x p) / (2 A_0)

    Areas that add up to a constant exert no net force on a uniformly compressed fabric; the force resists only
    differences of area. The second derivative of the energy is kappa u / (a A_0)^2 g g^T with the gradient g = (g_p,
    g_q) of A, plus terms with the derivative of g. Twice the blocks g_p g_p^T and g_q g_q^T bound the first term from
    above and therefore serve as Jacobians. The terms with the derivative of g may have either sign and are left out.

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
    limited = np.clip(part, SMALLEST_AREA, 1.0)
    scale = stiffness / np.sqrt(rest)
    curvature = np.tile(np.where(limited < 1.0, (scale / rest) / limited**2, 0.0), 2)
    jacobian = (-2.0 * curvature)[:, None, None] * (gradient[:, :, None] * gradient[:, None, :])
    return np.tile(scale * (1.0 / limited - 1.0), 2)[:, None] * gradient, jacobian
