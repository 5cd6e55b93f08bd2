# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The forces of mesh relaxation: the forces of Yuksel et al. 2012, section 6.1, and the area force of stitches.

A kernel computes the force and the Jacobian of each element, on the device. The elements are springs, corners of
sub-quads and struts, in this order. The last springs are along the diagonals of sub-quads; if the area force acts, they
contain it.
"""

# mypy: disable-error-code="valid-type"

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.mesh import IntArray
from stitchmesh.meshrelax.placement import PlacedPoints
from stitchmesh.meshrelax.sub_quads import Springs

STRETCH, SHEAR, WALE = 2.0, 0.2, 2.0
"""Dimensionless stiffnesses of Yuksel et al. 2012."""
AREA = 1.0
"""Dimensionless stiffness of areas. With 0.2, stitches of openwork on the instep of a sock keep moving."""
SMALLEST_AREA = 0.05
"""Area divided by rest area below which the force of a sub-quad does not increase further."""
SMALLEST_PART = wp.constant(wp.float64(SMALLEST_AREA))
"""The same number for kernels."""

Symmetric = wp.types.vector(length=6, dtype=wp.float64)
"""A symmetric matrix of 3 rows as xx, xy, xz, yy, yz, zz."""


@wp.func
def symmetric(across: wp.float64, along: wp.float64, n: wp.vec3d) -> Symmetric:
    """The matrix across I + along n n^T."""
    return Symmetric(
        across + along * n[0] * n[0], along * n[0] * n[1], along * n[0] * n[2],
        across + along * n[1] * n[1], along * n[1] * n[2], across + along * n[2] * n[2],
    )  # fmt: skip


@wp.func
def whole_matrix(b: Any) -> wp.mat33d:
    """All entries of a symmetric matrix, which is stored as ``Symmetric``."""
    return wp.mat33d(b[0], b[1], b[2], b[1], b[3], b[4], b[2], b[4], b[5])


@wp.func
def stretch_force(span: wp.vec3d, rest: wp.float64, stiffness: wp.float64) -> tuple[wp.vec3d, Symmetric]:
    """Compute the force on the first end of springs and its negative semidefinite Jacobian with respect to the span.

    The springs are along edges and along the diagonals of sub-quads (Yuksel et al. 2012, equation 2). With d = x_i -
    x_j and rest length r, the force on i is

        f = kappa (r / |d| - 1) d / |d|

    and the force on j is the opposite. The force grows without bound as the length of the edge vanishes, and its pull
    never exceeds kappa. It is minus the gradient of kappa (|d| - r ln |d|). With n = d / |d|, its Jacobian with respect
    to d is

        kappa [ -(r / |d|^2) n n^T + ((r / |d| - 1) / |d|) (I - n n^T) ]

    The last term is positive for a compressed spring and is then dropped, so that the matrix is negative semidefinite.
    The force of a span of length zero is zero.

    Args:
        span: vector from the second end to the first, x_i - x_j [cm].
        rest: rest length [cm].
        stiffness: kappa, dimensionless.

    Returns:
        The force, and the Jacobian [1/cm].
    """
    # The stretch force uses at least this length over the rest length, so that it stays finite for a vanished edge.
    length = wp.max(wp.length(span), wp.float64(1.0e-2) * rest)
    normal = span / length
    excess = rest / length - wp.float64(1.0)
    along = -stiffness * rest / (length * length)
    across = stiffness * wp.min(excess, wp.float64(0.0)) / length
    return stiffness * excess * normal, symmetric(across, along - across, normal)


@wp.func
def shear_force(
    first: wp.vec3d, second: wp.vec3d, unit: wp.float64, stiffness: wp.float64
) -> tuple[wp.vec3d, Symmetric]:
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
        first: vector from the corner to one neighbour, x_i - x_j [cm].
        second: vector from the corner to the other neighbour, x_k - x_j [cm].
        unit: size u of a stitch [cm].
        stiffness: kappa, dimensionless.

    Returns:
        The force, and the Jacobian [1/cm].
    """
    scale = stiffness / (unit * unit * unit)
    cosine = wp.dot(first, second)
    middle = wp.float64(-0.5) * (first + second)
    across = -scale * wp.max(cosine, wp.float64(0.0))
    return -scale * cosine * middle, symmetric(across, wp.float64(-2.0) * scale, middle)


@wp.func
def strut_force(
    lower: wp.vec3d, upper: wp.vec3d, wale: wp.float64, stiffness: wp.float64
) -> tuple[wp.vec3d, Symmetric]:
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
        lower: vector from the middle vertex to the lower vertex, x_i - x_j [cm].
        upper: vector from the middle vertex to the upper vertex, x_k - x_j [cm].
        wale: rest length of the wale edges [cm].
        stiffness: kappa, dimensionless.

    Returns:
        The force, and the Jacobian [1/cm].
    """
    span = lower - upper
    edges = wp.length(lower) + wp.length(upper)
    rest = wp.max(wale, edges)
    length = wp.length(span)
    # Length divided by rest length below which the direction of a strut, and with it the force, is reduced to zero.
    normal = span / wp.max(length, wp.float64(1.0e-9) * rest)
    part = length / rest
    along = -stiffness / rest
    if edges > wale:
        along *= wp.float64(1.0) - part * part
    return -stiffness * (part - wp.float64(1.0)) * normal, symmetric(wp.float64(0.0), along, normal)


@wp.func
def area_forces(
    first: wp.vec3d, second: wp.vec3d, normal: wp.vec3d, rest: wp.float64, stiffness: wp.float64
) -> tuple[wp.vec3d, wp.vec3d, Symmetric, Symmetric]:
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
        first: diagonal p from the lower left to the upper right corner [cm].
        second: diagonal q from the lower right to the upper left corner [cm].
        normal: unit normal of the surface at the sub-quad; a zero vector gives no force.
        rest: rest area A_0 [cm^2].
        stiffness: kappa, dimensionless.

    Returns:
        The forces on p and on q, and their Jacobians [1/cm].
    """
    one, zero = wp.float64(1.0), wp.float64(0.0)
    of_first = wp.float64(0.5) * wp.cross(second, normal)
    of_second = wp.float64(0.5) * wp.cross(normal, first)
    part = wp.dot(of_first, first) / rest
    limited = wp.clamp(part, SMALLEST_PART, one)
    scale = stiffness / wp.sqrt(rest)
    size = scale * (one / limited - one)
    curvature = zero
    if limited < one:
        curvature = wp.float64(-2.0) * scale / (rest * limited * limited)
    return (
        size * of_first, size * of_second, symmetric(zero, curvature, of_first), symmetric(zero, curvature, of_second),
    )  # fmt: skip


