# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bending of the cloth at the hinges between its triangles (C 4.1), with rest angles at seams.

With the angles theta of all hinges (``hinge_angle``), their rest angles theta_0, those of seams and of the curvature at
which the moments of the material are used up, and the matrix K of ``curvature``

    E = (theta - theta_0)^T K (theta - theta_0) / 2,    moments m = K (theta - theta_0)

The force is -sum over the hinges of m_h grad theta_h, and the product of the Hessian with a direction d

    sum over the hinges of  (K J d)_h grad theta_h + m_h (Hess theta_h) d,    J d = the derivatives of the angles

The first part is never negative, because K is not. The second part has no sign; the Hessian that is never negative
leaves it out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import matrix, vector
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.gather import GatherTable
from stitchmesh.mixed.mixed_blocks import MixedBlocks
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import MixedTerm
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.curvature import hinge_angles_of, hinge_stiffness
from stitchmesh.mixed.triangles.hinge_angle import (
    angle_gradient,
    gradient_change,
    hinge_angle,
    hinge_frame,
    least_squares_of,
)
from stitchmesh.mixed.triangles.weights import checked_weights, materials_of_panels


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
    rest_angle: wp.array[Any],
    # state in
    vertices: wp.array[Any],
    # state out
    deflection: wp.array[Any],
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
    value: wp.array[Any],
    # state in
    deflection: wp.array[Any],
    # state out
    energy: wp.array[Any],
) -> None:
    """The part of each hinge in the energy [erg]."""
    h = wp.tid()
    energy[h] = row_times(start, column, value, deflection, h) * deflection[h] / type(deflection[0])(2.0)


@kernel
def find_hinge_forces(
    # model
    corner: wp.array[wp.vec4i],
    least: wp.array[Any],
    start: wp.array[wp.int32],
    column: wp.array[wp.int32],
    value: wp.array[Any],
    # state in
    vertices: wp.array[Any],
    deflection: wp.array[Any],
    # state out
    corner_force: wp.array[Any],
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
    least: wp.array[Any],
    start: wp.array[wp.int32],
    column: wp.array[wp.int32],
    value: wp.array[Any],
    # state in
    vertices: wp.array[Any],
    deflection: wp.array[Any],
    # state out
    frame: wp.array2d[Any],
    gradient: wp.array2d[Any],
    moment: wp.array[Any],
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
    gradient: wp.array2d[Any],
    # state in
    direction: wp.array[Any],
    # state out
    turn: wp.array[Any],
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
    least: wp.array[Any],
    start: wp.array[wp.int32],
    column: wp.array[wp.int32],
    value: wp.array[Any],
    frame: wp.array2d[Any],
    gradient: wp.array2d[Any],
    moment: wp.array[Any],
    # state in
    direction: wp.array[Any],
    turn: wp.array[Any],
    # state out
    corner_product: wp.array[Any],
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
    value: wp.array[Any],
    gradient: wp.array2d[Any],
    # state out
    block: wp.array[Any],
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
        materials: ClothMaterial | Sequence[ClothMaterial],
        scalar: Any,
        device: wp.Device,
        weight: ArrayLike | None = None,
    ) -> None:
        """Upload the hinges and the matrix between them.

        Args:
            cloth: T triangles in panels, with H hinges and their rest angles.
            materials: one material for all panels, or one for each panel.
            scalar: Warp's floating-point type.
            device: where the kernels run.
            weight: blending weight 1 - alpha of each triangle, shape (T,); by default 1.

        Raises:
            ParameterError: the number of materials is not that of the panels, or a weight is not in [0, 1].
        """
        self.device, self.scalar, hinges = device, scalar, cloth.hinges
        self._count, three = len(hinges), vector(3, scalar)
        chosen = materials_of_panels(materials, len(cloth.panel_names))
        of_panel = cloth.panel if len(chosen) > 1 else np.zeros_like(cloth.panel)
        rigidities = np.array([one.rigidities() for one in chosen])[of_panel]
        curled = hinge_angles_of(cloth, np.array([one.rest_curvature() for one in chosen])[of_panel])
        weights = checked_weights(weight, len(cloth.triangles))
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
        """The launch that finds the energy of each hinge, and where it is."""
        if self._count == 0:
            return [], self._energy
        deflections = self._find_deflections(state, launcher)
        found = launcher(find_hinge_energies, self._count, [*self._rows, self._deflection], [self._energy])
        return [deflections, found], self._energy

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add the forces of the hinges."""
        if self._count == 0:
            return []
        deflections = self._find_deflections(state, launcher)
        inputs = [self._corner, self._least, *self._rows, state.vertices, self._deflection]
        found = launcher(find_hinge_forces, self._count, inputs, [self._slots])
        return [deflections, found, *self._gather.launches(self._slots, force.vertices, launcher)]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that store the frames and the moments."""
        if self._count == 0:
            return []
        deflections = self._find_deflections(state, launcher)
        inputs = [float(self.exact), self._corner, self._least, *self._rows, state.vertices, self._deflection]
        outputs = [self._frame, self._gradient, self._moment]
        return [deflections, launcher(find_hinge_frames, self._count, inputs, outputs)]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add the products of the Hessian."""
        if self._count == 0:
            return []
        inputs = [self._corner, self._gradient, direction.vertices]
        turns = launcher(find_turns, self._count, inputs, [self._turn])
        inputs = [self._corner, self._least, *self._rows, self._frame, self._gradient, self._moment]
        inputs += [direction.vertices, self._turn]
        found = launcher(find_hinge_products, self._count, inputs, [self._slots])
        return [turns, found, *self._gather.launches(self._slots, product.vertices, launcher)]

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that add the diagonal blocks of the first part of the Hessian, which is never negative."""
        if self._count == 0:
            return []
        if self._blocks is None:
            self._blocks = wp.zeros(4 * self._count, dtype=matrix(3, self.scalar), device=self.device)
        inputs = [self._corner, *self._rows, self._gradient]
        found = launcher(find_hinge_blocks, 4 * self._count, inputs, [self._blocks])
        return [found, *self._gather.launches(self._blocks, blocks.vertices, launcher)]
