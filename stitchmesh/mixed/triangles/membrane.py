# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stretch and shear of the triangles: Saint Venant-Kirchhoff elasticity in plane stress (C 4.1).

With the corners x_i of a triangle and the gradients g_i of its three linear functions at rest, in the axes of its
panel, the columns a_1 and a_2 of the deformation gradient and the Green strain are

    F = sum of x_i g_i^T = (a_1, a_2),    E = (F^T F - 1) / 2,    e = (E_11, E_22, 2 E_12)

with axis 1 along the courses (wefts) and axis 2 along the wales (warps). The energy of a triangle with rest area A and
blending weight w is

    w A (s_1 W_1(e_1) + s_2 W_2(e_2) + W_3(e_3) + s (W_4(e_1 + e_2) + C_12 e_1 e_2)),    s = min(s_1, s_2)

where the shares s_1 and s_2 are 1 except for hybrid triangles of a weave (``enrichment.balanced_weights``). With s as
their minimum, the material stays as definite as without shares. For the orthotropic material of constant moduli
W_k = C_kk e_k^2 / 2 and W_4 = 0; ``TensionCurve`` holds other laws, whose stiffness depends on the strain. Let S be the
stresses of the energy density. The force on corner i is -w A F S g_i. With the derivative dF along a direction, the
product of the Hessian is, without shares,

    w A (F dS + dF S) g_i,    dS = C dE,    C = (W_1'' + W_4'', C_12 + W_4'', 0; ., W_2'' + W_4'', 0; 0, 0, W_3'')

The first part is never negative if C is positive definite, which ``ClothMaterial`` checks. The second part, the
geometric stiffness, is negative across a direction of compression. The Hessian that is never negative keeps the tensile
principal stresses in the second part and leaves the compressive ones out.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Mat22, Mat33, Scalar, ScalarType, Vec2, Vec3, Vec4, matrix, vector
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.gather import GatherTable
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import MixedTerm
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial, checked_weights


@wp.func
def curve_at(nodes: Any, first: int, end: int, x: Scalar) -> Any:
    """Energy density, stress and slope at strain ``x`` of the curve whose nodes are ``first`` to ``end`` - 1."""
    k = first + int(0)
    while k + 1 < end and nodes[k + 1][0] <= x:
        k += 1
    node = nodes[k]
    one, two, three = type(x)(1.0), type(x)(2.0), type(x)(3.0)
    d = x - node[0]
    bend, twist = d - d, d - d  # coefficients of d^2 and d^3 in the stress; zero beyond the ends
    if d > type(x)(0.0) and k + 1 < end:
        other = nodes[k + 1]
        per_length = one / (other[0] - node[0])
        chord = (other[1] - node[1]) * per_length
        bend = (three * chord - two * node[2] - other[2]) * per_length
        twist = (node[2] + other[2] - two * chord) * per_length * per_length
    stress = node[1] + d * (node[2] + d * (bend + d * twist))
    slope = node[2] + d * (two * bend + d * three * twist)
    energy = node[3] + d * (node[1] + d * (node[2] / two + d * (bend / three + d * twist * type(x)(0.25))))
    return wp.vector(energy, stress, slope)


@wp.func
def columns_of(corner: wp.vec3i, gradient: Mat22, vertices: Any) -> tuple[Any, Any]:
    """The columns of the deformation gradient, or of its derivative along a direction; ``gradient`` holds g_2, g_3."""
    along = vertices[corner[1]] - vertices[corner[0]]
    beside = vertices[corner[2]] - vertices[corner[0]]
    return along * gradient[0, 0] + beside * gradient[1, 0], along * gradient[0, 1] + beside * gradient[1, 1]


@wp.func
def green_strain(a1: Vec3, a2: Vec3) -> Any:
    """Green strain E_11, E_22, 2 E_12 of a deformation gradient of these columns."""
    half, one = type(a1[0])(0.5), type(a1[0])(1.0)
    return wp.vector((wp.dot(a1, a1) - one) * half, (wp.dot(a2, a2) - one) * half, wp.dot(a1, a2))