@kernel
def find_element_forces(
    # model
    points: wp.array2d[wp.int32],
    rest: wp.array[wp.float64],
    quads: wp.array2d[wp.int32],
    quad_area: wp.array[wp.float64],
    springs: int,
    corners: int,
    unit: wp.float64,
    stiffness: wp.vec4d,
    # state in
    position: wp.array[wp.vec3d],
    normal: wp.array[wp.vec3d],
    # state out
    force: wp.array[wp.vec3d],
    jacobian: wp.array[Symmetric],
) -> None:
    """Force and Jacobian of each element; ``stiffness`` is that of springs, corners, struts and areas."""
    e = wp.tid()
    at = position[points[e, 1]]
    first = position[points[e, 0]] - at
    if e < springs:
        own, matrix = stretch_force(first, rest[e], stiffness[0])
        count = quads.shape[0]
        diagonal = e - (springs - 2 * count)
        if diagonal >= 0 and stiffness[3] > wp.float64(0.0):
            q = diagonal % count
            a, b, c, d = quads[q, 0], quads[q, 1], quads[q, 2], quads[q, 3]
            facing = wp.normalize(normal[a] + normal[b] + normal[c] + normal[d])
            on_first, on_second, of_first, of_second = area_forces(
                position[c] - position[a], position[d] - position[b], facing, quad_area[q], stiffness[3]
            )
            # Springs begin where p and q end, so the force on their beginning is the opposite one.
            if diagonal < count:
                own = own - on_first
                matrix = matrix + of_first
            else:
                own = own - on_second
                matrix = matrix + of_second
        force[e] = own
        jacobian[e] = matrix
    elif e < springs + corners:
        of_corner, matrix_of_corner = shear_force(first, position[points[e, 2]] - at, unit, stiffness[1])
        force[e] = of_corner
        jacobian[e] = matrix_of_corner
    else:
        of_strut, matrix_of_strut = strut_force(first, position[points[e, 2]] - at, rest[e], stiffness[2])
        force[e] = of_strut
        jacobian[e] = matrix_of_strut


def force_groups(springs: Springs) -> list[tuple[IntArray, list[float]]]:
    """Return for each kind of force the points of its elements, shape (n, m), and their m weights (``assembly``)."""
    return [
        (springs.stretch_ends, [1.0, -1.0]),
        (springs.corners, [-0.5, 1.0, -0.5]),
        (springs.struts[:, [0, 2]], [1.0, -1.0]),
    ]


@dataclass(frozen=True, eq=False)
class ElementForces:
    """The forces of all elements at one placement, on the device."""

    force: wp.array[Any]
    """Force of each element, shape (elements, 3)."""
    jacobian: wp.array[Any]
    """Negative semidefinite Jacobian of each element [1/cm] as xx, xy, xz, yy, yz, zz, shape (elements, 6)."""


class Elements:
    """The elements of a fabric on a device."""

    def __init__(self, springs: Springs, device: wp.Device) -> None:
        """Upload the vertices and the rest lengths of the elements."""
        self._device, self.unit = device, springs.unit
        ends = np.column_stack([springs.stretch_ends, springs.stretch_ends[:, 1]])
        points = np.concatenate([ends, springs.corners, springs.struts])
        rest = np.concatenate([springs.stretch_rest, np.zeros(len(springs.corners)), springs.strut_rest])
        numbers = [len(ends), len(springs.corners), wp.float64(springs.unit)]
        self._model = [
            wp.array(points, dtype=wp.int32, device=device),
            wp.array(rest, dtype=wp.float64, device=device),
            wp.array(springs.quads, dtype=wp.int32, device=device),
            wp.array(springs.quad_area, dtype=wp.float64, device=device),
            *numbers,
            wp.vec4d(STRETCH, SHEAR, WALE, AREA if springs.area_force else 0.0),
        ]
        self._count = len(points)

    def forces(self, placement: PlacedPoints) -> ElementForces:
        """Compute the force and the Jacobian of each element at a placement."""
        position, normal = (
            wp.array(values, dtype=wp.vec3d, device=self._device) for values in (placement.position, placement.normal)
        )
        force = wp.empty(self._count, dtype=wp.vec3d, device=self._device)
        jacobian = wp.empty(self._count, dtype=Symmetric, device=self._device)
        launch(find_element_forces, self._count, [*self._model, position, normal], [force, jacobian], self._device)
        return ElementForces(force, jacobian)
