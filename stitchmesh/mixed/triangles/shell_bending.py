# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bending of the cloth at the hinges between its triangles (C 4.1), with rest angles at seams.

Let theta be the angles of all hinges (``hinge_angle``), and theta_0 their rest angles, which come from the seams and
from the curvature at which the moments of the material vanish. With the matrix K of ``curvature``

    E = (theta - theta_0)^T K (theta - theta_0) / 2,    moments m = K (theta - theta_0)

The force is -sum over the hinges of m_h grad theta_h, and the product of the Hessian with a direction d

    sum over the hinges of  (K J d)_h grad theta_h + m_h (Hess theta_h) d,    J d = the derivatives of the angles

The first part is never negative, because K is not. The second part has no definite sign; the Hessian that is never
negative leaves it out.

A hinge is two triangles that share an edge. Its angle and the first two derivatives follow Tamstorf and Grinspun 2013.

A hinge has the vertices x_0 and x_1 of its edge and the third vertices x_2 and x_3 of its first and second triangle
(``Cloth.hinges``). With e = x_1 - x_0, r_k = x_k - x_0, L = |e| and the normals n_2 = e x r_2 and n_3 = r_3 x e

    theta = atan2(-L n_2 . r_3, n_2 . n_3)
    grad_2 theta = -L n_2 / |n_2|^2,    grad_3 theta = -L n_3 / |n_3|^2
    grad_1 theta = -a_2 grad_2 - a_3 grad_3,    grad_0 theta = -(1 - a_2) grad_2 - (1 - a_3) grad_3

with a_k = e . r_k / L^2.

The product of the Hessian with a direction is the derivative of these gradients along the direction, which needs no
matrix. A triangle that has lost its area in space has no angle. L and |n_k| are therefore bounded below by one
ten-thousandth of their rest values, with which gradients and products stay finite.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Mat33, Scalar, ScalarType, Vec3, matrix, vector
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.gather import GatherTable
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import MixedTerm
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial, checked_weights
from stitchmesh.mixed.triangles.curvature import hinge_angles_of, hinge_stiffness

SMALLEST_PART = 1e-4
"""Smallest length of an edge, and smallest area of a triangle, as a part of the rest value."""


@wp.func
def hinge_frame(corner: wp.vec4i, vertices: Any) -> tuple[Any, Any, Any]:
    """The vectors e, r_2 and r_3 of a hinge, or their change along a direction."""
    start = vertices[corner[0]]
    return vertices[corner[1]] - start, vertices[corner[2]] - start, vertices[corner[3]] - start


@wp.func
def hinge_angle(e: Vec3, r2: Vec3, r3: Vec3) -> Any:
    """Angle [rad], zero where the triangles are flat and positive on a ridge seen from outside."""
    n2 = wp.cross(e, r2)
    return wp.atan2(-wp.length(e) * wp.dot(n2, r3), wp.dot(n2, wp.cross(r3, e)))


@wp.func
def angle_gradient(e: Vec3, r2: Vec3, r3: Vec3, least: Vec3) -> tuple[Any, Any, Any, Any]:
    """Gradient of the angle at x_0 to x_3; ``least`` holds the bounds of L^2, |n_2|^2 and |n_3|^2."""
    one = type(e[0])(1.0)
    per_square = one / wp.max(wp.dot(e, e), least[0])
    length = wp.sqrt(wp.dot(e, e))
    n2, n3 = wp.cross(e, r2), wp.cross(r3, e)
    g2 = n2 * (-length / wp.max(wp.dot(n2, n2), least[1]))
    g3 = n3 * (-length / wp.max(wp.dot(n3, n3), least[2]))
    a2, a3 = wp.dot(e, r2) * per_square, wp.dot(e, r3) * per_square
    return g2 * (a2 - one) + g3 * (a3 - one), -g2 * a2 - g3 * a3, g2, g3


@wp.func
def normal_change(n: Vec3, dn: Vec3, length: Scalar, length_change: Scalar, least: Scalar) -> Any:
    """Derivative of -L n / |n|^2."""
    two = type(length)(2.0)
    per_square = type(length)(1.0) / wp.max(wp.dot(n, n), least)
    return (n * length_change + dn * length - n * (two * length * wp.dot(n, dn) * per_square)) * -per_square