@wp.func
def tensile(s: Vec3) -> Any:
    """A stress (S_11, S_22, S_12) without its compressive principal stresses."""
    zero = s[0] - s[0]
    half = type(s[0])(0.5)
    mean, apart = (s[0] + s[1]) * half, (s[0] - s[1]) * half
    radius = wp.sqrt(apart * apart + s[2] * s[2])
    high, low = mean + radius, mean - radius
    if low >= zero:
        return s
    if high <= zero:
        return s * zero
    share = high / (radius + radius)
    return wp.vector(s[0] - low, s[1] - low, s[2]) * share


@wp.func
def strain_change(a1: Vec3, a2: Vec3, d1: Vec3, d2: Vec3) -> Any:
    """Derivative of the Green strain as the columns a change by d."""
    return wp.vector(wp.dot(a1, d1), wp.dot(a2, d2), wp.dot(a1, d2) + wp.dot(a2, d1))


@wp.func
def stress_change(c: Vec4, change: Vec3) -> Any:
    """Derivative of the stress (S_11, S_22, S_12) for a change of the strain; c holds C_11, C_22, C_33 and C_12."""
    first, second = c[0] * change[0] + c[3] * change[1], c[1] * change[1] + c[3] * change[0]
    return wp.vector(first, second, c[2] * change[2])


@kernel
def find_triangle_energies(
    # model
    corner: wp.array[wp.vec3i],
    gradient: wp.array[Mat22],
    amount: wp.array[Scalar],
    curve_start: wp.array[wp.int32],
    curve_nodes: wp.array[Vec4],
    coupling: Scalar,
    share: wp.array[Vec2],
    # state in
    vertices: wp.array[Vec3],
    # state out
    energy: wp.array[Scalar],
) -> None:
    """Energy [erg] of each triangle."""
    t = wp.tid()
    a1, a2 = columns_of(corner[t], gradient[t], vertices)
    strain = green_strain(a1, a2)
    course = curve_at(curve_nodes, curve_start[0], curve_start[1], strain[0])
    wale = curve_at(curve_nodes, curve_start[1], curve_start[2], strain[1])
    shear = curve_at(curve_nodes, curve_start[2], curve_start[3], strain[2])
    both = curve_at(curve_nodes, curve_start[3], curve_start[4], strain[0] + strain[1])
    coupled = (both[0] + coupling * strain[0] * strain[1]) * wp.min(share[t])
    energy[t] = (course[0] * share[t][0] + wale[0] * share[t][1] + shear[0] + coupled) * amount[t]


@wp.func
def stress_and_stiffness(
    curve_start: Any, curve_nodes: Any, coupling: Scalar, share: Vec2, strain: Vec3
) -> tuple[Any, Any]:
    """The stress (S_11, S_22, S_12) and the stiffness (C_11, C_22, C_33, C_12) at a strain."""
    course = curve_at(curve_nodes, curve_start[0], curve_start[1], strain[0])
    wale = curve_at(curve_nodes, curve_start[1], curve_start[2], strain[1])
    shear = curve_at(curve_nodes, curve_start[2], curve_start[3], strain[2])
    both = curve_at(curve_nodes, curve_start[3], curve_start[4], strain[0] + strain[1])
    coupled = wp.min(share)
    on_course, on_wale = both[1] + coupling * strain[1], both[1] + coupling * strain[0]
    stress = wp.vector(course[1] * share[0] + on_course * coupled, wale[1] * share[1] + on_wale * coupled, shear[1])
    along = wp.vector(course[2] * share[0], wale[2] * share[1])
    more = both[2] * coupled
    return stress, wp.vector(along[0] + more, along[1] + more, shear[2], coupling * coupled + more)


@kernel
def find_triangle_forces(
    # model
    corner: wp.array[wp.vec3i],
    gradient: wp.array[Mat22],
    amount: wp.array[Scalar],
    curve_start: wp.array[wp.int32],
    curve_nodes: wp.array[Vec4],
    coupling: Scalar,
    share: wp.array[Vec2],
    # state in
    vertices: wp.array[Vec3],
    # state out
    corner_force: wp.array[Vec3],
) -> None:
    """Forces [dyn] of each triangle on its three corners."""
    t = wp.tid()
    g = gradient[t]
    a1, a2 = columns_of(corner[t], g, vertices)
    strain = green_strain(a1, a2)
    s, _stiffness = stress_and_stiffness(curve_start, curve_nodes, coupling, share[t], strain)
    scale = -amount[t]
    p1, p2 = (a1 * s[0] + a2 * s[2]) * scale, (a1 * s[2] + a2 * s[1]) * scale
    second, third = p1 * g[0, 0] + p2 * g[0, 1], p1 * g[1, 0] + p2 * g[1, 1]
    corner_force[3 * t] = -second - third
    corner_force[3 * t + 1] = second
    corner_force[3 * t + 2] = third


