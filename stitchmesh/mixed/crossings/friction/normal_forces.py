# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The force that presses the two yarns of a crossing together, from the equilibrium of each yarn (Cirio et al. 2014).

A node has one position for both yarns, so the model has no force between them. The force follows from F_u and F_v, the
forces of stretch and bending with which the u yarn and the v yarn act on the node.

*Weave.* The centre lines of the two yarns pass above and below the node at the distance of their radii, along the
normal n of the fabric. They are at x + h n, where h = +R_u or -R_u for the u yarn, with the opposite sign for the v
yarn (``side``). F_u and F_v are computed on these offset centre lines: tension pulls along the offset segments, and
bending turns at the crimp. A crossing force s N n, with the side s of the u yarn, balances both yarns as well as one
number can (least squares of n . F_u + s N and n . F_v - s N), where neither yarn pulls the other one away:

    N = (max(0, -s n . F_u) + max(0, s n . F_v)) / 2

A yarn that is compressed along its axis bows out at the crimp before it would pull. Planar nodes do not bow, so the
part of this yarn is zero, and the bending of the other yarn still presses.

In a plain weave of spacing L, with tension T in one family of yarns and none in the other, each crossing has
N = 1/2 T (4 R / L') with L'^2 = L^2 + (2 R)^2. Bending of straight yarns into the crimp presses without any tension
(16 EI R / L^3 for each yarn, for a small crimp); it holds a fabric together that carries no load. It carries the weight
rho g L of a yarn between two crossings if L^4 < 16 mu EI R / (rho g); a wider weave needs tension.

*Knit.* In a stitch contact both yarns run along the axis between the two nodes of the contact, and each pulls the other
across this axis e:

    N = |(I - e e^T)(F_v - F_u)| / 2

with the forces of the planar centre lines.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, ScalarType, Vec2, Vec3, Vec4, vector
from stitchmesh.mixed.crossings.crossing_term import CrossingElements, CrossingModel, Integers
from stitchmesh.mixed.crossings.energies.crossing_energies import (
    angle_gradient,
    bending_slopes,
    stretch_slopes,
    unit_of,
)
from stitchmesh.mixed.crossings.star.star import coordinate_of, leg_vector
from stitchmesh.mixed.mixed_vector import MixedVector


@kernel
def find_fabric_normals(
    # model
    link: wp.array2d[wp.int32],
    # state in
    nodes: wp.array[Vec3],
    # state out
    normal: wp.array[Vec3],
) -> None:
    """Unit normal of the fabric at each node, from the directions of its two yarns; zero at the end of a yarn."""
    i = wp.tid()
    here = nodes[i]
    along = leg_vector(link[i, 0], nodes, here) - leg_vector(link[i, 1], nodes, here)
    across = leg_vector(link[i, 2], nodes, here) - leg_vector(link[i, 3], nodes, here)
    direction, _inverse = unit_of(wp.cross(along, across))
    normal[i] = direction


@wp.func
def centre(node: int, c: int, nodes: wp.array[Vec3], normal: wp.array[Vec3], height: wp.array[Vec2]) -> Any:
    """Point of the centre line of yarn c at a node."""
    return nodes[node] + normal[node] * height[node][c]


@wp.func
def bend_at(
    link: wp.array2d[wp.int32], bend: wp.array2d[Vec2], turn: wp.array2d[Scalar], nodes: wp.array[Vec3],
    sliding: wp.array[Vec2], normal: wp.array[Vec3], height: wp.array[Vec2], node: int, c: int,
) -> tuple[Any, Any]:  # fmt: skip
    """Forces of the bending of yarn c at a node on the segments before and after, as vectors from end to end."""
    on_before, on_after = nodes[0] - nodes[0], nodes[0] - nodes[0]
    after, before = link[node, 2 * c], link[node, 2 * c + 1]
    if after >= 0 and before >= 0:
        here = centre(node, c, nodes, normal, height)
        a = here - centre(before // 2, before % 2, nodes, normal, height)
        b = centre(after // 2, after % 2, nodes, normal, height) - here
        own = sliding[node][c]
        span = coordinate_of(after, sliding, own) - coordinate_of(before, sliding, own)
        angle, by_a, by_b = angle_gradient(a, b)
        slope, _by_span = bending_slopes(angle, turn[node, c], span, bend[node, c][1], bend[node, c][0])
        on_before, on_after = -by_a * slope, -by_b * slope
    return on_before, on_after


@wp.func
def tension_of(
    link: wp.array2d[wp.int32], segment: wp.array2d[Vec4], nodes: wp.array[Vec3], sliding: wp.array[Vec2],
    normal: wp.array[Vec3], height: wp.array[Vec2], node: int, c: int,
) -> Any:  # fmt: skip
    """Pull [dyn] of the segment of yarn c after a node on this node, along the centre line."""
    pull = nodes[0] - nodes[0]
    after = link[node, 2 * c]
    if after >= 0:
        own = sliding[node][c]
        rest = coordinate_of(after, sliding, own) - own
        leg = leg_vector(after, nodes, nodes[node])
        tension, _by_rest = stretch_slopes(wp.length(leg), rest, segment[node, c][3], segment[node, c][0])
        end = centre(after // 2, after % 2, nodes, normal, height)
        direction, _inverse = unit_of(end - centre(node, c, nodes, normal, height))
        pull = direction * tension
    return pull


@wp.func
def force_of_yarn(
    link: wp.array2d[wp.int32], segment: wp.array2d[Vec4], bend: wp.array2d[Vec2], turn: wp.array2d[Scalar],
    nodes: wp.array[Vec3], sliding: wp.array[Vec2], normal: wp.array[Vec3], height: wp.array[Vec2], node: int, c: int,
) -> Any:  # fmt: skip
    """Force [dyn] of stretch and bending of yarn c on a node."""
    on_before, on_after = bend_at(link, bend, turn, nodes, sliding, normal, height, node, c)
    force = tension_of(link, segment, nodes, sliding, normal, height, node, c) + on_before - on_after
    after, before = link[node, 2 * c], link[node, 2 * c + 1]
    if after >= 0:
        first, _second = bend_at(link, bend, turn, nodes, sliding, normal, height, after // 2, after % 2)
        force -= first
    if before >= 0:
        _first, second = bend_at(link, bend, turn, nodes, sliding, normal, height, before // 2, before % 2)
        force += second
        force -= tension_of(link, segment, nodes, sliding, normal, height, before // 2, before % 2)
    return force


@kernel
def find_normal_forces(
    # model
    link: wp.array2d[wp.int32],
    segment: wp.array2d[Vec4],
    bend: wp.array2d[Vec2],
    height: wp.array[Vec2],
    axis: wp.array[wp.int32],
    # state in
    turn: wp.array2d[Scalar],
    nodes: wp.array[Vec3],
    sliding: wp.array[Vec2],
    normal: wp.array[Vec3],
    # state out
    pressing: wp.array[Scalar],
) -> None:
    """Force N [dyn] that presses the yarns of each crossing together."""
    i = wp.tid()
    of_u = force_of_yarn(link, segment, bend, turn, nodes, sliding, normal, height, i, 0)
    of_v = force_of_yarn(link, segment, bend, turn, nodes, sliding, normal, height, i, 1)
    half = type(height[i][0])(0.5)
    zero = half - half
    result = half - half
    if axis[i] >= 0:
        direction, _inverse = unit_of(leg_vector(link[i, axis[i]], nodes, nodes[i]))
        apart = of_v - of_u
        result = half * wp.length(apart - direction * wp.dot(direction, apart))
    else:
        side = normal[i] * wp.sign(height[i][0])
        result = half * (wp.max(-wp.dot(side, of_u), zero) + wp.max(wp.dot(side, of_v), zero))
    pressing[i] = result


@dataclass(frozen=True, eq=False)
class NormalForces:
    """The normal forces of N crossings on a device, and the values from which they are computed."""

    height: wp.array[Any]
    """Height of the centre lines of u yarn and v yarn over each node [cm], two-vectors; zero in a knit. Shape (N,)."""
    axis: wp.array[wp.int32]
    """Leg of each node along the axis of its stitch contact, -1 in a weave; shape (N,)."""
    normal: wp.array[Any]
    """Unit normal of the fabric at each node, shape (N,)."""
    pressing: wp.array[Any]
    """N of each crossing [dyn], shape (N,)."""

    @staticmethod
    def of(elements: CrossingElements, scalar: ScalarType, device: wp.Device) -> NormalForces:
        """The normal forces of elements, not yet computed."""
        axis = contact_axes(elements.link)
        height = elements.radius * np.stack([elements.side, -elements.side], axis=-1) * (axis < 0)[:, None]
        return NormalForces(
            height=wp.array(height, dtype=vector(2, scalar), device=device),
            axis=wp.array(axis.astype(np.int32), dtype=wp.int32, device=device),
            normal=wp.zeros(elements.count, dtype=vector(3, scalar), device=device),
            pressing=wp.zeros(elements.count, dtype=scalar, device=device),
        )

    def launches(self, model: CrossingModel, turn: wp.array[Any], state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that find ``pressing`` at a state; ``turn`` holds the rest angles of bending, shape (N, 2)."""
        constants = [model.link, model.segment, model.bend, self.height, self.axis]
        inputs = [*constants, turn, state.nodes, state.sliding, self.normal]
        return [
            launcher(find_fabric_normals, model.count, [model.link, state.nodes], [self.normal]),
            launcher(find_normal_forces, model.count, inputs, [self.pressing]),
        ]


def contact_axes(link: Integers) -> NDArray[np.int64]:
    """The leg of the u yarn whose neighbour is a neighbour along the v yarn too, or -1; shape (N,)."""
    node = np.where(link >= 0, link // 2, -1)
    axis = np.full(len(link), -1)
    for u in (1, 0):
        shared = (node[:, u] >= 0) & ((node[:, u] == node[:, 2]) | (node[:, u] == node[:, 3]))
        axis[shared] = u
    return axis
