# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Springs that pull vertices and nodes to the places of attachments.

    E = 1/2 sum over attached vertices and nodes of  k |x - a(t)|^2        [erg]

with the place a(t) at the end of the step.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import vector
from stitchmesh.mesh import FloatArray
from stitchmesh.mixed.contact.attachments import Attachment
from stitchmesh.mixed.contact.prescribed_motion import PrescribedMotion
from stitchmesh.mixed.mixed_blocks import MixedBlocks
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import Term


@kernel
def spring_energies(
    # model
    number: wp.array[wp.int32],
    stiffness: wp.array[Any],
    # state in
    aim: wp.array[Any],
    position: wp.array[Any],
    # state out
    energy: wp.array[Any],
) -> None:
    """Energy of each spring [erg]."""
    k = wp.tid()
    apart = position[number[k]] - aim[k]
    energy[k] = type(stiffness[k])(0.5) * stiffness[k] * wp.dot(apart, apart)


@kernel
def spring_forces(
    # model
    number: wp.array[wp.int32],
    stiffness: wp.array[Any],
    # state in
    aim: wp.array[Any],
    position: wp.array[Any],
    # state out
    force: wp.array[Any],
) -> None:
    """Add the force of each spring [dyn]; no two springs pull the same vertex."""
    k = wp.tid()
    force[number[k]] += (aim[k] - position[number[k]]) * stiffness[k]


@kernel
def spring_products(
    # model
    number: wp.array[wp.int32],
    stiffness: wp.array[Any],
    # state in
    change: wp.array[Any],
    # state out
    product: wp.array[Any],
) -> None:
    """Add the stiffness of each spring times a displacement."""
    k = wp.tid()
    product[number[k]] += change[number[k]] * stiffness[k]


@kernel
def spring_blocks(
    # model
    number: wp.array[wp.int32],
    stiffness: wp.array[Any],
    # state out
    block: wp.array[Any],
) -> None:
    """Add the diagonal block of each spring."""
    k = wp.tid()
    block[number[k]] += wp.identity(n=3, dtype=type(stiffness[k])) * stiffness[k]


class _Springs:
    """Springs at vertices, or at nodes, on a device."""

    def __init__(self, chosen: Sequence[Attachment], kind: str, scalar: Any, device: wp.Device) -> None:
        self.attachments, self.kind = chosen, kind
        self.numbers = np.concatenate([np.zeros(0, dtype=np.int64), *(getattr(each, kind) for each in chosen)])
        stiffness = np.repeat([each.stiffness or 0.0 for each in chosen], [len(getattr(each, kind)) for each in chosen])
        self.number = wp.array(self.numbers.astype(np.int32), dtype=wp.int32, device=device)
        self.stiffness = wp.array(stiffness, dtype=scalar, device=device)
        self.aim = wp.zeros(len(self.numbers), dtype=vector(3, scalar), device=device)

    def __len__(self) -> int:
        return len(self.numbers)

    def move_to(self, time: float, start: FloatArray) -> None:
        """Put the ends of the springs where they are at a time [s]."""
        places = [each.motion.places_at(start[getattr(each, self.kind)], time) for each in self.attachments]
        self.aim.assign(np.concatenate([np.zeros((0, 3)), *places]))


class AttachmentSprings(Term):
    """Springs of all attachments that have a stiffness, on a device."""

    name = "attachments"

    def __init__(
        self,
        attachments: Sequence[Attachment],
        vertices: FloatArray,
        nodes: FloatArray,
        *,
        scalar: Any,
        device: wp.Device,
    ) -> None:
        """Put springs on a device; attachments without a stiffness are left out.

        Args:
            attachments: the attachments, whose nodes are numbered as ``nodes``.
            vertices: positions of all vertices at the start [cm], shape (V, 3).
            nodes: positions of all nodes at the start [cm], shape (N, 3).
            scalar: Warp's floating-point type.
            device: where the term runs.

        Raises:
            ParameterError: a number does not exist, or is in two attachments.
        """
        soft = [attachment for attachment in attachments if attachment.stiffness is not None]
        PrescribedMotion([_held(attachment) for attachment in soft], vertices, nodes)  # refuses what it cannot hold
        self._start = {"vertices": np.asarray(vertices, float), "nodes": np.asarray(nodes, float)}
        self._springs = [_Springs(soft, kind, scalar, device) for kind in ("vertices", "nodes")]
        self._energy = wp.zeros(sum(len(springs) for springs in self._springs), dtype=scalar, device=device)
        self._device = device
        self._move_to(0.0)

    def begin_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Move the ends of the springs to the end of the step."""
        self._move_to(time + time_step)

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of each spring, and where it is."""
        launches, first = [], 0
        for springs, position in self._with(state):
            inputs = [springs.number, springs.stiffness, springs.aim, position]
            own = self._energy[first : first + len(springs)]
            launches.append(launcher(spring_energies, len(springs), inputs, [own]))
            first += len(springs)
        return launches, self._energy

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add the pull of the springs."""
        pairs = zip(self._with(state), self._with(force), strict=True)
        return [
            launcher(spring_forces, len(springs), [springs.number, springs.stiffness, springs.aim, position], [target])
            for (springs, position), (_same, target) in pairs
        ]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """None: the Hessian is constant."""
        return []

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add H d."""
        pairs = zip(self._with(direction), self._with(product), strict=True)
        return [
            launcher(spring_products, len(springs), [springs.number, springs.stiffness, change], [target])
            for (springs, change), (_same, target) in pairs
        ]

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that add the diagonal blocks."""
        return [
            launcher(spring_blocks, len(springs), [springs.number, springs.stiffness], [getattr(blocks, springs.kind)])
            for springs in self._springs
            if len(springs)
        ]

    def _with(self, state: MixedVector) -> list[tuple[_Springs, wp.array[Any]]]:
        """Springs with the part of a vector that they act on; without those of which there are none."""
        return [(springs, getattr(state, springs.kind)) for springs in self._springs if len(springs)]

    def _move_to(self, time: float) -> None:
        for springs in self._springs:
            springs.move_to(time, self._start[springs.kind])


def _held(attachment: Attachment) -> Attachment:
    return Attachment(attachment.vertices, attachment.nodes, attachment.motion, None, attachment.name)
