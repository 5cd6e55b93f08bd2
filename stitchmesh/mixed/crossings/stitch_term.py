# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wrapping and length of the stitch contacts of a knit, as a term of the mixed system.

A loop of a plain knit has four stitch contacts: two at its feet, with the loop through which it is drawn, and two at
its head, with the loop that is drawn through it. Two loops share each contact, so there are two contacts for each loop.
A contact has two nodes, P and Q (``layout.knit``). At P the new loop, which is the u yarn, passes the leg of the old
loop, the v yarn. At Q the leg of the new loop passes the head of the old loop on the other side. Both yarns have a
segment from P to Q, the axis of the contact.

Two legs leave the contact across its axis: at P the link p from the new loop to its neighbour, and at Q the head r of
the old loop. They lie opposite to one another, and on the same side of the fabric: the side on which the u yarn lies at
P. The half planes of the axis with p and with r span the angle of wrapping (``stitch_energies``), and the two yarns
turn towards that side. The rest angle is a quarter turn; its sign is the product of side(P) and of the side of the axis
on which p lies. In stockinette the legs turn to the back, so its side borders curl to the back. The other two legs, of
the new loop at Q and of the old loop at P, continue the axis and span no half plane.

An element is (p, P, Q, r). A contact at a border, without p or r, has only the energy of its length.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Mat33, Scalar, ScalarType, Vec3, Vec4, matrix, vector
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial
from stitchmesh.mixed.crossings.crossing_term import CrossingElements
from stitchmesh.mixed.crossings.energies.stitch_energies import (
    stitch_length_energy,
    stitch_length_force,
    stitch_length_product,
    wrapping_energy,
    wrapping_force,
    wrapping_product,
)
from stitchmesh.mixed.gather import GatherTable
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import MixedTerm, element_weight


@dataclass(frozen=True, eq=False)
class StitchElements:
    """The C stitch contacts whose nodes are all simulated."""

    nodes: NDArray[np.int64]
    """p, P, Q, r of each contact, shape (C, 4); in a contact without wrapping, p is P and r is Q."""
    wrapping: NDArray[np.float64]
    """k_w L [dyn cm], shape (C,)."""
    rest_angle: NDArray[np.float64]
    """Rest angle of wrapping, +pi/2 or -pi/2; shape (C,)."""
    length_stiffness: NDArray[np.float64]
    """k_l [dyn], shape (C,)."""
    rest_length: NDArray[np.float64]
    """L [cm], shape (C,)."""


