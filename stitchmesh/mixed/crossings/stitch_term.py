# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wrapping and length of the stitch contacts of a knit, as a term of the mixed system.

A loop of a plain knit has four stitch contacts: two at its foot, where it holds the loop below, and two at its head,
where the loop above holds it. Each is shared with the other loop, so that there are two for each loop. A stitch contact
has two nodes, at the two places where the yarns cross in the plane of the fabric: one yarn comes in at the first node and
leaves at the second one, and so does the other yarn. Both yarns have a segment between the two nodes, the axis.

An element is (p, q0, q1, r): the axis q0 q1, the neighbour p outside the contact on one yarn and r on the other one.
A contact has one element for each such pair of legs that the layout names, and its length once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import vector
from stitchmesh.compute.reduction import ordered_sum
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial
from stitchmesh.mixed.crossings.stitch_length import stitch_length_energy, stitch_length_force, stitch_length_product
from stitchmesh.mixed.crossings.wrapping import wrapping_energy, wrapping_force, wrapping_product
from stitchmesh.mixed.gather import GatherTable
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import Term


@dataclass(frozen=True, eq=False)
class StitchElements:
    """W elements of wrapping and length; an element that has only one of both has the stiffness 0 of the other one."""

    nodes: NDArray[np.int64]
    """p, q0, q1, r of each element, shape (W, 4)."""
    wrapping: NDArray[np.float64]
    """k_w L [dyn cm], shape (W,)."""
    rest_angle: NDArray[np.float64]
    """r, shape (W,)."""
    length_stiffness: NDArray[np.float64]
    """k_l [dyn], shape (W,)."""
    rest_length: NDArray[np.float64]
    """L [cm], shape (W,)."""


def stitch_elements(
    nodes: ArrayLike,
    rest_angle: ArrayLike,
    rest_position: ArrayLike,
    material: CrossingMaterial,
    *,
    weight: ArrayLike | None = None,
) -> StitchElements:
    """The elements of the stitch contacts of a knit as it is laid out.

    The length of a contact is shared among its elements, so that it counts once.

    Args:
        nodes: p, q0, q1, r of each element, shape (W, 4).
        rest_angle: angle at rest of each element, +pi/2 or -pi/2; shape (W,).
        rest_position: positions of the nodes in the layout [cm], shape (N, 2) or (N, 3).
        material: of the yarn.
        weight: alpha of each node, shape (N,); 1 if it is None.

    Raises:
        ParameterError: a node does not exist, or a contact has no length.
    """
    position = np.asarray(rest_position, dtype=np.float64)
    index = np.asarray(nodes, dtype=np.int64).reshape(-1, 4)
    wrong = np.flatnonzero(((index < 0) | (index >= len(position))).any(axis=1))
    if len(wrong):
        found = f"element {wrong[0]} has the nodes {index[wrong[0]].tolist()}"
        raise ParameterError(f"stitch elements: {found}; expected four numbers from 0 to {len(position) - 1}")
    alpha = np.ones(len(position)) if weight is None else np.asarray(weight, dtype=np.float64)
    length = np.linalg.norm(position[index[:, 2]] - position[index[:, 1]], axis=-1)
    if len(length) and not length.min() > 0.0:
        found = f"the contact of element {int(np.argmin(length))} has no length"
        raise ParameterError(f"stitch elements: {found}; expected two nodes at different places")
    _pairs, which, times = np.unique(np.sort(index[:, 1:3], axis=1), axis=0, return_inverse=True, return_counts=True)
    share = alpha[index].mean(axis=1)
    return StitchElements(
        nodes=index,
        wrapping=share * material.wrapping * length,
        rest_angle=np.broadcast_to(np.asarray(rest_angle, dtype=np.float64), len(index)).copy(),
        length_stiffness=share * material.stitch_length / times[which.reshape(-1)],
        rest_length=length,
    )


@kernel
def find_stitch_energies(
    # model
    index: wp.array2d[wp.int32],
    stitch: wp.array[Any],
    # state in
    nodes: wp.array[Any],
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
    stitch: wp.array[Any],
    # state in
    nodes: wp.array[Any],
    # state out
    slots: wp.array[Any],
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
    stitch: wp.array[Any],
    # state in
    nodes: wp.array[Any],
    share: wp.array[Any],
    direction: wp.array[Any],
    # state out
    slots: wp.array[Any],
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
def keep_nodes(
    # state in
    exact: Any,
    nodes: wp.array[Any],
    # state out
    kept: wp.array[Any],
    share: wp.array[Any],
) -> None:
    """Keep the positions at which products are taken, and the share of the exact Hessian."""
    i = wp.tid()
    kept[i] = nodes[i]
    if i == 0:
        share[0] = exact


class StitchTerm(Term):
    """Wrapping and length of stitch contacts on a device."""

    name = "stitch contacts"

    def __init__(self, elements: StitchElements, node_count: int, scalar: Any, device: wp.Device) -> None:
        """Put the elements on a device, in the precision of ``scalar``."""
        values = np.stack(
            [elements.wrapping, elements.rest_angle, elements.length_stiffness, elements.rest_length], axis=-1
        )
        self.count, self.node_count, self.device, self._scalar = len(elements.nodes), node_count, device, scalar
        self._index = wp.array(elements.nodes.astype(np.int32), dtype=wp.int32, device=device)
        self._stitch = wp.array(values, dtype=vector(4, scalar), device=device)
        self._gather = GatherTable.of(elements.nodes, node_count, device)
        self._slots = wp.zeros(4 * self.count, dtype=vector(3, scalar), device=device)
        self._nodes = wp.zeros(node_count, dtype=vector(3, scalar), device=device)
        self._share = wp.zeros(1, dtype=scalar, device=device)

    def energy(self, state: MixedVector) -> float:
        """Energy [erg]."""
        energies = wp.zeros(self.count, dtype=wp.float64, device=self.device)
        launch(find_stitch_energies, self.count, [self._index, self._stitch, state.nodes], [energies], self.device)
        return ordered_sum(energies)

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The forces of all elements, and their sums at the nodes."""
        if self.count == 0:
            return []
        own = launcher(find_stitch_forces, self.count, [self._index, self._stitch, state.nodes], [self._slots])
        return [own, *self._gather.launches(self._slots, force.nodes, launcher)]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that keeps the positions."""
        if self.count == 0:
            return []
        return [launcher(keep_nodes, self.node_count, [self._scalar(self.exact), state.nodes], [self._nodes, self._share])]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The products of all elements, and their sums at the nodes."""
        if self.count == 0:
            return []
        inputs = [self._index, self._stitch, self._nodes, self._share, direction.nodes]
        own = launcher(find_stitch_products, self.count, inputs, [self._slots])
        return [own, *self._gather.launches(self._slots, product.nodes, launcher)]
