# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Repair of edges with more than two faces, of vertices in which parts meet, and of faces of the wrong direction.

Along an edge with more than two faces, faces are joined in pairs. Pairs that pass the edge in opposite directions come
first, and among them the flattest pair. A pair that would make the surface one-sided is left apart. The faces around
each vertex then fall into fans, and each fan becomes a vertex of its own.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.mesh.connectivity import ParityForest, corner_fans
from stitchmesh.mesh.polygon_mesh import BORDER, FloatArray, IntArray
from stitchmesh.mesh.repair.action import ActionLog
from stitchmesh.mesh.repair.orientation import patches_and_flips
from stitchmesh.mesh.repair.soup import EdgeSides, Soup, edge_keys, edge_sides, edges_of

DECIMALS = 6
"""Two pairs of faces are equally flat if the cosines of their angles agree to this number of decimals."""


def make_manifold(soup: Soup, log: ActionLog) -> Soup:
    """Return faces that form an oriented manifold surface, with one vertex for each fan of faces.

    A vertex of the result takes its position and its place in the order from the first of its vertices in the input. If
    the fans of one vertex of the input are separated, the additional vertices come after all others.

    Args:
        soup: welded faces that visit each of their vertices once.
        log: takes the actions.

    Raises:
        MeshError: the surface has one side only.
    """
    edges = edges_of(soup)
    inner = _two_sided(soup, edges.with_count(2))
    patch, flips = patches_and_flips(soup, inner)
    pairs = np.concatenate([inner, _pairs_on_crowded_edges(soup, edges, patch, flips)])
    flips = patches_and_flips(soup, pairs)[1]
    log.add("reversed faces", soup.origin[flips].tolist())
    pairs, turned = soup.sides_after_reversal(flips)[pairs], soup.reversed(flips)
    crowded = edges_of(turned)
    separated = _one_vertex_for_each_fan(turned, _fans(turned, pairs))
    _log_splits(turned, crowded, separated, log)
    return separated


def _two_sided(soup: Soup, pairs: IntArray) -> IntArray:
    """Leave out pairs that only the weld has made, if they make a connected part of the input one-sided, shape (n, 2).

    Such a part is a Moebius strip that was cut open.
    """
    in_input = _same_edge_in_input(soup, pairs)
    patch, flips = patches_and_flips(soup, pairs[in_input])
    patches = patch[soup.side_face[pairs]]
    return pairs[in_input | (patches[:, 0] != patches[:, 1]) | ~_opposed(soup, pairs, flips)]


def _same_edge_in_input(soup: Soup, pairs: IntArray) -> NDArray[np.bool_]:
    """Whether two sides along one edge run between the same vertices of the input, shape (n,)."""
    ends = np.stack([soup.source[pairs], soup.source[soup.side_next[pairs]]], axis=2)
    same: NDArray[np.bool_] = (np.sort(ends[:, 0], axis=1) == np.sort(ends[:, 1], axis=1)).all(axis=1)
    return same


