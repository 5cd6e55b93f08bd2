# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The lumped mass and the weight of crossing yarns (Cirio et al. 2014, sections 3 and 4.1).

The yarn at a place of a segment moves with the nodes and with the yarn that slides through them. With w = (x1 - x0) / D
and D = u1 - u0, its velocity is a mean of n0 = dx0/dt - w du0/dt and n1 = dx1/dt - w du1/dt, and the kinetic energy is

    T = 1/2 (rho D / 6) (2 n0 . n0 + 2 n0 . n1 + 2 n1 . n1)

This is the published matrix (rho D / 6) [[2I, -2w, I, -w], [-2w', 2w'w, -w', w'w], [I, -w, 2I, -2w], [-w', w'w, -2w',
2w'w]] of (x0, u0, x1, u1). It changes with the state and is taken as constant within a step.

*Lumped blocks.* The row sums of the matrix in n give each node half of the yarn of each segment, (rho D / 2) n . n.
With the sum over the segments of both yarns, this is a symmetric block of 5 x 5 for (x, u, v):

    [[m I, -c_u, -c_v], [-c_u', d_u, 0], [-c_v', 0, d_v]]
    m = sum rho D / 2,   c_u = sum rho D / 2 w,   d_u = sum rho D / 2 w . w

The block is positive, but singular where a yarn is straight and alone. Sliding along the yarn is then motion of the
same material, d_u - c_u . c_u / m = 0. Where two yarns cross, the yarn that does not slide has its share of m, and the
block is regular. The block here has a d that is larger by the share ``SLIDING_INERTIA``, and its rows of fixed
coordinates are zero.

*Weight.* A segment between two nodes holds yarn of the rest length D = u1 - u0 and the mass rho D:

    E = - rho D g . (x0 + x1) / 2

Yarn that slides to another segment changes its height, so gravity also acts on the coordinates: a yarn that hangs over
a crossing runs to its heavier side. The Hessian couples D with the positions and is not positive; the matrix that is
never negative is zero. The coupling rho g is about 20 dyn/cm, against 1e5 dyn/cm of stretch, and products leave it out.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, ScalarType, Vec2, Vec3, Vec4, vector
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.crossings.crossing_term import CrossingElements
from stitchmesh.mixed.crossings.energies.crossing_energies import guarded_inverse
from stitchmesh.mixed.crossings.star.star import coordinate_of, leg_vector
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import MixedTerm
from stitchmesh.simulation.dead_load import EARTH

SLIDING_INERTIA = 1e-3
"""Share of the mass of the yarn beside a node that resists sliding by itself."""


@wp.func
def leg_rest(link: int, k: int, own: Scalar, sliding: wp.array[Vec2]) -> Any:
    """Rest length of the segment of leg k; ``own`` is the node's coordinate along it."""
    rest = coordinate_of(link, sliding, own) - own
    if k % 2 == 1:
        rest = -rest
    return rest


@wp.func
def leg_density(link: int, k: int, i: int, density: wp.array2d[Scalar]) -> Any:
    """Linear density [g/cm] of the segment of leg k of node i."""
    result = density[i, k // 2]
    if k % 2 == 1:
        result = density[link // 2, link % 2]
    return result


@wp.func
def slope_of(link: int, k: int, rest: Scalar, merging: Scalar, nodes: wp.array[Vec3], here: Vec3) -> Any:
    """W of the segment of leg k, in the direction of the yarn."""
    inverse, _slope, _bend = guarded_inverse(rest, merging)
    leg = leg_vector(link, nodes, here) * inverse
    if k % 2 == 1:
        leg = -leg
    return leg


@kernel
def find_mass_rows(
    # model
    link: wp.array2d[wp.int32],
    density: wp.array2d[Scalar],
    segment: wp.array2d[Vec4],
    # state in
    nodes: wp.array[Vec3],
    sliding: wp.array[Vec2],
    # state out
    leg_slope: wp.array2d[Vec4],
) -> None:
    """W and rho D / 6 of each leg, as four-vectors; zero without a neighbour."""
    i = wp.tid()
    n = int(4)
    for k in range(n):
        row = type(leg_slope[i, k])()
        code = link[i, k]
        if code >= 0:
            rest = leg_rest(code, k, sliding[i][k // 2], sliding)
            merging = segment[i, k // 2][3]
            if k % 2 == 1:
                merging = segment[code // 2, code % 2][3]
            w = slope_of(code, k, rest, merging, nodes, nodes[i])
            mass = leg_density(code, k, i, density) * wp.max(rest, merging) / type(rest)(6.0)
            row = type(row)(w[0], w[1], w[2], mass)
        leg_slope[i, k] = row


@kernel
def find_mass_blocks(
    # model
    link: wp.array2d[wp.int32],
    slides: wp.array[Vec2],
    inertia: Scalar,
    # state in
    leg_slope: wp.array2d[Vec4],
    # state out
    mass: wp.array[Scalar],
    coupling_u: wp.array[Vec3],
    coupling_v: wp.array[Vec3],
    sliding_mass: wp.array[Vec2],
) -> None:
    """m, -c_u, -c_v and d of each node's lumped block."""
    i = wp.tid()
    total = inertia - inertia
    along_u, along_v = type(coupling_u[i])(), type(coupling_u[i])()
    own = type(sliding_mass[i])()
    three, one = type(inertia)(3.0), type(inertia)(1.0)
    n = int(4)
    for k in range(n):
        if link[i, k] >= 0:
            row = leg_slope[i, k]
            w = type(along_u)(row[0], row[1], row[2])
            half = row[3] * three
            total += half
            own[k // 2] += half * wp.dot(w, w) * (one + inertia)
            if k < 2:
                along_u -= w * half
            else:
                along_v -= w * half
    mass[i] = total
    coupling_u[i] = along_u * slides[i][0]
    coupling_v[i] = along_v * slides[i][1]
    sliding_mass[i] = wp.cw_mul(own, slides[i])


class YarnMass:
    """The mass of crossing yarns on a device, at the state for which ``update_launches`` ran last."""

    def __init__(self, elements: CrossingElements, scalar: ScalarType, device: wp.Device) -> None:
        """Put the densities on a device.

        Args:
            elements: the yarns.
            scalar: Warp's floating-point type.
            device: where the mass lies.
        """
        count, three = elements.count, vector(3, scalar)
        self.count, self.device = count, device
        self._link = wp.array(elements.link.astype(np.int32), dtype=wp.int32, device=device)
        self._slides = wp.array(elements.slides.astype(np.float64), dtype=vector(2, scalar), device=device)
        self._density = wp.array(elements.density, dtype=scalar, device=device)
        merging = np.zeros((count, 2, 4))
        merging[..., 3] = elements.merging_distance
        self._segment = wp.array(merging, dtype=vector(4, scalar), device=device)
        self._inertia = scalar(SLIDING_INERTIA)
        self.leg_slope = wp.zeros((count, 4), dtype=vector(4, scalar), device=device)
        self.mass = wp.zeros(count, dtype=scalar, device=device)
        """m of each node [g], shape (N,)."""
        self.coupling = [wp.zeros(count, dtype=three, device=device) for _ in range(2)]
        """-c_u and -c_v of each node [g], shape (N,) each."""
        self.sliding_mass = wp.zeros(count, dtype=vector(2, scalar), device=device)
        """d_u and d_v of each node [g], shape (N,)."""

    def update_launches(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that find the mass at a state."""
        if self.count == 0:
            return []
        inputs = [self._link, self._density, self._segment, state.nodes, state.sliding]
        blocks = [self.mass, *self.coupling, self.sliding_mass]
        return [
            launcher(find_mass_rows, self.count, inputs, [self.leg_slope]),
            launcher(find_mass_blocks, self.count, [self._link, self._slides, self._inertia, self.leg_slope], blocks),
        ]


@wp.func
def signed_density(link: int, k: int, i: int, density: wp.array2d[Scalar]) -> Any:
    """Linear density [g/cm] of the segment of leg k of node i, positive after the node and negative before it."""
    result = leg_density(link, k, i, density)
    if k % 2 == 1:
        result = -result
    return result


@kernel
def find_weight_energies(
    # model
    link: wp.array2d[wp.int32],
    density: wp.array2d[Scalar],
    acceleration: Vec3,
    # state in
    nodes: wp.array[Vec3],
    sliding: wp.array[Vec2],
    # state out
    energy: wp.array[wp.float64],
) -> None:
    """Potential energy [erg] of the segments after each node."""
    i = wp.tid()
    total = wp.float64(0.0)
    for c in range(2):
        after = link[i, 2 * c]
        if after >= 0:
            own = sliding[i][c]
            mass = density[i, c] * (coordinate_of(after, sliding, own) - own)
            middle = nodes[i] + leg_vector(after, nodes, nodes[i]) * type(own)(0.5)
            total -= wp.float64(mass * wp.dot(acceleration, middle))
    energy[i] = total


@kernel
def add_yarn_weights(
    # model
    link: wp.array2d[wp.int32],
    slides: wp.array[Vec2],
    density: wp.array2d[Scalar],
    acceleration: Vec3,
    # state in
    nodes: wp.array[Vec3],
    sliding: wp.array[Vec2],
    # state out
    on_nodes: wp.array[Vec3],
    on_sliding: wp.array[Vec2],
) -> None:
    """Add the weight of the yarn around each node, on its position and its coordinates."""
    i = wp.tid()
    half = type(sliding[i][0])(0.5)
    on_coordinates = type(slides[i])()
    mass = half - half
    n = int(4)
    for k in range(n):
        if link[i, k] >= 0:
            own = sliding[i][k // 2]
            signed = signed_density(link[i, k], k, i, density)
            mass += half * signed * (coordinate_of(link[i, k], sliding, own) - own)
            middle = nodes[i] + leg_vector(link[i, k], nodes, nodes[i]) * half
            on_coordinates[k // 2] -= signed * wp.dot(acceleration, middle)
    on_nodes[i] += acceleration * mass
    on_sliding[i] += wp.cw_mul(on_coordinates, slides[i])


class YarnGravity(MixedTerm):
    """The weight of crossing yarns on a device; the energy is relative to the origin."""

    name = "gravity of crossing yarns"
    acts_on = "nodes"
    is_load = True

    def __init__(
        self,
        elements: CrossingElements,
        scalar: ScalarType,
        device: wp.Device,
        acceleration: ArrayLike = EARTH,
    ) -> None:
        """Put the densities on a device.

        Args:
            elements: the yarns.
            scalar: Warp's floating-point type.
            device: where the term lies.
            acceleration: acceleration by gravity [cm/s^2], shape (3,).

        Raises:
            ParameterError: the acceleration is not three finite numbers.
        """
        pull = np.asarray(acceleration, dtype=np.float64)
        if pull.shape != (3,) or not np.isfinite(pull).all():
            raise ParameterError(f"gravity: got the acceleration {pull.tolist()}; expected three finite numbers")
        self.count, self.device = elements.count, device
        self._link = wp.array(elements.link.astype(np.int32), dtype=wp.int32, device=device)
        self._slides = wp.array(elements.slides.astype(np.float64), dtype=vector(2, scalar), device=device)
        self._density = wp.array(elements.density, dtype=scalar, device=device)
        self._acceleration = vector(3, scalar)(*pull)
        self._energy = wp.zeros(self.count, dtype=wp.float64, device=device)

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of the segments of each node, and the array of the energies."""
        inputs = [self._link, self._density, self._acceleration, state.nodes, state.sliding]
        return [launcher(find_weight_energies, self.count, inputs, [self._energy])], self._energy

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that adds the weights."""
        inputs = [self._link, self._slides, self._density, self._acceleration, state.nodes, state.sliding]
        return [launcher(add_yarn_weights, self.count, inputs, [force.nodes, force.sliding])]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """No launch: the Hessian is left out."""
        return []

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """No launch: the products are zero."""
        return []
