# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Attachments: vertices and yarn nodes that are held, or moved by keyframes (``prescribed_motion``)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray, frozen_array
from stitchmesh.mixed.contact.motion import RigidMotion


def _none() -> IntArray:
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Attachment:
    """Vertices and nodes that are attached to something that does not move, or moves rigidly.

    Raises:
        ParameterError: nothing is attached, or a number occurs twice or is negative.
    """

    vertices: IntArray = field(default_factory=_none)
    """Numbers of vertices, ascending."""
    nodes: IntArray = field(default_factory=_none)
    """Numbers of yarn nodes, ascending."""
    motion: RigidMotion = field(default_factory=RigidMotion.at_rest)
    """How the attached points move, from where they are at the start."""
    name: str = "attachment"
    """Name in messages."""

    def __post_init__(self) -> None:
        for kind in ("vertices", "nodes"):
            numbers = np.sort(np.asarray(getattr(self, kind), dtype=np.int64))
            if len(numbers) and (numbers[0] < 0 or (np.diff(numbers) == 0).any()):
                raise ParameterError(
                    f"{self.name}: {kind}: got a number below 0 or one twice; expected distinct numbers"
                )
            object.__setattr__(self, kind, frozen_array(numbers, np.int64))
        if not len(self.vertices) + len(self.nodes):
            raise ParameterError(f"{self.name}: got no vertex and no node; expected some: change what is chosen")


def at_simulated_nodes(attachments: Sequence[Attachment], node_number: IntArray) -> list[Attachment]:
    """Attachments with the numbers that the simulated nodes have in a state; those that hold nothing are left out.

    Args:
        attachments: attachments whose nodes are numbered as in the layout.
        node_number: number of each node of the layout among the simulated ones, -1 for the others, shape (N,).
    """
    result = []
    for attachment in attachments:
        own = node_number[attachment.nodes]
        own = own[own >= 0]
        if len(own) + len(attachment.vertices):
            result.append(replace(attachment, nodes=own))
    return result