@kernel
def find_triangle_stiffness(
    # model
    exact: float,
    corner: wp.array[wp.vec3i],
    gradient: wp.array[Mat22],
    curve_start: wp.array[wp.int32],
    curve_nodes: wp.array[Vec4],
    coupling: Scalar,
    share: wp.array[Vec2],
    # state in
    vertices: wp.array[Vec3],
    # state out
    column: wp.array2d[Vec3],
    stress: wp.array[Vec3],
    stiffness: wp.array[Vec4],
) -> None:
    """What the products need: columns, the stress of the geometric stiffness, and the stiffness of the material."""
    t = wp.tid()
    a1, a2 = columns_of(corner[t], gradient[t], vertices)
    strain = green_strain(a1, a2)
    s, c = stress_and_stiffness(curve_start, curve_nodes, coupling, share[t], strain)
    kept = tensile(s)
    column[0, t] = a1
    column[1, t] = a2
    stress[t] = kept + (s - kept) * type(s[0])(exact)
    stiffness[t] = c


@kernel
def find_triangle_products(
    # model
    corner: wp.array[wp.vec3i],
    gradient: wp.array[Mat22],
    amount: wp.array[Scalar],
    column: wp.array2d[Vec3],
    stress: wp.array[Vec3],
    stiffness: wp.array[Vec4],
    # state in
    direction: wp.array[Vec3],
    # state out
    corner_product: wp.array[Vec3],
) -> None:
    """Hessian times direction [dyn] at the three corners of each triangle."""
    t = wp.tid()
    g = gradient[t]
    a1, a2, s = column[0, t], column[1, t], stress[t]
    d1, d2 = columns_of(corner[t], g, direction)
    ds = stress_change(stiffness[t], strain_change(a1, a2, d1, d2))
    p1 = (a1 * ds[0] + a2 * ds[2] + d1 * s[0] + d2 * s[2]) * amount[t]
    p2 = (a1 * ds[2] + a2 * ds[1] + d1 * s[2] + d2 * s[1]) * amount[t]
    second, third = p1 * g[0, 0] + p2 * g[0, 1], p1 * g[1, 0] + p2 * g[1, 1]
    corner_product[3 * t] = -second - third
    corner_product[3 * t + 1] = second
    corner_product[3 * t + 2] = third


@wp.func
def corner_block(g1: Scalar, g2: Scalar, a1: Vec3, a2: Vec3, s: Vec3, c: Vec4) -> Any:
    """Block of the Hessian of one corner with the gradient (g_1, g_2), per area."""
    two = type(g1)(2.0)
    course, wale, shear = a1 * g1, a2 * g2, a1 * g2 + a2 * g1
    turning = g1 * g1 * s[0] + g2 * g2 * s[1] + two * g1 * g2 * s[2]
    crossed = wp.outer(course, wale)
    block = wp.outer(course, course) * c[0] + wp.outer(wale, wale) * c[1] + wp.outer(shear, shear) * c[2]
    block += (crossed + wp.transpose(crossed)) * c[3]
    return block + wp.identity(n=3, dtype=type(g1)) * turning


@kernel
def find_triangle_blocks(
    # model
    gradient: wp.array[Mat22],
    amount: wp.array[Scalar],
    column: wp.array2d[Vec3],
    stress: wp.array[Vec3],
    stiffness: wp.array[Vec4],
    # state out
    block: wp.array[Mat33],
) -> None:
    """Blocks of the Hessian [dyn / cm] on the diagonal at the three corners of each triangle."""
    t = wp.tid()
    g = gradient[t]
    a1, a2, s, c = column[0, t], column[1, t], stress[t], stiffness[t]
    block[3 * t] = corner_block(-g[0, 0] - g[1, 0], -g[0, 1] - g[1, 1], a1, a2, s, c) * amount[t]
    block[3 * t + 1] = corner_block(g[0, 0], g[0, 1], a1, a2, s, c) * amount[t]
    block[3 * t + 2] = corner_block(g[1, 0], g[1, 1], a1, a2, s, c) * amount[t]


