# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""From element forces to vertex forces and the sparse Jacobian, with the sparsity found once.

Every force acts through fixed weights: an element takes y = sum_i w_i x_i, answers with a force g(y), and vertex i
receives w_i g. So with W the sparse matrix of weights and B the block diagonal of the elements' Jacobians

    f = W^T g,    df/dx = W^T B W

and the blocks of the second are fixed linear combinations of those of B: a second sparse matrix refreshes them.
Sums run in the order of the stored entries, so a run is repeatable to the bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import bsr_array, coo_array, csr_array

from stitchmesh.mesh import FloatArray, IntArray


@dataclass(frozen=True)
class Assembly:
    """Where element forces and Jacobians go."""

    scatter: csr_array
    """Weights transposed, shape (V, elements)."""
    blocks: csr_array
    """Blocks of the Jacobian from those of the elements, shape (blocks, elements)."""
    indptr: IntArray
    """Where each vertex's row of blocks starts, shape (V + 1,)."""
    indices: IntArray
    """Vertex of each block's column, shape (blocks,)."""
    diagonal: IntArray
    """Number of each vertex's diagonal block, shape (V,)."""

    def force(self, element_force: FloatArray) -> FloatArray:
        """Force on each vertex, shape (V, 3)."""
        return self.scatter @ element_force

    def system(self, element_jacobian: FloatArray, vertex_blocks: FloatArray) -> bsr_array:
        """The matrix B - df/dx, blocks of 3 x 3, for a block B of each vertex, shape (V, 3, 3)."""
        data = -(self.blocks @ element_jacobian.reshape(-1, 9))
        data[self.diagonal] += vertex_blocks.reshape(-1, 9)
        size = 3 * (len(self.indptr) - 1)
        return bsr_array((data.reshape(-1, 3, 3), self.indices, self.indptr), shape=(size, size))


def assembly(vertex_count: int, groups: list[tuple[IntArray, list[float]]]) -> Assembly:
    """Find the sparsity of a sum of forces.

    Args:
        vertex_count: number of vertices V.
        groups: for each kind of force the vertices of its elements, shape (n, m), and their m weights.
    """
    offsets = np.cumsum([0] + [len(vertices) for vertices, _ in groups])
    vertex, element, weight, keys, owner, product = [], [], [], [], [], []
    for (vertices, weights), offset in zip(groups, offsets[:-1], strict=True):
        number = np.arange(offset, offset + len(vertices))
        for a, first in enumerate(weights):
            vertex.append(vertices[:, a])
            element.append(number)
            weight.append(np.full(len(number), first))
            for b, second in enumerate(weights):
                keys.append(vertices[:, a] * vertex_count + vertices[:, b])
                owner.append(number)
                product.append(np.full(len(number), first * second))
    entries = (np.concatenate(weight), (np.concatenate(vertex), np.concatenate(element)))
    scatter = coo_array(entries, shape=(vertex_count, offsets[-1])).tocsr()
    diagonal_keys = np.arange(vertex_count) * (vertex_count + 1)
    unique, place = np.unique(np.concatenate([*keys, diagonal_keys]), return_inverse=True)
    place = place[: len(place) - vertex_count]
    combine = coo_array((np.concatenate(product), (place, np.concatenate(owner))), shape=(len(unique), offsets[-1]))
    indptr = np.searchsorted(unique, np.arange(vertex_count + 1) * vertex_count)
    diagonal = np.searchsorted(unique, diagonal_keys)
    return Assembly(scatter, combine.tocsr(), indptr, unique % vertex_count, diagonal)
