# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rods along the seams, to which yarns that reach a seam are joined (C 6.1).

A rod follows the edges of a seam. An edge with the vector r, rest length l_0, length l and axial stiffness k has the
energy k l_0 (l / l_0 - 1)^2 / 2. Two edges with the unit vectors t_1 and t_2 meet at the angle theta; with the bending
stiffness B and the mean length m of both edges at rest

    E = B (theta - theta_0)^2 / (2 m)

which for an arc is B / 2 times the square of the curvature, per length (Cirio et al. 2014, bending). The rest angle
theta_0 is the mean of the two angles of the seam in the planes of both panels. An angle that vanishes has no direction.
For theta_0 > 0 we therefore replace theta by (theta^2 + c^2 theta_0^2)^(1/2) and theta_0 by the value of this root at
theta_0, with c = 0.1, and scale by 1 + c^2, which keeps the place of the minimum and the stiffness there. The energy is
a smooth function f of q = |t_2 - t_1|^2 = 4 sin^2(theta / 2) up to theta = pi, where the sine is bounded below. The
first and second derivatives of f(q) are

    dE = 2 f' rho . d rho,    rho = t_2 - t_1,    d t = (1 - t t^T) d r / l
    d^2 E = 2 f' |d rho|^2 + 4 f'' (rho . d rho)^2 + 2 f' rho . d^2 rho

The Hessian that is never negative leaves out the last part, negative values of f' and f'', and the part of a compressed
edge across its direction. The angle between the triangles across a seam belongs to ``shell_bending``.

``SeamMaterial`` is the material of the rods: seam allowances and sewing thread (C 6.1). The rest shape of a rod lies
between the rest shapes of the two panels that meet at the seam.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Mat33, Scalar, ScalarType, Vec3, Vec5, matrix, vector
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.gather import GatherTable
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import MixedTerm
from stitchmesh.mixed.triangles.cloth_material import checked_weights

SMOOTHING = wp.constant(0.1)
"""The number c in the docstring of this module."""
LEAST_SINE = wp.constant(0.01)
"""Lower bound of the sine of an angle near pi."""
NEARLY_STRAIGHT = wp.constant(0.1)
"""Angle below which quotients that vanish with it are taken from their series [rad]."""
LEAST_LENGTH = wp.constant(1e-4)
"""Smallest length of an edge as a part of its rest length."""


