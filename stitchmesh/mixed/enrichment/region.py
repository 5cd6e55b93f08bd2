# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The region of interest: which triangles have yarns, the blending field alpha, the embedding, and the unknowns.

A triangle is of one of three kinds (Casafranca et al. 2020, section 4.1). In YARNS (alpha = 1) only the yarns are
simulated, in TRIANGLES (alpha = 0) only the triangle mesh. In HYBRID both are simulated: a yarn node moves with its
triangle, and also has a filtered displacement of its own. The hybrid triangles are the rings around the full-yarn
triangles. Alpha of a vertex falls linearly with the number of rings between the vertex and the yarns, and alpha within
a triangle is interpolated linearly between its vertices.

Small weights would make masses and stiffnesses that differ by many orders of magnitude. A yarn element of the hybrid
region therefore has at least the weight ``SMALLEST_ALPHA``, which is the lower bound of alpha at its nodes.

*Embedding.* Yarn nodes in hybrid triangles have the base motion p = B v + F x (Casafranca et al. 2020, equations 1 to
3).

Each row of B holds the three barycentric coordinates of a node. F = I - B (B'B)^-1 B' removes from a displacement the
part that the triangles can represent. Where triangles hold few nodes, columns of B depend on others and B'B is
singular. With a maximal set C of independent columns,

    F = I - B_C (B_C' B_C)^-1 B_C',        B' F = 0,        F F = F,

because the columns of C span the same space as all columns. Since B'F = 0, the displacement F x does not need to be
stored: positions v and p have the form p = B v + F x if and only if

    E (v, p) = B_C' p - G_C v = 0,         G_C = B_C' B,

and ``constraint`` and the solver keep this equation.

The motion of a vertex that is held is known, so its column of B is not needed to make the form unique. If nodes around
it are held as well, its row of E would only hold the mean of the other nodes there, and a cloth that is sheared at its
border would be up to twice as stiff. C leaves these columns out (``embed``).

``FreeUnknowns`` says which coordinates of the mixed system are unknown, and which have prescribed velocities.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg.lapack import dpstrf
from scipy.sparse import csr_array

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.term import FULL, element_weight

TRIANGLES, HYBRID, YARNS = 0, 1, 2
"""Kinds of triangles, and of the yarn nodes in them."""
SMALLEST_ALPHA = 0.01
"""Smallest weight of a yarn element (Casafranca et al. 2020, section 5.1)."""

ON_EDGE = 1e-9
"""A node whose weight on a vertex is at most this lies on the opposite edge."""

Integers = NDArray[np.int64]
Numbers = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Region:
    """Kinds, weights and unknowns of a cloth with yarns in a region; arrays are read-only."""

    triangles: Integers
    """Vertices of each triangle, shape (T, 3)."""
    node_triangle: Integers
    """Triangle of each yarn node of the layout, shape (N,)."""
    node_weight: Numbers
    """Barycentric coordinates of each yarn node of the layout in its triangle, shape (N, 3)."""
    triangle_kind: Integers
    """``TRIANGLES``, ``HYBRID`` or ``YARNS``, shape (T,)."""
    vertex_alpha: Numbers
    """The blending field at the vertices, shape (V,)."""
    smallest_alpha: float = SMALLEST_ALPHA
    """Smallest weight of a yarn element."""

    def __post_init__(self) -> None:
        for array in (self.triangles, self.node_triangle, self.node_weight, self.triangle_kind, self.vertex_alpha):
            array.flags.writeable = False

    @property
    def triangle_alpha(self) -> Numbers:
        """Alpha at the centroid of each triangle, shape (T,); the weight of its energies is 1 - alpha."""
        alpha = self.vertex_alpha[self.triangles].mean(axis=1)
        return np.where(self.triangle_kind == YARNS, 1.0, alpha)

    @property
    def node_kind(self) -> Integers:
        """Kind of the triangle of each yarn node, shape (N,)."""
        return self.triangle_kind[self.node_triangle]

    @property
    def node_alpha(self) -> Numbers:
        """Alpha at each yarn node, at least ``smallest_alpha`` in hybrid triangles, shape (N,)."""
        alpha: Numbers = np.sum(self.vertex_alpha[self.triangles[self.node_triangle]] * self.node_weight, axis=1)
        kind = self.node_kind
        clamped = np.clip(alpha, self.smallest_alpha, 1.0)
        return np.where(kind == YARNS, 1.0, np.where(kind == HYBRID, clamped, 0.0))

    @property
    def nodes(self) -> Integers:
        """Layout numbers of the simulated yarn nodes, ascending, shape (n,)."""
        return np.flatnonzero(self.node_kind != TRIANGLES)

    @property
    def node_number(self) -> Integers:
        """Number of each node of the layout among the simulated nodes, -1 where it is not simulated, shape (N,)."""
        number = np.full(len(self.node_triangle), -1)
        number[self.nodes] = np.arange(len(self.nodes))
        return number

    @property
    def unknown_vertices(self) -> NDArray[np.bool_]:
        """Whether the position of each vertex is unknown: not where all its triangles are ``YARNS``; shape (V,)."""
        unknown = np.zeros(len(self.vertex_alpha), dtype=bool)
        unknown[self.triangles[self.triangle_kind != YARNS]] = True
        return unknown

    @property
    def sliding_nodes(self) -> NDArray[np.bool_]:
        """Whether each simulated node has Eulerian coordinates, which need alpha = 1; shape (n,)."""
        return self.node_alpha[self.nodes] >= FULL

    def element_alpha(self, nodes: ArrayLike) -> Numbers:
        """Weight of each yarn element, from alpha at its nodes (``term``), shape (E,).

        The result is 0 for an element with a node that is not simulated, because it does not exist in the mixed system.

        Args:
            nodes: layout numbers of the nodes of each element, shape (E, K); -1 for no node.
        """
        index = np.asarray(nodes, dtype=np.int64)
        given = index >= 0
        of_nodes = self.node_alpha[index]
        alpha = element_weight(of_nodes, given, of_nodes >= FULL)
        complete = (~given | (self.node_kind[index] != TRIANGLES)).all(axis=1)
        return np.where(complete, alpha, 0.0)


def region_around(
    triangles: ArrayLike,
    vertex_count: int,
    node_triangle: ArrayLike,
    node_weight: ArrayLike,
    yarn_triangles: ArrayLike,
    *,
    rings: int = 1,
    smallest_alpha: float = SMALLEST_ALPHA,
) -> Region:
    """The region of full-yarn triangles and the hybrid rings around them.

    Alpha is 1 in the given triangles, and in triangles whose three vertices all belong to given triangles.

    Args:
        triangles: vertices of each triangle, shape (T, 3).
        vertex_count: number V of vertices.
        node_triangle: triangle of each yarn node of the layout, shape (N,).
        node_weight: barycentric coordinates of the nodes, shape (N, 3).
        yarn_triangles: numbers of the triangles with yarns alone; empty for no region, all triangles for yarns
            everywhere.
        rings: width of the hybrid region in rings of triangles, at least 1.
        smallest_alpha: smallest weight of a yarn element, in (0, 1].

    Raises:
        ParameterError: a number of a triangle or of a vertex does not exist, or a width or a weight is out of range.
    """
    corners, home, weight = _layout(triangles, vertex_count, node_triangle, node_weight)
    chosen = numbers_below("yarn triangles", yarn_triangles, len(corners))
    if rings < 1:
        raise ParameterError(f"region: got {rings} hybrid rings; expected at least 1")
    if not 0.0 < smallest_alpha <= 1.0:
        raise ParameterError(f"region: got the smallest weight {smallest_alpha}; expected a number in (0, 1]")
    distance = _ring_of_vertices(corners, vertex_count, chosen, rings)
    kind = np.where((distance[corners] < rings).any(axis=1), HYBRID, TRIANGLES)
    kind[(distance[corners] == 0).all(axis=1)] = YARNS
    return Region(corners, home, weight, kind, np.maximum(0.0, 1.0 - distance / rings), smallest_alpha)


def _layout(
    triangles: ArrayLike, vertex_count: int, node_triangle: ArrayLike, node_weight: ArrayLike
) -> tuple[Integers, Integers, Numbers]:
    """Copies of the checked arrays of a layout."""
    corners = numbers_below("triangles", triangles, vertex_count).reshape(-1, 3)
    home = numbers_below("triangle of the nodes", node_triangle, len(corners))
    weight = np.array(node_weight, dtype=np.float64).reshape(-1, 3)
    if len(weight) != len(home):
        raise ParameterError(f"region: got {len(weight)} barycentric coordinates; expected {len(home)}, one a node")
    return corners, home, weight


def numbers_below(name: str, values: ArrayLike, count: int) -> Integers:
    """A copy of numbers from 0 to ``count`` - 1.

    Raises:
        ParameterError: a number is out of range.
    """
    numbers = np.array(values, dtype=np.int64)
    wrong = (numbers < 0) | (numbers >= count)
    if wrong.any():
        raise ParameterError(f"region: {name}: got the number {int(numbers[wrong][0])}; expected 0 to {count - 1}")
    return numbers


def _ring_of_vertices(triangles: Integers, vertex_count: int, chosen: Integers, rings: int) -> Integers:
    """Number of rings of triangles between each vertex and the chosen triangles, at most ``rings``, shape (V,)."""
    distance = np.full(vertex_count, rings)
    distance[triangles[chosen]] = 0
    for ring in range(1, rings):
        reached = distance[triangles].min(axis=1) == ring - 1
        around = np.unique(triangles[reached])
        distance[around] = np.minimum(distance[around], ring)
    return distance


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
    """Vertices whose columns are independent and span the columns of all chosen vertices, ascending, shape (K,)."""

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


def embed(region: Region, fixed_vertices: ArrayLike = (), fixed_nodes: ArrayLike = ()) -> Embedding:
    """The embedding of the hybrid nodes of a region.

    Args:
        region: the region of interest.
        fixed_vertices: numbers of vertices.
        fixed_nodes: layout numbers of nodes. A fixed vertex with fixed nodes in its hybrid triangles has no row of E.
    """
    simulated = region.nodes
    hybrid = np.flatnonzero(region.node_kind[simulated] == HYBRID)
    corners = region.triangles[region.node_triangle[simulated[hybrid]]]
    weight = region.node_weight[simulated[hybrid]]
    basis = basis_of(corners, weight, len(region.vertex_alpha))
    chosen = np.ones(len(region.vertex_alpha), dtype=bool)
    chosen[np.asarray(fixed_vertices, dtype=np.int64)] = False
    held = np.isin(simulated[hybrid], fixed_nodes)
    chosen |= basis[held].sum(axis=0) <= ON_EDGE
    columns = np.flatnonzero(chosen)
    columns = columns[independent_columns(csr_array(basis[:, columns]))]
    return Embedding(len(region.vertex_alpha), len(simulated), hybrid, basis, columns)


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
