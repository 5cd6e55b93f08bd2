# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The state of a run after its region has changed.

Nodes that were simulated keep their positions and their Eulerian coordinates. New nodes start on the triangles, with
the Eulerian coordinates of the layout. Vertices that belonged only to full-yarn triangles did not move in the run; the
nodes around them now place them. Their positions are the least squares of |p - B v|^2 over the nodes of their
triangles, where the other vertices stay. For vertices with few nodes, the sum contains a small part of a spring between
neighbours that keeps their differences. Hybrid nodes then lose the part that the triangles can represent,
x = F (p - B v), so that p = B v + F x holds. Velocities move in the same manner, with Eulerian velocities of zero for
new nodes.

Control points of B-splines stand out of their triangles. New control points begin at their heights above the triangles,
and vertices and hybrid nodes change to the nearest positions with p = B v + F x, as at the start of a run
(``enrichment.projection``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import spsolve

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.enrichment.region import YARNS, Region, embed

Numbers = NDArray[np.float64]
SPRING = 1e-6
"""Stiffness of the springs between neighbouring vertices, over the stiffness of one node."""


@dataclass(frozen=True, eq=False)
class MovedState:
    """Positions or velocities of a region; arrays are read-only."""

    vertices: Numbers
    """Vertices, shape (V, 3)."""
    nodes: Numbers
    """Simulated nodes, shape (n, 3)."""
    sliding: Numbers
    """Eulerian coordinates of the simulated nodes, shape (n, 2)."""

    def __post_init__(self) -> None:
        for array in (self.vertices, self.nodes, self.sliding):
            array.flags.writeable = False


def move_state(
    old: Region,
    new: Region,
    vertices: Numbers,
    nodes: Numbers,
    sliding: Numbers,
    rest_sliding: Numbers,
    above: Callable[[Numbers], Numbers] | None = None,
) -> MovedState:
    """Positions for a new region; also velocities, if ``rest_sliding`` is zero.

    Args:
        old: the region of the given state.
        new: the region of the result, on the same cloth and layout.
        vertices: vertices, shape (V, 3).
        nodes: simulated nodes of the old region, shape (n, 3).
        sliding: their Eulerian coordinates, shape (n, 2).
        rest_sliding: Eulerian coordinates of all nodes of the layout, shape (N, 2).
        above: positions of all layout nodes above given vertices, for nodes that stand out of the triangles. The result
            then does not have the form p = B v + F x yet.

    Raises:
        ParameterError: the regions belong to different layouts, or an array has the wrong shape.
    """
    _check(old, new, vertices, nodes, sliding, rest_sliding)
    placed = place_hidden_vertices(old, vertices, nodes)
    moved = moved_values(old, new, sliding, rest_sliding)
    if above is not None:
        return MovedState(placed, moved_values(old, new, nodes, above(placed)), moved)
    corners = placed[new.triangles[new.node_triangle]]
    on_triangles = np.einsum("nk,nkd->nd", new.node_weight, corners)
    return MovedState(placed, _filtered(new, placed, moved_values(old, new, nodes, on_triangles)), moved)


def moved_values(old: Region, new: Region, values: NDArray[np.float64], at_rest: NDArray[np.float64]) -> Numbers:
    """Values of the simulated nodes of a new region: the values of the old region, and values at rest for new nodes.

    Args:
        old: the region of the given values.
        new: the region of the result.
        values: one row for each simulated node of the old region, shape (n, ...).
        at_rest: one row for each node of the layout, shape (N, ...).
    """
    everywhere = np.array(at_rest, dtype=np.float64)
    everywhere[old.nodes] = values
    return everywhere[new.nodes]


def place_hidden_vertices(region: Region, vertices: Numbers, nodes: Numbers) -> Numbers:
    """Positions of all vertices [cm], (V, 3); the yarns place the vertices without triangles of their own.

    Args:
        region: the region of the state.
        vertices: vertices, shape (V, 3).
        nodes: simulated nodes, shape (n, 3).
    """
    placed = np.array(vertices, dtype=np.float64)
    hidden = np.flatnonzero(~region.unknown_vertices)
    if len(hidden) == 0:
        return placed
    simulated = region.nodes
    of_yarns = region.triangle_kind[region.node_triangle[simulated]] == YARNS
    corners = region.triangles[region.node_triangle[simulated[of_yarns]]]
    weight = region.node_weight[simulated[of_yarns]]
    start = np.arange(0, corners.size + 1, 3)
    basis = csr_array((weight.ravel(), corners.ravel(), start), shape=(len(corners), len(placed)))
    springs = SPRING * _springs(region)
    matrix = csr_array(basis.T @ basis + springs)
    right = basis.T @ nodes[of_yarns] + springs @ placed
    known = np.ones(len(placed), dtype=bool)
    known[hidden] = False
    others = np.flatnonzero(known)
    right = right[hidden] - matrix[hidden][:, others] @ placed[others]
    placed[hidden] = np.asarray(spsolve(matrix[hidden][:, hidden].tocsc(), right)).reshape(-1, 3)
    return placed


def _springs(region: Region) -> csr_array:
    """The matrix of springs of unit stiffness along the sides of all triangles, shape (V, V)."""
    sides = region.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    count = len(region.vertex_alpha)
    ones = np.ones(len(sides))
    links = csr_array((ones, (sides[:, 0], sides[:, 1])), shape=(count, count))
    links = csr_array(links + links.T)
    # a little more on the diagonal keeps a cloth of full-yarn triangles without nodes definite
    return csr_array(diags_array(np.asarray(links.sum(axis=1)).ravel() * (1.0 + SPRING)) - links)


def _filtered(region: Region, vertices: Numbers, nodes: Numbers) -> Numbers:
    """Positions of the simulated nodes with p = B v + F x in the hybrid region."""
    embedding = embed(region)
    result = np.array(nodes)
    if len(embedding.columns):
        base = embedding.basis @ vertices
        detail = result[embedding.nodes] - base
        independent = embedding.independent
        part = np.asarray(spsolve(csr_array(independent.T @ independent).tocsc(), independent.T @ detail))
        result[embedding.nodes] = base + detail - independent @ part.reshape(-1, 3)
    return result


def _check(old: Region, new: Region, *arrays: Numbers) -> None:
    """Refuse regions of different layouts and arrays of wrong shapes."""
    same = np.array_equal(old.triangles, new.triangles) and np.array_equal(old.node_triangle, new.node_triangle)
    if not same:
        raise ParameterError("region: got regions of different cloths or layouts; expected the same")
    count, layout, vertices = len(old.nodes), len(old.node_triangle), len(old.vertex_alpha)
    expected = [(vertices, 3), (count, 3), (count, 2), (layout, 2)]
    found = [np.shape(array) for array in arrays]
    if found != expected:
        raise ParameterError(f"region: got arrays of shapes {found}; expected {expected}")
