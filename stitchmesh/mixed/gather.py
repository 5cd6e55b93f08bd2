# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sums of the contributions of elements to vertices or nodes, in a fixed order.

Each element (a triangle, a yarn segment, a hinge) writes its contributions to slots of its own, and each vertex or node
then adds up its slots in ascending order:

    target_i <- target_i + sum over the slots k of i of values_k

No float atomics are needed, and a run gives the same bits each time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.kernel_variants import named_type
from stitchmesh.compute.precision import matrix, vector
from stitchmesh.errors import ParameterError

Slot: TypeAlias = Any
"""A contribution of an element: a vector, or a block of a matrix."""
named_type("Slot", lambda form: [vector(3, form.scalar), matrix(3, form.scalar)])


@kernel
def add_slots(
    # model
    start: wp.array[wp.int32],
    slot: wp.array[wp.int32],
    # state in
    values: wp.array[Slot],
    # state out
    target: wp.array[Slot],
) -> None:
    """Add the slots of each vertex or node."""
    i = wp.tid()
    total = target[i] - target[i]
    for k in range(start[i], start[i + 1]):
        total += values[slot[k]]
    target[i] = target[i] + total


@dataclass(frozen=True, eq=False)
class GatherTable:
    """The slots of each vertex or node, as compressed rows on a device."""

    start: wp.array[wp.int32]
    """Where the row of each vertex or node begins in ``slot``; shape (count + 1,)."""
    slot: wp.array[wp.int32]
    """Numbers of slots, ascending in each row, shape (number of slots with a target,). Slot ``K e + k`` is the k-th
    slot of element e."""
    slot_count: int
    """Number E K of slots."""

    @staticmethod
    def of(index: ArrayLike, count: int, device: wp.Device) -> GatherTable:
        """The table of elements.

        Args:
            index: vertex or node of each slot of each element, shape (E, K) or (E,); -1 for a slot without a target.
            count: number of vertices or nodes.
            device: where the table lies.

        Raises:
            ParameterError: an index is neither -1 nor the number of a vertex or node.
        """
        flat = np.asarray(index, dtype=np.int64).reshape(-1)
        wrong = np.flatnonzero((flat < -1) | (flat >= count))
        if len(wrong):
            found = f"slot {int(wrong[0])} has the target {int(flat[wrong[0]])}"
            raise ParameterError(f"gather: {found}; expected -1 to {count - 1}")
        order = np.argsort(flat, kind="stable")
        order = order[np.searchsorted(flat[order], 0) :]
        start = np.searchsorted(flat[order], np.arange(count + 1))
        return GatherTable(_integers(start, device), _integers(order, device), len(flat))

    def launches(self, values: wp.array[Any], target: wp.array[Any], launcher: Launcher) -> list[Any]:
        """The launches that add slots to vertices or nodes; none where there are no slots.

        Args:
            values: the slots, vectors or scalars; shape (E K,).
            target: the vertices or nodes to which they are added, of the same type; shape (count,).
            launcher: ``launch`` or ``prepare`` of ``stitchmesh.compute.launch`` with a device bound.

        Raises:
            ParameterError: the arrays have the wrong lengths.
        """
        expected = self.slot_count, len(self.start) - 1
        if (len(values), len(target)) != expected:
            found = f"got {len(values)} slots and {len(target)} targets"
            raise ParameterError(f"gather: {found}; expected {expected[0]} and {expected[1]}")
        if len(self.slot) == 0:
            return []
        return [launcher(add_slots, len(target), [self.start, self.slot, values], [target])]


def _integers(values: NDArray[np.int64], device: wp.Device) -> wp.array[wp.int32]:
    return wp.array(values.astype(np.int32), dtype=wp.int32, device=device)
