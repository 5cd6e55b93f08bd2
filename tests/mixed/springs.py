# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Springs between vertices or between nodes, and a constant force: the simplest terms of a mixed system.

E = w k/2 (|d| - l)^2,     d the vector between both ends, w the weight of blending
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import matrix, vector
from stitchmesh.mixed.gather import GatherTable
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import MixedTerm


@kernel
def spring_energies(
    ends: wp.array[wp.vec2i], constant: wp.array[Any], points: wp.array[Any], energy: wp.array[Any]
) -> None:
    e = wp.tid()
    stretch = wp.length(points[ends[e][1]] - points[ends[e][0]]) - constant[e][1]
    energy[e] = constant[e][0] * stretch * stretch * type(stretch)(0.5)


@kernel
def spring_forces(
    ends: wp.array[wp.vec2i], constant: wp.array[Any], points: wp.array[Any], slots: wp.array[Any]
) -> None:
    e = wp.tid()
    d = points[ends[e][1]] - points[ends[e][0]]
    length = wp.length(d)
    pull = d * (constant[e][0])
    if constant[e][1] != type(length)(0.0):
        pull = d * (constant[e][0] * (length - constant[e][1]) / length)
    slots[2 * e] = pull
    slots[2 * e + 1] = -pull


@kernel
def spring_matrices(
    ends: wp.array[wp.vec2i], constant: wp.array[Any], exact: Any, points: wp.array[Any], blocks: wp.array[Any]
) -> None:
    e = wp.tid()
    d = points[ends[e][1]] - points[ends[e][0]]
    one = type(exact)(1.0)
    ratio = exact - exact
    if constant[e][1] != ratio:
        ratio = constant[e][1] / wp.length(d)
    across = one - ratio
    across = wp.where(across < one - one, across * exact, across)
    block = blocks[e] - blocks[e]
    for k in range(3):
        block[k, k] = across
    if constant[e][1] != one - one:
        block = block + wp.outer(d, d) * ((one - across) / wp.length_sq(d))
    blocks[e] = block * constant[e][0]


@kernel
def spring_products(
    ends: wp.array[wp.vec2i], blocks: wp.array[Any], direction: wp.array[Any], slots: wp.array[Any]
) -> None:
    e = wp.tid()
    change = blocks[e] * (direction[ends[e][1]] - direction[ends[e][0]])
    slots[2 * e] = -change
    slots[2 * e + 1] = change


@kernel
def both_ends(blocks: wp.array[Any], slots: wp.array[Any]) -> None:
    e = wp.tid()
    slots[2 * e] = blocks[e]
    slots[2 * e + 1] = blocks[e]


class Springs(MixedTerm):
    """Springs between vertices, or between nodes."""

    def __init__(
        self, part: str, ends: Any, count: int, stiffness: Any, rest_length: Any, scalar: Any, device: wp.Device
    ) -> None:
        """``part`` is vertices or nodes, ``ends`` are numbers in it, shape (E, 2)."""
        self.name, self.part, self.scalar, self.device = f"springs of {part}", part, scalar, device
        pairs = np.asarray(ends, dtype=np.int32).reshape(-1, 2)
        constant = np.stack(np.broadcast_arrays(stiffness, rest_length, np.zeros(len(pairs))), axis=1)[:, :2]
        self.count = len(pairs)
        self.ends = wp.array(pairs, dtype=wp.vec2i, device=device)
        self.constant = wp.array(constant, dtype=vector(2, scalar), device=device)
        self.table = GatherTable.of(pairs, count, device)
        self.energies = wp.zeros(len(pairs), dtype=scalar, device=device)
        self.blocks = wp.zeros(len(pairs), dtype=matrix(3, scalar), device=device)
        self.slots = wp.zeros(2 * len(pairs), dtype=vector(3, scalar), device=device)
        self.block_slots = wp.zeros(2 * len(pairs), dtype=matrix(3, scalar), device=device)

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        if self.count == 0:
            return [], self.energies
        inputs = [self.ends, self.constant, self._of(state)]
        return [launcher(spring_energies, self.count, inputs, [self.energies])], self.energies

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        inputs = [self.ends, self.constant, self._of(state)]
        return self._launches(spring_forces, inputs, self._of(force), launcher)

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        inputs = [self.ends, self.constant, self.scalar(self.exact), self._of(state)]
        return [launcher(spring_matrices, self.count, inputs, [self.blocks])] if self.count else []

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        inputs = [self.ends, self.blocks, self._of(direction)]
        return self._launches(spring_products, inputs, self._of(product), launcher)

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        target = blocks.vertices if self.part == "vertices" else blocks.nodes
        if self.count == 0:
            return []
        first = launcher(both_ends, self.count, [self.blocks], [self.block_slots])
        return [first, *self.table.launches(self.block_slots, target, launcher)]

    def _launches(self, of_kernel: Any, inputs: list[Any], target: Any, launcher: Launcher) -> list[Any]:
        if self.count == 0:
            return []
        return [
            launcher(of_kernel, self.count, inputs, [self.slots]),
            *self.table.launches(self.slots, target, launcher),
        ]

    def _of(self, given: MixedVector) -> Any:
        return given.vertices if self.part == "vertices" else given.nodes