@wp.func
def gradient_change(e: Vec3, r2: Vec3, r3: Vec3, de: Vec3, dr2: Vec3, dr3: Vec3, least: Vec3) -> tuple[Any, Any, Any]:
    """Derivative of the gradient at x_1, x_2 and x_3 as the frame changes: the Hessian times a direction."""
    two = type(e[0])(2.0)
    square = wp.max(wp.dot(e, e), least[0])
    length = wp.sqrt(square)
    length_change = wp.dot(e, de) / length
    n2, n3 = wp.cross(e, r2), wp.cross(r3, e)
    dn2, dn3 = wp.cross(de, r2) + wp.cross(e, dr2), wp.cross(dr3, e) + wp.cross(r3, de)
    dg2 = normal_change(n2, dn2, length, length_change, least[1])
    dg3 = normal_change(n3, dn3, length, length_change, least[2])
    g2 = n2 * (-length / wp.max(wp.dot(n2, n2), least[1]))
    g3 = n3 * (-length / wp.max(wp.dot(n3, n3), least[2]))
    a2, a3 = wp.dot(e, r2) / square, wp.dot(e, r3) / square
    da2 = (wp.dot(de, r2) + wp.dot(e, dr2) - two * a2 * wp.dot(e, de)) / square
    da3 = (wp.dot(de, r3) + wp.dot(e, dr3) - two * a3 * wp.dot(e, de)) / square
    return -dg2 * a2 - g2 * da2 - dg3 * a3 - g3 * da3, dg2, dg3


