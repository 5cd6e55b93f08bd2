# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One vector of the mixed system: positions, velocities, forces or directions of all its coordinates.

The coordinates are the positions v of the triangle vertices, the world positions p of the simulated yarn nodes, and the
Eulerian coordinates (u, v) of these nodes. Eulerian coordinates are the places of the two yarns that cross in a node,
along their rest lengths (Casafranca et al. 2020, section 3; Cirio et al. 2014). All scalars are one flat array, so that
sums and updates of whole vectors are one launch; the parts are views of it.

``MixedBlocks`` holds symmetric blocks on the diagonal of a matrix of the mixed system, one for each vertex and node.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from stitchmesh.compute.kernel_variants import named_type
from stitchmesh.compute.precision import ScalarType, matrix, vector
from stitchmesh.errors import ParameterError

Parts = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
"""Vertices (V, 3), nodes (N, 3) and Eulerian coordinates (N, 2)."""


MixedArrays: TypeAlias = Any
"""The struct of the parts of a ``MixedVector``, in either precision."""
BlockArrays: TypeAlias = Any
"""The struct of ``MixedBlocks``, in either precision."""

@dataclass(frozen=True, eq=False)
class MixedVector:
    """A vector of the mixed system on a device."""

    values: wp.array[Any]
    """All scalars: vertices, nodes, Eulerian coordinates; shape (3 V + 3 N + 2 N,)."""
    vertices: wp.array[Any]
    """Part of the triangle vertices, three-vectors; shape (V,). Positions are in cm."""
    nodes: wp.array[Any]
    """Part of the yarn nodes, three-vectors; shape (N,). Positions are in cm, in the world."""
    sliding: wp.array[Any]
    """Part of the Eulerian coordinates (u, v), two-vectors; shape (N,). Positions are in cm along the rest lengths.

    A yarn model without Eulerian coordinates leaves them zero and without force."""

    @staticmethod
    def zeros(vertex_count: int, node_count: int, scalar: ScalarType, device: wp.Device) -> MixedVector:
        """A vector of zeros.

        Args:
            vertex_count: number V of triangle vertices.
            node_count: number N of yarn nodes.
            scalar: Warp's floating-point type.
            device: where the vector lies.

        Raises:
            ParameterError: a count is negative.
        """
        if vertex_count < 0 or node_count < 0:
            found = f"got {vertex_count} vertices and {node_count} nodes"
            raise ParameterError(f"mixed vector: {found}; expected counts of at least 0")
        values = wp.zeros(3 * vertex_count + 5 * node_count, dtype=scalar, device=device)
        return MixedVector._of(values, vertex_count, node_count)

    @staticmethod
    def from_numpy(
        vertices: ArrayLike, nodes: ArrayLike, sliding: ArrayLike, scalar: ScalarType, device: wp.Device
    ) -> MixedVector:
        """The vector of three parts, shapes (V, 3), (N, 3) and (N, 2).

        Raises:
            ParameterError: a part has the wrong shape.
        """
        parts = [np.asarray(part, dtype=np.float64) for part in (vertices, nodes, sliding)]
        parts = [
            part.reshape(0, width) if part.size == 0 else part for part, width in zip(parts, (3, 3, 2), strict=True)
        ]
        v, p, s = parts
        if v.ndim != 2 or v.shape[1] != 3 or p.ndim != 2 or p.shape[1] != 3 or s.shape != (len(p), 2):
            found = f"got shapes {v.shape}, {p.shape}, {s.shape}"
            raise ParameterError(f"mixed vector: {found}; expected (V, 3), (N, 3), (N, 2)")
        values = np.concatenate([part.reshape(-1) for part in parts])
        return MixedVector._of(wp.array(values, dtype=scalar, device=device), len(v), len(p))

    @staticmethod
    def _of(values: wp.array[Any], vertex_count: int, node_count: int) -> MixedVector:
        """The views of a flat array."""
        first_node, first_sliding = 3 * vertex_count, 3 * vertex_count + 3 * node_count
        return MixedVector(
            values,
            _view(values, 0, vertex_count, 3),
            _view(values, first_node, node_count, 3),
            _view(values, first_sliding, node_count, 2),
        )

    @property
    def parts(self) -> tuple[wp.array[Any], wp.array[Any]]:
        """The parts that are points in space: vertices and nodes."""
        return self.vertices, self.nodes

    @property
    def vertex_count(self) -> int:
        """Number V of triangle vertices."""
        return len(self.vertices)

    @property
    def node_count(self) -> int:
        """Number N of yarn nodes."""
        return len(self.nodes)

    @property
    def scalar(self) -> Any:
        """Warp's floating-point type."""
        return self.values.dtype

    @property
    def device(self) -> wp.Device:
        """Where the vector lies."""
        return self.values.device

    @cached_property
    def arrays(self) -> Any:
        """The three parts in a struct for kernels."""
        struct = _struct(self.scalar)()
        struct.vertices, struct.nodes, struct.sliding = self.vertices, self.nodes, self.sliding
        return struct

    def like(self) -> MixedVector:
        """A vector of zeros of the same shape, precision and device."""
        return MixedVector.zeros(self.vertex_count, self.node_count, self.scalar, self.device)

    def copy(self) -> MixedVector:
        """A new vector with the same numbers."""
        return MixedVector._of(wp.clone(self.values), self.vertex_count, self.node_count)

    def assign(self, other: MixedVector) -> None:
        """Take the numbers of a vector of the same shape.

        Raises:
            ParameterError: the other vector has another number of vertices or nodes.
        """
        own, given = (self.vertex_count, self.node_count), (other.vertex_count, other.node_count)
        if own != given:
            raise ParameterError(f"mixed vector: got {given} vertices and nodes; expected {own}")
        wp.copy(self.values, other.values)

    def numpy(self) -> Parts:
        """Vertices, nodes and Eulerian coordinates as float64 arrays, shapes (V, 3), (N, 3) and (N, 2)."""
        values = self.values.numpy().astype(np.float64)
        first, second = 3 * self.vertex_count, 3 * self.vertex_count + 3 * self.node_count
        return values[:first].reshape(-1, 3), values[first:second].reshape(-1, 3), values[second:].reshape(-1, 2)


