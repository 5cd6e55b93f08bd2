# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The lumped mass of crossing yarns, from their mass matrix (Cirio et al. 2014, section 3).

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
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import vector
from stitchmesh.mixed.crossings.crossing_elements import CrossingElements
from stitchmesh.mixed.crossings.energies.crossing_energies import guarded_inverse
from stitchmesh.mixed.crossings.star.star import coordinate_of, leg_vector
from stitchmesh.mixed.mixed_vector import MixedVector

SLIDING_INERTIA = 1e-3
"""Share of the mass of the yarn beside a node that resists sliding by itself."""


@wp.func
def leg_rest(link: int, k: int, own: Any, sliding: wp.array[Any]) -> Any:
    """Rest length of the segment of leg k; ``own`` is the node's coordinate along it."""
    rest = coordinate_of(link, sliding, own) - own
    if k % 2 == 1:
        rest = -rest
    return rest


@wp.func
def leg_density(link: int, k: int, i: int, density: wp.array2d[Any]) -> Any:
    """Linear density [g/cm] of the segment of leg k of node i."""
    result = density[i, k // 2]
    if k % 2 == 1:
        result = density[link // 2, link % 2]
    return result


@wp.func
def slope_of(link: int, k: int, rest: Any, merging: Any, nodes: wp.array[Any], here: Any) -> Any:
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
    density: wp.array2d[Any],
    segment: wp.array2d[Any],
    # state in
    nodes: wp.array[Any],
    sliding: wp.array[Any],
    # state out
    leg_slope: wp.array2d[Any],
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
    slides: wp.array[Any],
    inertia: Any,
    # state in
    leg_slope: wp.array2d[Any],
    # state out
    mass: wp.array[Any],
    coupling_u: wp.array[Any],
    coupling_v: wp.array[Any],
    sliding_mass: wp.array[Any],
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

    def __init__(self, elements: CrossingElements, scalar: Any, device: wp.Device) -> None:
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
