# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Summits and hollows of a function on a surface, and a smooth function without the small ones.

The height of a summit above its highest saddle (its persistence) tells a limb from a bump; a bump beside an end of rows
is measured from its saddle to that end, even if the end is lower. The part of a small summit above its saddle, and some
surface around it, gets the harmonic function with the values at its rim. By the maximum principle it has no summit,
whatever the triangles, because the weights of the edges are positive.

Source: Edelsbrunner, Letscher and Zomorodian, *Topological persistence and simplification* (2002).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.shaping.ends import Ends
from stitchmesh.shaping.triangle_surface import TriangleSurface

if TYPE_CHECKING:
    from scipy.sparse import csr_array

SMALLEST_WEIGHT = 0.05
"""Smallest weight of an edge, over the weight between equilateral triangles."""
MOST_ROUNDS = 8
"""How often summits are looked for, because smoothing one out can lift another one above its saddle."""


def neighbours(surface: TriangleSurface) -> tuple[IntArray, IntArray]:
    """Return the vertices next to each vertex as rows of a compressed array: starts, shape (V + 1,), and vertices."""
    ends = np.concatenate([surface.edges, surface.edges[:, ::-1]])
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    start = np.concatenate([[0], np.cumsum(np.bincount(ends[:, 0], minlength=len(surface.vertices)))])
    return start, ends[order, 1]


def summits(
    surface: TriangleSurface, values: FloatArray, kept: NDArray[np.bool_] | None = None
) -> list[tuple[int, float, float]]:
    """Return the vertex of each summit, its height above the saddle where it joins a higher one, and that saddle.

    The highest summit of a surface has infinite height. Equal values are ordered by vertex number, but those beside a
    higher value come last, so that the level border of an end has summits apart from a bump that touches it.

    Args:
        surface: the surface.
        values: the function, shape (V,).
        kept: whether a summit at a vertex counts as higher than those at all other ones, shape (V,); none if None.
    """
    start, beside = (part.tolist() for part in neighbours(surface))
    order = np.lexsort((np.arange(len(values)), _has_higher_neighbour(surface, values), -values)).tolist()
    rank = np.empty(len(values), dtype=np.int64)
    rank[order] = np.arange(len(order))
    place, parent, height = rank.tolist(), [-1] * len(values), values.tolist()
    order_of_summits = place if kept is None else (rank - len(rank) * kept).tolist()
    found = []
    for vertex in order:
        roots = []
        for other in beside[start[vertex] : start[vertex + 1]]:
            if place[other] < place[vertex]:
                root = _root(parent, other)
                if root not in roots:
                    roots.append(root)
        roots.sort(key=order_of_summits.__getitem__)
        parent[vertex] = roots[0] if roots else vertex
        for lower in roots[1:]:
            found.append((lower, height[lower] - height[vertex], height[vertex]))
            parent[lower] = roots[0]
    found += [(vertex, np.inf, -np.inf) for vertex in order if parent[vertex] == vertex]
    return found


def _has_higher_neighbour(surface: TriangleSurface, values: FloatArray) -> NDArray[np.bool_]:
    one, other = surface.edges.T
    found = np.zeros(len(values), dtype=bool)
    found[one[values[other] > values[one]]] = True
    found[other[values[one] > values[other]]] = True
    return found


def _root(parent: list[int], vertex: int) -> int:
    """The summit of the part that a vertex belongs to; paths are shortened on the way."""
    while parent[vertex] != parent[parent[vertex]]:
        parent[vertex] = parent[parent[vertex]]
    return parent[vertex]


def lasting_extrema(surface: TriangleSurface, values: FloatArray, least: float) -> IntArray:
    """Return the vertices of all summits that are higher than ``least`` above their saddle."""
    return np.array([vertex for vertex, height, _ in summits(surface, values) if height > least], dtype=np.int64)


def smooth_out(surface: TriangleSurface, values: FloatArray, least: float, ends: Ends) -> FloatArray:
    """Return the function without summits and hollows that are lower than ``least``, shape (V,).

    Args:
        surface: the surface.
        values: the function, shape (V,).
        least: height of a summit above its saddle from which it stays.
        ends: ends, whose vertices keep their values.
    """
    kept = np.zeros(len(values), dtype=bool)
    kept[np.concatenate([end.vertices for end in ends.all])] = True
    for _ in range(MOST_ROUNDS):
        region = np.zeros(len(values), dtype=bool)
        for sign in (1.0, -1.0):
            for vertex, height, saddle in summits(surface, sign * values, kept):
                if height < least and not kept[vertex]:
                    region |= _part_above(surface, sign * values, vertex, saddle, least)
        region &= ~kept
        if not region.any():
            break
        values = _harmonic(surface, values, region)
    return values


def _part_above(
    surface: TriangleSurface, values: FloatArray, summit: int, saddle: float, margin: float
) -> NDArray[np.bool_]:
    """Whether each vertex is connected to a summit strictly above its saddle, or is near such a vertex, shape (V,)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    above = values > saddle
    edges = surface.edges[above[surface.edges].all(axis=1)]
    graph = coo_array((np.ones(len(edges)), edges.T), shape=(len(values),) * 2)
    part = connected_components(graph.tocsr(), directed=False)[1]
    region = above & (part == part[summit])
    for _ in range(2):
        ring = surface.edges[region[surface.edges].any(axis=1)]
        region[ring.ravel()] = True
    return region


def _harmonic(surface: TriangleSurface, values: FloatArray, region: NDArray[np.bool_]) -> FloatArray:
    """Replace values in a region by the harmonic function with the values around it."""
    from scipy.sparse.linalg import spsolve

    matrix = _positive_laplacian(surface)
    inner, outer = np.flatnonzero(region), np.flatnonzero(~region)
    if not len(outer):
        return values
    rows = matrix[inner]
    smooth = values.copy()
    smooth[inner] = spsolve(rows[:, inner].tocsc(), -(rows[:, outer] @ values[outer]))
    return smooth


def _positive_laplacian(surface: TriangleSurface) -> csr_array:
    """A Laplacian whose edges all have positive weights, shape (V, V)."""
    from scipy.sparse import coo_array, diags_array

    full = surface.stiffness().tocoo()
    off = full.row != full.col
    least = SMALLEST_WEIGHT / np.sqrt(3.0)
    weight = np.maximum(-full.data[off], least)
    shape = (len(surface.vertices),) * 2
    links = coo_array((weight, (full.row[off], full.col[off])), shape=shape).tocsr()
    return (diags_array(links.sum(axis=1)) - links).tocsr()
