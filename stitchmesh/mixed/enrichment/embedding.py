# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The base motion of yarn nodes in hybrid triangles: p = B v + F x (Casafranca et al. 2020, equations 1 to 3).

Each row of B holds the three barycentric coordinates of a node. F = I - B (B'B)^-1 B' removes from a displacement the
part that the triangles can represent. Where triangles hold few nodes, columns of B depend on others and B'B is
singular. With a maximal set C of independent columns,

    F = I - B_C (B_C' B_C)^-1 B_C',        B' F = 0,        F F = F,

because the columns of C span the same space as all columns. Since B'F = 0, the displacement F x does not need to be
stored: positions v and p have the form p = B v + F x if and only if

    E (v, p) = B_C' p - G_C v = 0,         G_C = B_C' B,

and ``constraint`` and the solver keep this equation.

``FreeUnknowns`` says which coordinates of the mixed system are unknown, and which have prescribed velocities.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg.lapack import dpstrf
from scipy.sparse import csr_array

from stitchmesh.mixed.enrichment.region import HYBRID, Integers, Numbers, Region, numbers_below

DEPENDENT = 1e-10
"""Bound below which a column of unit length depends on the other columns: the square of its part outside of them.
Rounding of the barycentric coordinates gives 1e-16; columns above the bound keep five digits of B'B."""


@dataclass(frozen=True, eq=False)
class Embedding:
    """The matrix B of the hybrid nodes, and its independent columns."""

    vertex_count: int
    """Number V of vertices."""
    node_count: int
    """Number n of simulated nodes."""
    nodes: Integers
    """The hybrid nodes among the simulated ones, ascending, shape (H,)."""
    basis: csr_array
    """B, shape (H, V)."""
    columns: Integers
    """Vertices whose columns are independent and span the columns of all vertices, ascending, shape (K,)."""

    @property
    def independent(self) -> csr_array:
        """B_C, shape (H, K)."""
        return csr_array(self.basis[:, self.columns])

    @property
    def gram(self) -> csr_array:
        """G_C = B_C' B, shape (K, V)."""
        return csr_array(self.independent.T @ self.basis)

    @property
    def coupled(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Whether E contains each vertex and each simulated node, shapes (V,) and (n,)."""
        vertices = np.zeros(self.vertex_count, dtype=bool)
        vertices[self.basis.indices[self.basis.data != 0.0]] = True
        nodes = np.zeros(self.node_count, dtype=bool)
        nodes[self.nodes] = True
        return vertices, nodes

    def constraint(self, vertices: Numbers, nodes: Numbers) -> Numbers:
        """E (v, p) = B_C' (p - B v), which is zero where p = B v + F x; shape (K, 3).

        Args:
            vertices: v, shape (V, 3).
            nodes: p of the simulated nodes, shape (n, 3).
        """
        residual: Numbers = self.independent.T @ (nodes[self.nodes] - self.basis @ vertices)
        return residual


def embed(region: Region) -> Embedding:
    """The embedding of the hybrid nodes of a region."""
    simulated = region.nodes
    hybrid = np.flatnonzero(region.node_kind[simulated] == HYBRID)
    corners = region.triangles[region.node_triangle[simulated[hybrid]]]
    weight = region.node_weight[simulated[hybrid]]
    basis = basis_of(corners, weight, len(region.vertex_alpha))
    return Embedding(len(region.vertex_alpha), len(simulated), hybrid, basis, independent_columns(basis))


def basis_of(corners: Integers, weight: Numbers, vertex_count: int) -> csr_array:
    """B of nodes in triangles: three entries in each row, shape (H, V).

    Args:
        corners: vertices of the triangle of each node, shape (H, 3).
        weight: barycentric coordinates, shape (H, 3).
        vertex_count: number V of vertices.
    """
    start = np.arange(0, corners.size + 1, 3)
    return csr_array((weight.reshape(-1), corners.reshape(-1), start), shape=(len(corners), vertex_count))


def independent_columns(basis: csr_array) -> Integers:
    """A maximal set of independent columns, ascending, by Cholesky's factorisation of B'B with pivots.

    Columns are scaled to unit length first: a vertex far from the nodes of its triangles counts like any other.
    """
    gram = csr_array(basis.T @ basis)
    square = gram.diagonal()
    used = np.flatnonzero(square > 0.0)
    if len(used) == 0:
        return used
    length = np.sqrt(square[used])
    dense: NDArray[np.float64] = gram[used][:, used].toarray() / np.outer(length, length)
    _factor, pivots, rank, _info = dpstrf(dense, tol=DEPENDENT)
    return np.sort(used[pivots[:rank] - 1])


@dataclass(frozen=True, eq=False)
class FreeUnknowns:
    """Which coordinates move; fixed coordinates have a prescribed velocity instead."""

    vertices: NDArray[np.bool_]
    """Shape (V,); vertices without triangles of their own in the system are not free."""
    nodes: NDArray[np.bool_]
    """Whether each simulated node is free, shape (n,)."""
    sliding: NDArray[np.bool_]
    """Whether each Eulerian coordinate (u, v) of the simulated nodes is free, shape (n, 2)."""

    @staticmethod
    def of(region: Region, *, fixed_vertices: ArrayLike = (), fixed_nodes: ArrayLike = ()) -> FreeUnknowns:
        """The unknowns of a region, without fixed vertices and nodes.

        Args:
            region: the region of interest.
            fixed_vertices: numbers of vertices.
            fixed_nodes: layout numbers of nodes; nodes that are not simulated are left out. Their Eulerian coordinates
                are fixed too.

        Raises:
            ParameterError: a number does not exist.
        """
        vertices = region.unknown_vertices
        vertices[numbers_below("fixed vertices", fixed_vertices, len(vertices))] = False
        nodes = np.ones(len(region.nodes), dtype=bool)
        fixed = region.node_number[numbers_below("fixed nodes", fixed_nodes, len(region.node_triangle))]
        nodes[fixed[fixed >= 0]] = False
        return FreeUnknowns(vertices, nodes, np.repeat((nodes & region.sliding_nodes)[:, None], 2, axis=1))
