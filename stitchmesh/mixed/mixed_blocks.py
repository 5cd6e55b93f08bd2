# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Symmetric blocks on the diagonal of a matrix of the mixed system, one for each vertex and node."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.precision import matrix, vector


@dataclass(frozen=True, eq=False)
class MixedBlocks:
    """Diagonal blocks on a device; the layout follows ``MixedVector``."""

    vertices: wp.array[Any]
    """Blocks of the triangle vertices, 3 x 3; shape (V,)."""
    nodes: wp.array[Any]
    """Blocks of the world positions of the yarn nodes, 3 x 3; shape (N,)."""
    sliding: wp.array[Any]
    """Blocks of the Eulerian coordinates, 2 x 2; shape (N,)."""
    coupling_u: wp.array[Any]
    """Columns between the position of each yarn node and its first Eulerian coordinate, three-vectors; shape (N,)."""
    coupling_v: wp.array[Any]
    """Columns between the position of each yarn node and its second Eulerian coordinate, three-vectors; shape (N,)."""

    @staticmethod
    def zeros(vertex_count: int, node_count: int, scalar: Any, device: wp.Device) -> MixedBlocks:
        """Blocks of zeros."""
        three, two = matrix(3, scalar), matrix(2, scalar)
        return MixedBlocks(
            wp.zeros(vertex_count, dtype=three, device=device),
            wp.zeros(node_count, dtype=three, device=device),
            wp.zeros(node_count, dtype=two, device=device),
            *(wp.zeros(node_count, dtype=vector(3, scalar), device=device) for _ in range(2)),
        )

    @staticmethod
    def of_numbers(
        vertices: NDArray[np.float64], nodes: NDArray[np.float64], scalar: Any, device: wp.Device
    ) -> MixedBlocks:
        """Multiples of the identity for positions, shapes (V,) and (N,); zeros for Eulerian coordinates."""
        blocks = MixedBlocks.zeros(len(vertices), len(nodes), scalar, device)
        for array, numbers in ((blocks.vertices, vertices), (blocks.nodes, nodes)):
            array.assign(numbers[:, None, None] * np.eye(3))
        return blocks

    @cached_property
    def arrays(self) -> Any:
        """All blocks in a struct for kernels."""
        struct = _struct(self.sliding.dtype._wp_scalar_type_)()
        for name in ("vertices", "nodes", "sliding", "coupling_u", "coupling_v"):
            setattr(struct, name, getattr(self, name))
        return struct

    def clear(self) -> None:
        """Set all blocks to zero."""
        for part in (self.vertices, self.nodes, self.sliding, self.coupling_u, self.coupling_v):
            part.zero_()


@functools.cache
def _struct(scalar: Any) -> Any:
    """The struct of blocks in one precision."""
    kinds = matrix(3, scalar), matrix(2, scalar), vector(3, scalar)
    blocks, pairs, columns = (wp.array(dtype=kind) for kind in kinds)
    annotations = {"vertices": blocks, "nodes": blocks, "sliding": pairs, "coupling_u": columns, "coupling_v": columns}
    return wp.struct(type(f"MixedBlocks_{scalar.__name__}", (), {"__annotations__": annotations}))