@dataclass(frozen=True)
class SeamMaterial:
    """A material of rods along seams.

    Raises:
        ParameterError: a number is negative or not finite, or the rod has neither stiffness.
    """

    stretch: float
    """Axial stiffness: tension over strain [dyn]."""
    bending: float
    """Bending stiffness: moment over curvature [dyn cm^2]."""
    density: float = 0.0
    """Mass per length [g / cm]."""

    def __post_init__(self) -> None:
        for name in ("stretch", "bending", "density"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise ParameterError(f"seam material: {name} is {value}; expected a number that is not negative")
        if self.stretch == 0.0 and self.bending == 0.0:
            raise ParameterError("seam material: stretch and bending are 0; expected one of them; leave the rods out")


def rest_lengths(cloth: Cloth) -> NDArray[np.float64]:
    """Rest length of each edge of a seam [cm], the mean of its lengths in both panels; shape (S,)."""
    edges = np.diff(cloth.side_rest, axis=1)[:, 0][cloth.seam_sides]
    lengths: NDArray[np.float64] = np.linalg.norm(edges, axis=2).mean(axis=1)
    return lengths


def following_edges(cloth: Cloth) -> NDArray[np.int64]:
    """The edge after each edge on its seam, shape (S,): the first one at the end of a closed seam, -1 for none."""
    following = np.arange(1, len(cloth.seam_edges) + 1)
    first, last = cloth.seam_start[:-1], cloth.seam_start[1:] - 1
    closed = cloth.seam_edges[last, 1] == cloth.seam_edges[first, 0]
    following[last] = np.where(closed & (last > first), first, -1)
    return following


def rest_angles(cloth: Cloth, following: NDArray[np.int64]) -> NDArray[np.float64]:
    """Rest angle between each edge and the one that follows it [rad], shape (S,).

    It is the mean of the angles in the planes of both panels, and 0 where both edges lie in different panels.
    """
    edges = np.diff(cloth.side_rest, axis=1)[:, 0][cloth.seam_sides]
    one, other = edges, edges[following]
    turning = np.abs(np.arctan2(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0], (one * other).sum(axis=2)))
    panel = cloth.panel[cloth.seam_sides // 3]
    same = (panel == panel[following]).all(axis=1) & (following >= 0)
    return np.where(same, turning.mean(axis=1), 0.0)


@wp.func
def leg(from_: int, to: int, vertices: Any) -> Any:
    """The vector of an edge; zero for an edge that does not exist."""
    if to < 0:
        return vertices[from_] * type(vertices[from_][0])(0.0)
    return vertices[to] - vertices[from_]


@wp.func
def unit_of(r: Vec3, rest: Scalar) -> tuple[Any, Any]:
    """Direction and length of an edge; the length is bounded below."""
    length = wp.max(wp.length(r), rest * type(rest)(LEAST_LENGTH))
    return r / length, length


@wp.func
def bend_of(q: Scalar, stiffness: Scalar, rest_angle: Scalar) -> tuple[Any, Any, Any]:
    """Energy f and its derivatives f' and f'' by q."""
    one, two, half = type(q)(1.0), type(q)(2.0), type(q)(0.5)
    angle = two * wp.asin(wp.min(half * wp.sqrt(q), one))
    sine = wp.max(wp.sin(angle), type(q)(LEAST_SINE))
    ratio = angle / sine  # derivative of angle^2 by q
    change = (sine - angle * wp.cos(angle)) / (two * sine * sine * sine)  # derivative of ratio by q
    square = angle * angle
    if angle < type(q)(NEARLY_STRAIGHT):
        ratio = one + square / type(q)(6.0)
        change = one / type(q)(6.0) + square / type(q)(15.0)
    if rest_angle == one - one:
        return half * stiffness * square, half * stiffness * ratio, half * stiffness * change
    smooth = type(q)(SMOOTHING)
    scale = stiffness * (one + smooth * smooth)
    near = wp.sqrt(square + smooth * smooth * rest_angle * rest_angle)
    rest = rest_angle * wp.sqrt(one + smooth * smooth)
    by_square, twice = half * scale * (one - rest / near), half * half * scale * rest / (near * near * near)
    return half * scale * (near - rest) * (near - rest), by_square * ratio, twice * ratio * ratio + by_square * change


@wp.func
def leg_gradients(r1: Vec3, r2: Vec3, constants: Vec5) -> tuple[Any, Any, Any]:
    """Energy of an element and its derivatives by its two edges; constants: k, B / m, theta_0, both rest lengths."""
    t1, l1 = unit_of(r1, constants[3])
    t2, l2 = unit_of(r2, constants[4])
    strain = l1 / constants[3] - type(l1)(1.0)
    stretch = constants[0] * strain
    energy = stretch * strain * constants[3] / type(l1)(2.0)
    first, second = t1 * stretch, t1 - t1
    if constants[1] > l1 - l1:
        rho = t2 - t1
        bend, slope, _second_slope = bend_of(wp.dot(rho, rho), constants[1], constants[2])
        pull = rho * (slope + slope)
        energy += bend
        first += (t1 * wp.dot(t1, pull) - pull) / l1
        second += (pull - t2 * wp.dot(t2, pull)) / l2
    return energy, first, second


@wp.func
def turned_across(t: Vec3, dt: Vec3, pull: Vec3, d: Vec3, length: Scalar) -> Any:
    """Derivative of (1 - t t^T) pull / l for a constant pull."""
    along = wp.dot(t, pull)
    return -(dt * along + t * wp.dot(dt, pull)) / length - (pull - t * along) * (wp.dot(t, d) / (length * length))


@wp.func
def leg_products(r1: Vec3, r2: Vec3, constants: Vec5, exact: Scalar, d1: Vec3, d2: Vec3) -> tuple[Any, Any]:
    """Hessian of the energy of an element times changes of its two edges."""
    t1, l1 = unit_of(r1, constants[3])
    t2, l2 = unit_of(r2, constants[4])
    zero, two = l1 - l1, type(l1)(2.0)
    tight = (l1 / constants[3] - type(l1)(1.0)) * constants[0] / l1
    tight = wp.max(tight, tight * exact)
    along = wp.dot(t1, d1)
    first, second = t1 * (along * constants[0] / constants[3]) + (d1 - t1 * along) * tight, t1 * zero
    if constants[1] > zero:
        rho = t2 - t1
        _bend, slope, twice = bend_of(wp.dot(rho, rho), constants[1], constants[2])
        dt1, dt2 = (d1 - t1 * along) / l1, (d2 - t2 * wp.dot(t2, d2)) / l2
        change = dt2 - dt1
        pull_change = change * (two * wp.max(slope, slope * exact))
        pull_change += rho * (two * two * wp.max(twice, twice * exact) * wp.dot(rho, change))
        pull = rho * (two * slope * exact)
        first += (t1 * wp.dot(t1, pull_change) - pull_change) / l1 - turned_across(t1, dt1, pull, d1, l1)
        second += (pull_change - t2 * wp.dot(t2, pull_change)) / l2 + turned_across(t2, dt2, pull, d2, l2)
    return first, second


@kernel
def find_rod_energies(
    # model
    corner: wp.array[wp.vec3i],
    constants: wp.array[Vec5],
    # state in
    vertices: wp.array[Vec3],
    # state out
    energy: wp.array[Scalar],
) -> None:
    """Energy [erg] of each element."""
    k = wp.tid()
    c = corner[k]
    found, _first, _second = leg_gradients(leg(c[0], c[1], vertices), leg(c[1], c[2], vertices), constants[k])
    energy[k] = found


@kernel
def find_rod_forces(
    # model
    corner: wp.array[wp.vec3i],
    constants: wp.array[Vec5],
    # state in
    vertices: wp.array[Vec3],
    # state out
    corner_force: wp.array[Vec3],
) -> None:
    """Forces [dyn] of each element on its vertices."""
    k = wp.tid()
    c = corner[k]
    _energy, first, second = leg_gradients(leg(c[0], c[1], vertices), leg(c[1], c[2], vertices), constants[k])
    corner_force[3 * k] = first
    corner_force[3 * k + 1] = second - first
    corner_force[3 * k + 2] = -second


@kernel
def keep_legs(
    # model
    part: float,
    corner: wp.array[wp.vec3i],
    # state in
    vertices: wp.array[Vec3],
    # state out
    legs: wp.array2d[Vec3],
    exact: wp.array[Scalar],
) -> None:
    """What the products need: the edges of each element, and the part of the exact Hessian."""
    k = wp.tid()
    c = corner[k]
    legs[0, k] = leg(c[0], c[1], vertices)
    legs[1, k] = leg(c[1], c[2], vertices)
    exact[k] = type(exact[0])(part)


@kernel
def find_rod_products(
    # model
    corner: wp.array[wp.vec3i],
    constants: wp.array[Vec5],
    legs: wp.array2d[Vec3],
    exact: wp.array[Scalar],
    # state in
    direction: wp.array[Vec3],
    # state out
    corner_product: wp.array[Vec3],
) -> None:
    """Hessian times direction [dyn] at the vertices of each element."""
    k = wp.tid()
    c = corner[k]
    d1, d2 = leg(c[0], c[1], direction), leg(c[1], c[2], direction)
    first, second = leg_products(legs[0, k], legs[1, k], constants[k], exact[k], d1, d2)
    corner_product[3 * k] = -first
    corner_product[3 * k + 1] = first - second
    corner_product[3 * k + 2] = second


@kernel
def find_rod_blocks(
    # model
    constants: wp.array[Vec5],
    legs: wp.array2d[Vec3],
    exact: wp.array[Scalar],
    # state out
    block: wp.array[Mat33],
) -> None:
    """Blocks of the Hessian [dyn / cm] on the diagonal at the vertices of each element."""
    slot = wp.tid()
    k = slot // 3
    part = slot - 3 * k
    found = block[slot]
    for axis in range(3):
        unit = legs[0, k] - legs[0, k]
        unit[axis] = type(exact[0])(1.0)
        d1, d2 = unit - unit, unit - unit
        if part < 2:
            d1 += unit
        if part > 0:
            d2 += unit
        if part == 0:
            d1 = -d1
        if part == 1:
            d2 = -d2
        first, second = leg_products(legs[0, k], legs[1, k], constants[k], exact[k], d1, d2)
        column = first - second
        if part == 0:
            column = -first
        if part == 2:
            column = second
        for row in range(3):
            found[row, axis] = column[row]
    block[slot] = found


class SeamRod(MixedTerm):
    """The rods along all seams of a cloth, on a device."""

    name = "seam rods"
    acts_on = "vertices"

    def __init__(
        self, cloth: Cloth, material: SeamMaterial, scalar: ScalarType, device: wp.Device,
        weight: ArrayLike | None = None,
    ) -> None:  # fmt: skip
        """Upload the elements: each edge of a seam with the edge that follows it, if there is one.

        Args:
            cloth: a cloth with S edges on seams.
            material: stiffness of the rods.
            scalar: Warp's floating-point type.
            device: where the kernels run.
            weight: blending weight of each edge, shape (S,); by default 1. The weight of an angle is the smaller weight
                of its two edges; the far vertex of an edge without weight is not read.

        Raises:
            ParameterError: a weight is not in [0, 1].
        """
        self.device, self.scalar, self._count = device, scalar, len(cloth.seam_edges)
        three = vector(3, scalar)
        corners, constants = _elements(cloth, material, checked_weights(weight, self._count))
        self._corner = wp.array(corners.astype(np.int32), dtype=wp.vec3i, device=device)
        self._constants = wp.array(constants, dtype=vector(5, scalar), device=device)
        self._gather = GatherTable.of(corners, len(cloth.vertices), device)
        self._energy, self._exact = (wp.zeros(self._count, dtype=scalar, device=device) for _ in range(2))
        self._legs = wp.zeros((2, self._count), dtype=three, device=device)
        self._slots = wp.zeros(3 * self._count, dtype=three, device=device)
        self._blocks = wp.zeros(3 * self._count, dtype=matrix(3, scalar), device=device)

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of each rod element, and the array of the energies."""
        inputs = [self._corner, self._constants, state.vertices]
        return [launcher(find_rod_energies, self._count, inputs, [self._energy])], self._energy

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add the forces of the rods."""
        found = launcher(find_rod_forces, self._count, [self._corner, self._constants, state.vertices], [self._slots])
        return [found, *self._gather.launches(self._slots, force.vertices, launcher)]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that stores the edges."""
        inputs = [float(self.exact), self._corner, state.vertices]
        return [launcher(keep_legs, self._count, inputs, [self._legs, self._exact])]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add the products of the Hessian."""
        inputs = [self._corner, self._constants, self._legs, self._exact, direction.vertices]
        found = launcher(find_rod_products, self._count, inputs, [self._slots])
        return [found, *self._gather.launches(self._slots, product.vertices, launcher)]

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that add the diagonal blocks."""
        inputs = [self._constants, self._legs, self._exact]
        found = launcher(find_rod_blocks, 3 * self._count, inputs, [self._blocks])
        return [found, *self._gather.launches(self._blocks, blocks.vertices, launcher)]


def _elements(
    cloth: Cloth, material: SeamMaterial, weight: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Vertices of each element, -1 for a missing third one, shape (S, 3), and its constants, shape (S, 5)."""
    following = following_edges(cloth)
    of_angle = np.minimum(weight, weight[following])
    some, length = (following >= 0) & (of_angle > 0.0), rest_lengths(cloth)
    third = np.where(some, cloth.seam_edges[following, 1], -1)
    second_length = np.where(some, length[following], 1.0)
    bending = np.where(some, 2.0 * material.bending / (length + second_length), 0.0) * of_angle
    angle = rest_angles(cloth, following)
    constants = np.column_stack([material.stretch * weight, bending, angle, length, second_length])
    return np.column_stack([cloth.seam_edges, third]), constants