def stitch_elements(
    yarns: CrossingYarns,
    elements: CrossingElements,
    material: CrossingMaterial,
    *,
    alpha: ArrayLike | None = None,
    full: ArrayLike | None = None,
) -> StitchElements:
    """The stitch contacts of a knit as it is laid out; a weave has none.

    Args:
        yarns: the layout.
        elements: the elements of its simulated nodes.
        material: material of the yarn.
        alpha: blending field at the simulated nodes, shape (N,); 1 if it is None.
        full: nodes of the full-yarn region, whose elements have the weight 1 (``term``), shape (N,); none by default.
    """
    blend = np.ones(elements.count) if alpha is None else np.asarray(alpha, dtype=np.float64)
    number = np.full(yarns.node_count, -1)
    number[elements.nodes] = np.arange(elements.count)
    contacts = number[yarns.stitch_contacts].reshape(-1, 2)
    whole = (contacts >= 0).all(axis=1)
    contacts, left = contacts[whole], np.where(yarns.stitch_left[whole], 1.0, -1.0)
    first, second = contacts.T
    p, r = _outside(elements.link, first, second, 0), _outside(elements.link, second, first, 2)
    wraps = (p >= 0) & (r >= 0)
    index = np.stack([np.where(wraps, p, first), first, second, np.where(wraps, r, second)], axis=1)
    along = np.where(elements.link[first, 0] // 2 == second, 0, 1)
    length = _leg_length(elements, first, along)
    whole = np.zeros(elements.count, dtype=bool) if full is None else np.asarray(full, dtype=bool)
    share = element_weight(blend[index], np.ones(index.shape, dtype=bool), whole[index])
    return StitchElements(
        nodes=index,
        wrapping=share * material.wrapping * length * wraps,
        rest_angle=-0.5 * np.pi * left * elements.side[first],
        length_stiffness=share * material.stitch_length,
        rest_length=length,
    )


def _outside(link: NDArray[np.int64], node: NDArray[np.int64], other: NDArray[np.int64], leg: int) -> NDArray[np.int64]:
    """Neighbour of a node along one yarn that is not the other node of its contact; -1 without one."""
    pair = np.where(link[node, leg : leg + 2] >= 0, link[node, leg : leg + 2] // 2, -1)
    outside: NDArray[np.int64] = np.where(pair[:, 0] == other, pair[:, 1], pair[:, 0])
    return outside


def _leg_length(elements: CrossingElements, node: NDArray[np.int64], leg: NDArray[np.int64]) -> NDArray[np.float64]:
    """Rest length of the segment after (0) or before (1) nodes along their u yarn."""
    before = np.maximum(elements.link[node, 1], 0)
    lengths: NDArray[np.float64] = np.where(
        leg == 0, elements.rest_length[node, 0], elements.rest_length.reshape(-1)[before]
    )
    return lengths


@kernel
def find_stitch_energies(
    # model
    index: wp.array2d[wp.int32],
    stitch: wp.array[Vec4],
    # state in
    nodes: wp.array[Vec3],
    # state out
    energy: wp.array[wp.float64],
) -> None:
    """Energy of each element [erg]; ``stitch`` is (k_w L, r, k_l, L)."""
    e = wp.tid()
    start, values = nodes[index[e, 1]], stitch[e]
    axis, a, b = nodes[index[e, 2]] - start, nodes[index[e, 0]] - start, nodes[index[e, 3]] - start
    total = wrapping_energy(axis, a, b, values[1], values[0]) + stitch_length_energy(axis, values[3], values[2])
    energy[e] = wp.float64(total)


@kernel
def find_stitch_forces(
    # model
    index: wp.array2d[wp.int32],
    stitch: wp.array[Vec4],
    # state in
    nodes: wp.array[Vec3],
    # state out
    slots: wp.array[Vec3],
) -> None:
    """Forces of each element on its four nodes [dyn]."""
    e = wp.tid()
    start, values = nodes[index[e, 1]], stitch[e]
    axis, a, b = nodes[index[e, 2]] - start, nodes[index[e, 0]] - start, nodes[index[e, 3]] - start
    on_axis, on_a, on_b = wrapping_force(axis, a, b, values[1], values[0])
    on_axis += stitch_length_force(axis, values[3], values[2])
    slots[4 * e] = on_a
    slots[4 * e + 1] = -(on_axis + on_a + on_b)
    slots[4 * e + 2] = on_axis
    slots[4 * e + 3] = on_b


@kernel
def find_stitch_products(
    # model
    index: wp.array2d[wp.int32],
    stitch: wp.array[Vec4],
    # state in
    nodes: wp.array[Vec3],
    share: wp.array[Scalar],
    direction: wp.array[Vec3],
    # state out
    slots: wp.array[Vec3],
) -> None:
    """Products of the Hessian of each element with a direction."""
    e = wp.tid()
    start, values, exact = nodes[index[e, 1]], stitch[e], share[0]
    axis, a, b = nodes[index[e, 2]] - start, nodes[index[e, 0]] - start, nodes[index[e, 3]] - start
    moved = direction[index[e, 1]]
    d_axis, da, db = direction[index[e, 2]] - moved, direction[index[e, 0]] - moved, direction[index[e, 3]] - moved
    of_axis, of_a, of_b = wrapping_product(axis, a, b, d_axis, da, db, values[1], values[0], exact)
    of_axis += stitch_length_product(axis, d_axis, values[3], values[2], exact)
    slots[4 * e] = of_a
    slots[4 * e + 1] = -(of_axis + of_a + of_b)
    slots[4 * e + 2] = of_axis
    slots[4 * e + 3] = of_b


@kernel
def find_stitch_blocks(
    # model
    index: wp.array2d[wp.int32],
    stitch: wp.array[Vec4],
    # state in
    nodes: wp.array[Vec3],
    share: wp.array[Scalar],
    # state out
    slots: wp.array[Mat33],
) -> None:
    """Diagonal block of each of the four nodes of each element, column by column."""
    slot = wp.tid()
    e, m = slot // 4, slot % 4
    start, values, exact = nodes[index[e, 1]], stitch[e], share[0]
    axis, a, b = nodes[index[e, 2]] - start, nodes[index[e, 0]] - start, nodes[index[e, 3]] - start
    zero, one = start - start, exact - exact + type(exact)(1.0)
    block = slots[slot] - slots[slot]
    columns = int(3)
    for k in range(columns):
        unit = zero * one
        unit[k] = one
        moved = wp.where(m == 1, unit, zero)
        d_axis, da, db = wp.where(m == 2, unit, zero), wp.where(m == 0, unit, zero), wp.where(m == 3, unit, zero)
        of_axis, of_a, of_b = wrapping_product(
            axis, a, b, d_axis - moved, da - moved, db - moved, values[1], values[0], exact
        )
        of_axis += stitch_length_product(axis, d_axis - moved, values[3], values[2], exact)
        column = wp.where(m == 0, of_a, wp.where(m == 3, of_b, of_axis))
        if m == 1:
            column = -(of_axis + of_a + of_b)
        for r in range(3):
            block[r, k] = column[r]
    slots[slot] = block


@kernel
def keep_nodes(
    # state in
    exact: Scalar,
    nodes: wp.array[Vec3],
    # state out
    kept: wp.array[Vec3],
    share: wp.array[Scalar],
) -> None:
    """Keep the positions at which products are taken, and the share of the exact Hessian."""
    i = wp.tid()
    kept[i] = nodes[i]
    if i == 0:
        share[0] = exact


class StitchTerm(MixedTerm):
    """Wrapping and length of stitch contacts on a device."""

    name = "stitch contacts"
    acts_on = "nodes"

    def __init__(self, elements: StitchElements, node_count: int, scalar: ScalarType, device: wp.Device) -> None:
        """Put the elements on a device, in the precision of ``scalar``."""
        values = np.stack(
            [elements.wrapping, elements.rest_angle, elements.length_stiffness, elements.rest_length], axis=-1
        )
        self.count, self.node_count, self.device, self._scalar = len(elements.nodes), node_count, device, scalar
        self._index = wp.array(elements.nodes.astype(np.int32), dtype=wp.int32, device=device)
        self._stitch = wp.array(values, dtype=vector(4, scalar), device=device)
        self._gather = GatherTable.of(elements.nodes, node_count, device)
        self._energy = wp.zeros(self.count, dtype=wp.float64, device=device)
        self._slots = wp.zeros(4 * self.count, dtype=vector(3, scalar), device=device)
        self._blocks = wp.zeros(4 * self.count, dtype=matrix(3, scalar), device=device)
        self._nodes = wp.zeros(node_count, dtype=vector(3, scalar), device=device)
        self._share = wp.zeros(1, dtype=scalar, device=device)

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of each stitch contact, and the array of the energies."""
        inputs = [self._index, self._stitch, state.nodes]
        return [launcher(find_stitch_energies, self.count, inputs, [self._energy])], self._energy

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The forces of all elements, and their sums at the nodes."""
        own = launcher(find_stitch_forces, self.count, [self._index, self._stitch, state.nodes], [self._slots])
        return [own, *self._gather.launches(self._slots, force.nodes, launcher)]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that keeps the positions."""
        inputs = [self._scalar(self.exact), state.nodes]
        return [launcher(keep_nodes, self.node_count, inputs, [self._nodes, self._share])]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The products of all elements, and their sums at the nodes."""
        inputs = [self._index, self._stitch, self._nodes, self._share, direction.nodes]
        own = launcher(find_stitch_products, self.count, inputs, [self._slots])
        return [own, *self._gather.launches(self._slots, product.nodes, launcher)]

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The diagonal blocks of all elements, and their sums at the nodes."""
        inputs = [self._index, self._stitch, self._nodes, self._share]
        own = launcher(find_stitch_blocks, 4 * self.count, inputs, [self._blocks])
        return [own, *self._gather.launches(self._blocks, blocks.nodes, launcher)]