@functools.cache
def _struct(scalar: ScalarType) -> Any:
    """The struct of the parts in one precision."""
    threes, twos = (wp.array(dtype=vector(size, scalar)) for size in (3, 2))
    annotations = {"vertices": threes, "nodes": threes, "sliding": twos}
    return wp.struct(type(f"MixedVector_{scalar.__name__}", (), {"__annotations__": annotations}))


named_type("MixedArrays", lambda form: [_struct(form.scalar)])


def _view(values: wp.array[Any], first: int, count: int, width: int) -> wp.array[Any]:
    """``count`` vectors of ``width`` scalars, from scalar ``first`` on, in the memory of a flat array."""
    kind = vector(width, values.dtype)
    if count == 0:
        return wp.empty(0, dtype=kind, device=values.device)
    size = wp.types.type_size_in_bytes(values.dtype)
    view = wp.array(ptr=values.ptr + first * size, dtype=kind, shape=count, device=values.device)
    view._ref = values  # the memory lives as long as one of its views
    return view


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
    def zeros(vertex_count: int, node_count: int, scalar: ScalarType, device: wp.Device) -> MixedBlocks:
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
        vertices: NDArray[np.float64], nodes: NDArray[np.float64], scalar: ScalarType, device: wp.Device
    ) -> MixedBlocks:
        """Multiples of the identity for positions, shapes (V,) and (N,); zeros for Eulerian coordinates."""
        blocks = MixedBlocks.zeros(len(vertices), len(nodes), scalar, device)
        for array, numbers in ((blocks.vertices, vertices), (blocks.nodes, nodes)):
            array.assign(numbers[:, None, None] * np.eye(3))
        return blocks

    @cached_property
    def arrays(self) -> Any:
        """All blocks in a struct for kernels."""
        struct = _blocks_struct(self.sliding.dtype._wp_scalar_type_)()
        for name in ("vertices", "nodes", "sliding", "coupling_u", "coupling_v"):
            setattr(struct, name, getattr(self, name))
        return struct

    def clear(self) -> None:
        """Set all blocks to zero."""
        for part in (self.vertices, self.nodes, self.sliding, self.coupling_u, self.coupling_v):
            part.zero_()


@functools.cache
def _blocks_struct(scalar: ScalarType) -> Any:
    """The struct of blocks in one precision."""
    kinds = matrix(3, scalar), matrix(2, scalar), vector(3, scalar)
    blocks, pairs, columns = (wp.array(dtype=kind) for kind in kinds)
    annotations = {"vertices": blocks, "nodes": blocks, "sliding": pairs, "coupling_u": columns, "coupling_v": columns}
    return wp.struct(type(f"MixedBlocks_{scalar.__name__}", (), {"__annotations__": annotations}))


named_type("BlockArrays", lambda form: [_blocks_struct(form.scalar)])