def least_squares_of(cloth: Cloth) -> NDArray[np.float64]:
    """The bounds of L^2 [cm^2], |n_2|^2 and |n_3|^2 [cm^4] of each hinge of a cloth, shape (H, 3)."""
    sides = cloth.hinge_sides
    lengths = np.linalg.norm(np.diff(cloth.side_rest, axis=1)[:, 0], axis=1)[sides].mean(axis=1)
    doubled = 2.0 * cloth.rest_area[sides // 3]
    bounds: NDArray[np.float64] = (SMALLEST_PART * np.column_stack([lengths, doubled])) ** 2
    return bounds


@wp.func
def row_times(start: Any, column: Any, value: Any, x: Any, h: int) -> Any:
    """Row ``h`` of a sparse matrix times a vector."""
    total = x[h] - x[h]
    for k in range(start[h], start[h + 1]):
        total += value[k] * x[column[k]]
    return total


@kernel
def find_deflections(
    # model
    corner: wp.array[wp.vec4i],
    rest_angle: wp.array[Scalar],
    # state in
    vertices: wp.array[Vec3],
    # state out
    deflection: wp.array[Scalar],
) -> None:
    """Angle of each hinge minus its rest angle [rad]."""
    h = wp.tid()
    e, r2, r3 = hinge_frame(corner[h], vertices)
    deflection[h] = hinge_angle(e, r2, r3) - rest_angle[h]


@kernel
def find_hinge_energies(
    # model
    start: wp.array[wp.int32],
    column: wp.array[wp.int32],
    value: wp.array[Scalar],
    # state in
    deflection: wp.array[Scalar],
    # state out
    energy: wp.array[Scalar],
) -> None:
    """The part of each hinge in the energy [erg]."""
    h = wp.tid()
    energy[h] = row_times(start, column, value, deflection, h) * deflection[h] / type(deflection[0])(2.0)


@kernel
def find_hinge_forces(
    # model
    corner: wp.array[wp.vec4i],
    least: wp.array[Vec3],
    start: wp.array[wp.int32],
    column: wp.array[wp.int32],
    value: wp.array[Scalar],
    # state in
    vertices: wp.array[Vec3],
    deflection: wp.array[Scalar],
    # state out
    corner_force: wp.array[Vec3],
) -> None:
    """Forces [dyn] of each hinge on its four vertices."""
    h = wp.tid()
    moment = row_times(start, column, value, deflection, h)
    e, r2, r3 = hinge_frame(corner[h], vertices)
    g0, g1, g2, g3 = angle_gradient(e, r2, r3, least[h])
    corner_force[4 * h] = -g0 * moment
    corner_force[4 * h + 1] = -g1 * moment
    corner_force[4 * h + 2] = -g2 * moment
    corner_force[4 * h + 3] = -g3 * moment


@kernel
def find_hinge_frames(
    # model
    exact: float,
    corner: wp.array[wp.vec4i],
    least: wp.array[Vec3],
    start: wp.array[wp.int32],
    column: wp.array[wp.int32],
    value: wp.array[Scalar],
    # state in
    vertices: wp.array[Vec3],
    deflection: wp.array[Scalar],
    # state out
    frame: wp.array2d[Vec3],
    gradient: wp.array2d[Vec3],
    moment: wp.array[Scalar],
) -> None:
    """What the products need: frame and gradients of each hinge, and the kept part of its moment [dyn cm]."""
    h = wp.tid()
    e, r2, r3 = hinge_frame(corner[h], vertices)
    frame[0, h] = e
    frame[1, h] = r2
    frame[2, h] = r3
    _g0, g1, g2, g3 = angle_gradient(e, r2, r3, least[h])
    gradient[0, h] = g1
    gradient[1, h] = g2
    gradient[2, h] = g3
    moment[h] = row_times(start, column, value, deflection, h) * type(deflection[0])(exact)


@kernel
def find_turns(
    # model
    corner: wp.array[wp.vec4i],
    gradient: wp.array2d[Vec3],
    # state in
    direction: wp.array[Vec3],
    # state out
    turn: wp.array[Scalar],
) -> None:
    """Derivative of each angle along a direction."""
    h = wp.tid()
    de, dr2, dr3 = hinge_frame(corner[h], direction)
    # the gradients of all four vertices add to zero
    turn[h] = wp.dot(gradient[0, h], de) + wp.dot(gradient[1, h], dr2) + wp.dot(gradient[2, h], dr3)


@kernel
def find_hinge_products(
    # model
    corner: wp.array[wp.vec4i],
    least: wp.array[Vec3],
    start: wp.array[wp.int32],
    column: wp.array[wp.int32],
    value: wp.array[Scalar],
    frame: wp.array2d[Vec3],
    gradient: wp.array2d[Vec3],
    moment: wp.array[Scalar],
    # state in
    direction: wp.array[Vec3],
    turn: wp.array[Scalar],
    # state out
    corner_product: wp.array[Vec3],
) -> None:
    """Hessian times direction [dyn] at the four vertices of each hinge."""
    h = wp.tid()
    change, m = row_times(start, column, value, turn, h), moment[h]
    p1, p2, p3 = gradient[0, h] * change, gradient[1, h] * change, gradient[2, h] * change
    if m != m - m:
        de, dr2, dr3 = hinge_frame(corner[h], direction)
        d1, d2, d3 = gradient_change(frame[0, h], frame[1, h], frame[2, h], de, dr2, dr3, least[h])
        p1 += d1 * m
        p2 += d2 * m
        p3 += d3 * m
    corner_product[4 * h] = -p1 - p2 - p3
    corner_product[4 * h + 1] = p1
    corner_product[4 * h + 2] = p2
    corner_product[4 * h + 3] = p3


@wp.func
def at_vertex(corner: wp.vec4i, gradient: Any, h: int, vertex: int) -> Any:
    """The gradient of the angle of hinge ``h`` at a vertex; zero where the hinge does not have it."""
    g1, g2, g3 = gradient[0, h], gradient[1, h], gradient[2, h]
    found = g1 - g1
    if corner[0] == vertex:
        found -= g1 + g2 + g3
    if corner[1] == vertex:
        found += g1
    if corner[2] == vertex:
        found += g2
    if corner[3] == vertex:
        found += g3
    return found


@kernel
def find_hinge_blocks(
    # model
    corner: wp.array[wp.vec4i],
    start: wp.array[wp.int32],
    column: wp.array[wp.int32],
    value: wp.array[Scalar],
    gradient: wp.array2d[Vec3],
    # state out
    block: wp.array[Mat33],
) -> None:
    """Part of each hinge in the blocks [dyn / cm] on the diagonal, without the second derivatives of the angles."""
    slot = wp.tid()
    h = slot // 4
    vertex = corner[h][slot - 4 * h]
    own = at_vertex(corner[h], gradient, h, vertex)
    total = own - own
    for j in range(start[h], start[h + 1]):
        total += at_vertex(corner[column[j]], gradient, column[j], vertex) * value[j]
    half = type(total[0])(0.5)
    product = wp.outer(own, total)
    block[slot] = (product + wp.transpose(product)) * half


class ShellBending(MixedTerm):
    """Bending of a cloth on a device."""

    name = "bending"
    acts_on = "vertices"

    def __init__(
        self,
        cloth: Cloth,
        material: ClothMaterial,
        scalar: ScalarType,
        device: wp.Device,
        weight: ArrayLike | None = None,
    ) -> None:
        """Upload the hinges and the matrix between them.

        Args:
            cloth: T triangles in panels, with H hinges and their rest angles.
            material: material of the triangles.
            scalar: Warp's floating-point type.
            device: where the kernels run.
            weight: blending weight 1 - alpha of each triangle, shape (T,); by default 1.

        Raises:
            ParameterError: a weight is not in [0, 1].
        """
        self.device, self.scalar, hinges = device, scalar, cloth.hinges
        self._count, three = len(hinges), vector(3, scalar)
        count = len(cloth.triangles)
        rigidities = np.repeat(material.rigidities()[None], count, axis=0)
        curled = hinge_angles_of(cloth, np.repeat(material.rest_curvature()[None], count, axis=0))
        weights = checked_weights(weight, count)
        stiffness = hinge_stiffness(cloth, rigidities, weights)
        self._corner = wp.array(hinges.astype(np.int32), dtype=wp.vec4i, device=device)
        self._rest_angle = wp.array(cloth.hinge_angle + curled, dtype=scalar, device=device)
        self._least = wp.array(least_squares_of(cloth), dtype=three, device=device)
        self._start = wp.array(stiffness.indptr.astype(np.int32), dtype=wp.int32, device=device)
        self._column = wp.array(stiffness.indices.astype(np.int32), dtype=wp.int32, device=device)
        self._value = wp.array(stiffness.data, dtype=scalar, device=device)
        self._gather = GatherTable.of(hinges, len(cloth.vertices), device)
        self._deflection, self._turn, self._moment, self._energy = (
            wp.zeros(self._count, dtype=scalar, device=device) for _ in range(4)
        )
        self._frame, self._gradient = (wp.zeros((3, self._count), dtype=three, device=device) for _ in range(2))
        self._slots = wp.zeros(4 * self._count, dtype=three, device=device)
        self._blocks: wp.array[Any] | None = None

    @property
    def _rows(self) -> list[Any]:
        return [self._start, self._column, self._value]

    def _find_deflections(self, state: MixedVector, launcher: Launcher) -> Any:
        inputs = [self._corner, self._rest_angle, state.vertices]
        return launcher(find_deflections, self._count, inputs, [self._deflection])

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of each hinge, and the array of the energies."""
        deflections = self._find_deflections(state, launcher)
        found = launcher(find_hinge_energies, self._count, [*self._rows, self._deflection], [self._energy])
        return [deflections, found], self._energy

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add the forces of the hinges."""
        deflections = self._find_deflections(state, launcher)
        inputs = [self._corner, self._least, *self._rows, state.vertices, self._deflection]
        found = launcher(find_hinge_forces, self._count, inputs, [self._slots])
        return [deflections, found, *self._gather.launches(self._slots, force.vertices, launcher)]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that store the frames and the moments."""
        deflections = self._find_deflections(state, launcher)
        inputs = [float(self.exact), self._corner, self._least, *self._rows, state.vertices, self._deflection]
        outputs = [self._frame, self._gradient, self._moment]
        return [deflections, launcher(find_hinge_frames, self._count, inputs, outputs)]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add the products of the Hessian."""
        inputs = [self._corner, self._gradient, direction.vertices]
        turns = launcher(find_turns, self._count, inputs, [self._turn])
        inputs = [self._corner, self._least, *self._rows, self._frame, self._gradient, self._moment]
        inputs += [direction.vertices, self._turn]
        found = launcher(find_hinge_products, self._count, inputs, [self._slots])
        return [turns, found, *self._gather.launches(self._slots, product.vertices, launcher)]

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that add the diagonal blocks of the first part of the Hessian, which is never negative."""
        if self._blocks is None:
            self._blocks = wp.zeros(4 * self._count, dtype=matrix(3, self.scalar), device=self.device)
        inputs = [self._corner, *self._rows, self._gradient]
        found = launcher(find_hinge_blocks, 4 * self._count, inputs, [self._blocks])
        return [found, *self._gather.launches(self._blocks, blocks.vertices, launcher)]