class Membrane(MixedTerm):
    """Stretch and shear of a cloth on a device."""

    name = "membrane"
    acts_on = "vertices"

    def __init__(
        self,
        cloth: Cloth,
        material: ClothMaterial,
        scalar: ScalarType,
        device: wp.Device,
        weight: ArrayLike | None = None,
        shares: ArrayLike | None = None,
    ) -> None:
        """Upload the rest shape.

        Args:
            cloth: T triangles in panels.
            material: material of the triangles.
            scalar: Warp's floating-point type.
            device: where the kernels run.
            weight: blending weight 1 - alpha of each triangle, shape (T,); by default 1.
            shares: factors of the energies along course and wale, shape (T, 2); by default 1.

        Raises:
            ParameterError: a weight is not in [0, 1].
        """
        self.device, self.scalar, count = device, scalar, len(cloth.triangles)
        edges = cloth.rest[:, 1:] - cloth.rest[:, :1]
        three = vector(3, scalar)
        self._corner = self._integers(cloth.triangles, wp.vec3i)
        # the rows of the inverse of the edge matrix are the gradients of the linear functions of corners 2 and 3
        gradient = np.linalg.inv(np.swapaxes(edges, 1, 2))
        self._gradient = wp.array(gradient, dtype=matrix(2, scalar), device=device)
        amount = cloth.rest_area * checked_weights(weight, count)
        self._amount = wp.array(amount, dtype=scalar, device=device)
        curves = material.energies()
        starts = np.concatenate([[0], np.cumsum([len(curve.strain) for curve in curves])])
        self._curve_start = self._integers(starts, wp.int32)
        nodes = np.concatenate([curve.nodes for curve in curves])
        self._curve_nodes = wp.array(nodes, dtype=vector(4, scalar), device=device)
        self._coupling = scalar(material.coupling)
        of_axes = np.ones((count, 2)) if shares is None else np.asarray(shares, dtype=np.float64)
        self._share = wp.array(of_axes, dtype=vector(2, scalar), device=device)
        self._gather = GatherTable.of(cloth.triangles, len(cloth.vertices), device)
        self._energy = wp.zeros(count, dtype=scalar, device=device)
        self._slots = wp.zeros(3 * count, dtype=three, device=device)
        self._column = wp.zeros((2, count), dtype=three, device=device)
        self._stress = wp.zeros(count, dtype=three, device=device)
        self._stiffness = wp.zeros(count, dtype=vector(4, scalar), device=device)
        self._blocks: wp.array[Any] | None = None

    def _integers(self, values: ArrayLike, kind: Any) -> wp.array[Any]:
        return wp.array(np.asarray(values, dtype=np.int32), dtype=kind, device=self.device)

    @property
    def _laws(self) -> list[Any]:
        return [self._curve_start, self._curve_nodes, self._coupling, self._share]

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of each triangle, and the array of the energies."""
        inputs = [self._corner, self._gradient, self._amount, *self._laws, state.vertices]
        return [launcher(find_triangle_energies, len(self._corner), inputs, [self._energy])], self._energy

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add the forces of the triangles."""
        inputs = [self._corner, self._gradient, self._amount, *self._laws, state.vertices]
        found = launcher(find_triangle_forces, len(self._corner), inputs, [self._slots])
        return [found, *self._gather.launches(self._slots, force.vertices, launcher)]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that stores columns, stresses and stiffnesses."""
        inputs = [float(self.exact), self._corner, self._gradient, *self._laws, state.vertices]
        outputs = [self._column, self._stress, self._stiffness]
        return [launcher(find_triangle_stiffness, len(self._corner), inputs, outputs)]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add the products of the Hessian."""
        inputs = [self._corner, self._gradient, self._amount, self._column, self._stress, self._stiffness]
        inputs.append(direction.vertices)
        found = launcher(find_triangle_products, len(self._corner), inputs, [self._slots])
        return [found, *self._gather.launches(self._slots, product.vertices, launcher)]

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that add the diagonal blocks."""
        if self._blocks is None:
            self._blocks = wp.zeros(len(self._slots), dtype=matrix(3, self.scalar), device=self.device)
        inputs = [self._gradient, self._amount, self._column, self._stress, self._stiffness]
        found = launcher(find_triangle_blocks, len(self._corner), inputs, [self._blocks])
        return [found, *self._gather.launches(self._blocks, blocks.vertices, launcher)]
