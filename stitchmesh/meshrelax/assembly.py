# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Assembles element forces into vertex forces and a sparse Jacobian, whose sparsity pattern is found once.

Every element depends on the vertices through fixed weights w_i. Its force is g(y) with y = sum_i w_i x_i, and vertex i
receives w_i g. With the sparse matrix W of the weights and the block diagonal matrix B of the element Jacobians,

    f = W^T g,    df/dx = W^T B W

The blocks of df/dx are fixed linear combinations of the blocks of B, which a second sparse matrix computes. Sums are
evaluated in the order of the stored entries, so that results are reproducible to the last bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import bsr_array, coo_array, csr_array

from stitchmesh.mesh import FloatArray, IntArray


@dataclass(frozen=True)
class Assembly:
    """The sparse matrices of the assembly, and the sparsity pattern of the Jacobian (block CSR)."""

    scatter: csr_array
    """Transposed weights W^T, shape (V, elements)."""
    blocks: csr_array
    """Matrix from the blocks of the elements to the blocks of the Jacobian, shape (blocks, elements)."""
    indptr: IntArray
    """Number of the first block in the row of each vertex, and at the end the number of all blocks, shape (V + 1,)."""
    indices: IntArray
    """Column (vertex) of each block, shape (blocks,)."""
    diagonal: IntArray
    """Number of the diagonal block of each vertex, shape (V,)."""

    def force(self, element_force: FloatArray) -> FloatArray:
        """Return the force on each vertex, shape (V, 3), from the forces of the elements, shape (elements, 3)."""
        return self.scatter @ element_force

    def system(self, element_jacobian: FloatArray, vertex_blocks: FloatArray) -> bsr_array:
        """Return the matrix D - df/dx in blocks of 3 x 3, shape (3V, 3V).

        Args:
            element_jacobian: Jacobians of the elements [1/cm], shape (elements, 3, 3).
            vertex_blocks: diagonal block D of each vertex [1/cm], shape (V, 3, 3).
        """
        data = -(self.blocks @ element_jacobian.reshape(-1, 9))
        data[self.diagonal] += vertex_blocks.reshape(-1, 9)
        size = 3 * (len(self.indptr) - 1)
        return bsr_array((data.reshape(-1, 3, 3), self.indices, self.indptr), shape=(size, size))


def assembly(vertex_count: int, groups: Sequence[tuple[IntArray, FloatArray | list[float]]]) -> Assembly:
    """Find the weights and the sparsity pattern of a sum of forces.

    Args:
        vertex_count: number of vertices V.
        groups: for each kind of force, the vertices of its elements, shape (n, m), and the weights of these vertices:
            m numbers, or an array of shape (n, m).
    """
    offsets = np.cumsum([0] + [len(vertices) for vertices, _ in groups])
    vertex, element, weight, keys, owner, product = [], [], [], [], [], []
    for (vertices, weights), offset in zip(groups, offsets[:-1], strict=True):
        number = np.arange(offset, offset + len(vertices))
        of_element = np.broadcast_to(np.asarray(weights), vertices.shape).T
        for a, first in enumerate(of_element):
            vertex.append(vertices[:, a])
            element.append(number)
            weight.append(first)
            for b, second in enumerate(of_element):
                keys.append(vertices[:, a] * vertex_count + vertices[:, b])
                owner.append(number)
                product.append(first * second)
    entries = (np.concatenate(weight), (np.concatenate(vertex), np.concatenate(element)))
    scatter = coo_array(entries, shape=(vertex_count, offsets[-1])).tocsr()
    diagonal_keys = np.arange(vertex_count) * (vertex_count + 1)
    unique, place = np.unique(np.concatenate([*keys, diagonal_keys]), return_inverse=True)
    place = place[: len(place) - vertex_count]
    combine = coo_array((np.concatenate(product), (place, np.concatenate(owner))), shape=(len(unique), offsets[-1]))
    indptr = np.searchsorted(unique, np.arange(vertex_count + 1) * vertex_count)
    diagonal = np.searchsorted(unique, diagonal_keys)
    return Assembly(scatter, combine.tocsr(), indptr, unique % vertex_count, diagonal)
