# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The vertices of each element, with fixed weights, through which element forces become vertex forces.

Every element depends on the vertices through fixed weights w_i. Its force is g(y) with y = sum_i w_i x_i, and vertex i
receives w_i g. With the sparse matrix W of the weights and the block diagonal matrix B of the element Jacobians,

    f = W^T g,    df/dx = W^T B W

The matrix df/dx is never assembled; its products are computed element by element (``linear_solver``). Sums are
evaluated in the order of the elements, so that results are reproducible to the last bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array

from stitchmesh.mesh import FloatArray, IntArray


@dataclass(frozen=True)
class Assembly:
    """The vertices of the elements and their weights."""

    vertices: IntArray
    """Vertices of each element, shape (elements, m); elements with fewer name vertex 0 with the weight zero."""
    weights: FloatArray
    """Weight of each of these vertices, shape (elements, m)."""
    scatter: csr_array
    """Transposed weights W^T, shape (V, elements)."""


def assembly(vertex_count: int, groups: Sequence[tuple[IntArray, FloatArray | list[float]]]) -> Assembly:
    """Join the elements of all kinds of forces.

    Args:
        vertex_count: number of vertices V.
        groups: for each kind of force, the vertices of its elements, shape (n, m), and the weights of these vertices:
            m numbers, or an array of shape (n, m).
    """
    count, most = sum(len(own) for own, _ in groups), max(own.shape[1] for own, _ in groups)
    vertices, weights = np.zeros((count, most), dtype=np.int64), np.zeros((count, most))
    first = 0
    for own, given in groups:
        some = slice(first, first + len(own)), slice(own.shape[1])
        vertices[some], weights[some] = own, given
        first += len(own)
    element, slot = np.nonzero(weights)
    place = vertices[element, slot], element
    scatter = coo_array((weights[element, slot], place), shape=(vertex_count, count)).tocsr()
    return Assembly(vertices, weights, scatter)