def _opposed(soup: Soup, pairs: IntArray, flips: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether the faces of two sides along one edge disagree in direction after some faces are reversed, shape (n,)."""
    same = soup.vertex[pairs[:, 0]] == soup.vertex[pairs[:, 1]]
    return same ^ flips[soup.side_face[pairs[:, 0]]] ^ flips[soup.side_face[pairs[:, 1]]]


def _pairs_on_crowded_edges(soup: Soup, edges: EdgeSides, patch: IntArray, flips: NDArray[np.bool_]) -> IntArray:
    """Sides that are joined along edges with more than two sides, shape (n, 2).

    Args:
        soup: the faces.
        edges: their sides by edge.
        patch: patch of each face, shape (F,).
        flips: whether each face will be reversed, shape (F,).
    """
    pairs = [edges.with_count(count)[:, np.triu_indices(count, 1)] for count in edges.crowded_counts()]
    if not pairs:
        return np.zeros((0, 2), dtype=np.int64)
    candidates = np.concatenate([np.moveaxis(part, 1, 2).reshape(-1, 2) for part in pairs])
    opposed = _opposed(soup, candidates, flips)
    flatness, reflex = _bend(soup, candidates, flips)
    apart = ~_same_edge_in_input(soup, candidates)
    order = np.lexsort((candidates[:, 1], candidates[:, 0], reflex, apart, flatness, opposed))
    return _joined(candidates[order], opposed[order], patch[soup.side_face[candidates[order]]])


def _bend(soup: Soup, pairs: IntArray, flips: NDArray[np.bool_]) -> tuple[FloatArray, NDArray[np.bool_]]:
    """How faces meet along an edge.

    Returns:
        Cosine of the angle between the two faces, -1 for a flat pair and 1 for a pair that is folded together, and
        whether the second face rises above the outside of the first; both of shape (n,).
    """
    normal = soup.vector_area / soup.area[:, None]
    along = soup.points[soup.head] - soup.points[soup.vertex]
    inwards = unit_vectors(np.cross(normal[soup.side_face[pairs]], along[pairs]))
    cosine = np.einsum("ni,ni->n", inwards[:, 0], inwards[:, 1])
    face = soup.side_face[pairs[:, 0]]
    outside = np.where(flips[face], -1.0, 1.0)[:, None] * normal[face]
    rise = np.einsum("ni,ni->n", inwards[:, 1], outside)
    return np.round(cosine, DECIMALS), np.round(rise, DECIMALS) > 0.0


def _joined(pairs: IntArray, opposed: NDArray[np.bool_], patch: IntArray) -> IntArray:
    """Take pairs in their order while each side is free and the surface stays two-sided, shape (n, 2).

    Args:
        pairs: candidates, shape (m, 2).
        opposed: whether the faces of each pair have opposite directions, shape (m,).
        patch: patches of the two faces of each pair, shape (m, 2).
    """
    forest = ParityForest(int(patch.max(initial=-1)) + 1)
    used: set[int] = set()
    chosen = []
    for number, (first, second) in enumerate(pairs.tolist()):
        if first in used or second in used:
            continue
        one, other = patch[number].tolist()
        if not forest.join(one, other, int(opposed[number])):
            continue
        used |= {first, second}
        chosen.append(number)
    return pairs[chosen]


def _fans(soup: Soup, pairs: IntArray) -> IntArray:
    """Fan of each corner, such that no edge between two fans has more than two sides, shape (C,).

    A surface can wind around a vertex, so that one fan has more than two sides along an edge. It is then cut there.
    """
    while True:
        twin = np.full(len(soup.vertex), BORDER)
        twin[pairs[:, 0]], twin[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]
        fan = corner_fans(twin, soup.side_next)
        edges = edge_sides(fan, fan[soup.side_next])
        if not edges.crowded_counts():
            return fan
        pairs = edges.with_count(2)


def _one_vertex_for_each_fan(soup: Soup, fan: IntArray) -> Soup:
    """Give each fan a vertex of its own.

    With welded positions each face had an area. Parts that touch may keep their own positions, but if a face loses its
    area by this, all vertices take the welded positions.
    """
    corners = np.lexsort((soup.source, fan))
    _, first = np.unique(fan[corners], return_index=True)
    source = soup.source[corners[first]]  # Lowest vertex of the input of each fan.
    welded = soup.points[soup.vertex[corners[first]]]
    lowest_corner = np.full(len(source), len(fan))
    np.minimum.at(lowest_corner, fan, np.arange(len(fan)))
    order = np.lexsort((lowest_corner, source))
    again = np.concatenate([[False], np.diff(source[order]) == 0])
    order = np.concatenate([order[~again], order[again]])
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    separated = replace(soup, points=soup.points[source[order]], vertex=number[fan], source=source[fan])
    return replace(separated, points=welded[order]) if separated.without_area.any() else separated


def _log_splits(before: Soup, edges: EdgeSides, after: Soup, log: ActionLog) -> None:
    """Note the welded vertices, the crowded edges, and the other vertices that were split."""
    crowded = _changed(before, edges, after)
    ends = np.stack([before.vertex[crowded], before.head[crowded]], axis=1)
    log.add("crowded edges", [(int(start), int(end)) for start, end in np.sort(ends, axis=1)])
    count = int(before.source.max()) + 1
    source = np.empty(len(after.points), dtype=np.int64)
    source[after.vertex] = after.source
    made = np.bincount(source, minlength=count)  # Number of vertices that come from each vertex of the input.
    log.add("welded vertices", np.flatnonzero((made == 0) & (np.bincount(before.source) > 0)).tolist())
    copied = np.flatnonzero(made > 1)
    at_edges = np.isin(before.source, copied) & np.isin(before.vertex, ends)
    log.add("shared vertices", np.setdiff1d(copied, before.source[at_edges]).tolist())


def _changed(before: Soup, edges: EdgeSides, after: Soup) -> IntArray:
    """First sides of edges with more than two sides, if their faces are joined otherwise than in the input, shape (n,).

    Vertices of the input can share a position on purpose: three faces on one edge are then a pair and a single face.
    """
    found = []
    for edge in np.flatnonzero(edges.count > 2):
        sides = edges.sides[edges.first[edge] :][: edges.count[edge]]
        old = edge_keys(before.source[sides], before.source[before.side_next[sides]], len(before.points)).tolist()
        new = edge_keys(after.vertex[sides], after.head[sides], len(after.points)).tolist()
        if not len(set(old)) == len(set(new)) == len(set(zip(old, new, strict=True))):
            found.append(int(sides[0]))
    return np.array(found, dtype=np.int64)
