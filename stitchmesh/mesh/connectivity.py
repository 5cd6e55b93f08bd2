# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Twins of the sides of polygons, found from vertex numbers, and the checks for an oriented manifold surface.

SciPy's graph functions are imported inside the functions that use them, because every command imports this module
and ``--help`` must be fast.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import MeshError, first_few

IntArray = NDArray[np.int64]


def next_sides(face_start: IntArray) -> IntArray:
    """Next side around the same face of each side, shape (C,)."""
    following = np.arange(1, face_start[-1] + 1)
    following[face_start[1:] - 1] = face_start[:-1]
    return following


def find_twins(face_start: IntArray, face_vertex: IntArray, vertex_count: int) -> IntArray:
    """Find the twin of each side from vertex numbers, -1 at borders, shape (C,).

    Args:
        face_start: first corner of each face, and C at the end, shape (F + 1,).
        face_vertex: vertex of each corner, shape (C,).
        vertex_count: number of vertices.

    Raises:
        MeshError: an index is out of range, a face is degenerate or occurs twice, an edge has more than two faces,
            neighbouring faces have opposite orientations, or the surface is one-sided.
    """
    sizes = np.diff(face_start)
    if len(sizes) == 0:
        raise MeshError("mesh: got no faces; expected at least one polygon")
    if sizes.min() < 3:
        raise MeshError(f"face {int(sizes.argmin())}: got {sizes.min()} corners; expected at least 3")
    face = np.repeat(np.arange(len(sizes)), sizes)
    bad = np.flatnonzero((face_vertex < 0) | (face_vertex >= vertex_count))
    if len(bad):
        where = f"face {face[bad[0]]}: vertex {face_vertex[bad[0]]} does not exist"
        raise MeshError(f"{where}; the mesh has vertices 0 to {vertex_count - 1}")
    head = face_vertex[next_sides(face_start)]
    _check_repeats(face_start, face_vertex, face)
    return _pair_sides(face_vertex, head, face, vertex_count)


def _check_repeats(face_start: IntArray, face_vertex: IntArray, face: IntArray) -> None:
    """Check that no face has a vertex twice and that no two faces have the same vertices."""
    order = np.lexsort((face_vertex, face))
    repeated = np.flatnonzero((np.diff(face_vertex[order]) == 0) & (np.diff(face[order]) == 0))
    if len(repeated):
        corner = order[repeated[0]]
        raise MeshError(f"face {face[corner]}: vertex {face_vertex[corner]} occurs twice; a polygon visits each once")
    seen: dict[bytes, int] = {}
    sorted_vertices = face_vertex[order]
    for index in range(len(face_start) - 1):
        key = sorted_vertices[face_start[index] : face_start[index + 1]].tobytes()
        if key in seen:
            raise MeshError(f"face {index}: has the same vertices as face {seen[key]}; remove duplicate faces")
        seen[key] = index


def _pair_sides(tail: IntArray, head: IntArray, face: IntArray, vertex_count: int) -> IntArray:
    """Pair the sides with the same two vertices; return the twin of each side, shape (C,).

    Args:
        tail: vertex at which each side starts, shape (C,).
        head: vertex at which each side ends, shape (C,).
        face: face of each side, shape (C,).
        vertex_count: number of vertices.
    """
    edge = np.minimum(tail, head) * vertex_count + np.maximum(tail, head)
    order = np.argsort(edge, kind="stable")
    _, first, count = np.unique(edge[order], return_index=True, return_counts=True)
    crowded = np.flatnonzero(count > 2)
    if len(crowded):
        sides = order[first[crowded[0]] : first[crowded[0]] + count[crowded[0]]]
        ends = f"{tail[sides[0]]}-{head[sides[0]]}"
        raise MeshError(
            f"edge {ends}: {len(sides)} faces share it ({first_few(face[sides], 4)}); a manifold surface has at most 2"
        )
    left, right = order[first[count == 2]], order[first[count == 2] + 1]
    same = tail[left] == tail[right]
    if same.any():
        _explain_orientation(face, left, right, same, tail, head)
    twin = np.full(len(tail), -1, dtype=np.int64)
    twin[left], twin[right] = right, left
    return twin


def _explain_orientation(
    face: IntArray, left: IntArray, right: IntArray, same: NDArray[np.bool_], tail: IntArray, head: IntArray
) -> None:
    """Raise an error that distinguishes faces of the wrong orientation from a one-sided surface."""
    patch, flips = patches_and_flips(face[left], face[right], same, int(face.max()) + 1)
    one_sided = np.flatnonzero(patch[face[left]] < 0)
    if len(one_sided):
        side = left[one_sided[0]]
        raise MeshError(one_sided_surface(f"{tail[side]}-{head[side]}", int(face[side])))
    turned = np.flatnonzero(flips if flips.sum() * 2 <= len(flips) else ~flips)
    side = left[np.flatnonzero(same)[0]]
    raise MeshError(
        f"edge {tail[side]}-{head[side]}: both faces pass it in the same direction; "
        f"reverse the vertex order of face {first_few(turned)}"
    )


def patches_and_flips(
    first: IntArray, second: IntArray, same: NDArray[np.bool_], count: int
) -> tuple[IntArray, NDArray[np.bool_]]:
    """Find the faces to reverse so that neighbours pass their edges in opposite directions.

    Each face is a pair of nodes of a graph: the face as it is, and the face reversed. For two faces that share an edge,
    links join the nodes that pass the edge in opposite directions. The group of one node is a consistent choice for all
    faces of a patch, unless it holds both nodes of a face: then the surface has one side only.

    Args:
        first: first face of each pair that shares an edge, shape (n,).
        second: second face of each pair, shape (n,).
        same: whether the two pass the edge in the same direction, shape (n,).
        count: number of faces.

    Returns:
        Number of the patch of each face, -1 in a patch with one side only, and whether to reverse each face so that it
        agrees with the first face of its patch; both of shape (F,).
    """
    beside_own = np.where(same, second + count, second)
    beside_reversed = np.where(same, second, second + count)
    one, other = np.concatenate([first, first + count]), np.concatenate([beside_own, beside_reversed])
    own, reverse = linked_groups(2 * count, one, other).reshape(2, count)
    return np.where(own == reverse, -1, np.minimum(own, reverse)), own > reverse


def one_sided_surface(edge: str, face: int) -> str:
    """Return the message about a surface with one side, which runs through an edge and a face."""
    found = f"the surface has one side only (a Moebius strip through face {face})"
    return f"edge {edge}: {found}; cut it along an edge loop"


def linked_groups(count: int, one: IntArray, other: IntArray) -> IntArray:
    """Number the groups of elements that links connect, and return the group of each element, shape (count,).

    Groups are numbered in the order of their first elements.

    Args:
        count: number of elements.
        one: element at the first end of each link, shape (n,).
        other: element at the second end of each link, shape (n,).
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not count:
        return np.zeros(0, dtype=np.int64)
    graph = coo_array((np.ones(len(one)), (one, other)), shape=(count, count))
    # SciPy follows the links from the first element, then from the first that has no number yet, and so on.
    group: IntArray = connected_components(graph.tocsr(), directed=False)[1].astype(np.int64)
    return group


class ParityForest:
    """Union-find structure whose links store the parity of two nodes: 0 for the same direction, 1 for the opposite."""

    def __init__(self, count: int) -> None:
        """Start with nodes that are not linked."""
        self._parent = list(range(count))
        self._flip = [0] * count

    def find(self, node: int) -> tuple[int, int]:
        """Return the root of a node, and the parity of the node relative to it; node -1 is the last one."""
        node, parity = node % len(self._parent), 0
        while self._parent[node] != node:
            parity ^= self._flip[node]
            node = self._parent[node]
        return node, parity

    def join(self, first: int, second: int, differ: int) -> bool:
        """Join the components of two nodes with a parity; return whether the two nodes now have this parity.

        Nodes that are in one component already keep their parity.
        """
        (a, parity_a), (b, parity_b) = self.find(first), self.find(second)
        parity = parity_a ^ parity_b ^ differ
        if a == b:
            return parity == 0
        self._parent[b], self._flip[b] = a, parity
        return True


def find_fans(neighbour: IntArray) -> IntArray:
    """Number the fans of faces, and return the fan of each corner, shape (n,).

    A fan is a set of faces around one vertex, each of which shares an edge with the next.

    Args:
        neighbour: next corner around the same vertex, -1 across a border, shape (n,).
    """
    inner = np.flatnonzero(neighbour >= 0)
    return linked_groups(len(neighbour), inner, neighbour[inner])


def corner_fans(twin: IntArray, following: IntArray) -> IntArray:
    """Return the fan of faces to which each corner belongs, shape (C,).

    Args:
        twin: opposite side of each side, -1 at borders, shape (C,).
        following: next side around the same face of each side, shape (C,).
    """
    return find_fans(np.where(twin == -1, -1, following[twin]))


def check_fans(corner_vertex: IntArray, neighbour: IntArray, vertex_count: int) -> None:
    """Check that the faces around each vertex form one fan.

    Args:
        corner_vertex: vertex of each corner, shape (n,).
        neighbour: next corner around the same vertex, -1 across a border, shape (n,).
        vertex_count: number of vertices.

    Raises:
        MeshError: two fans of faces meet in one vertex.
    """
    fan = find_fans(neighbour)
    of_fan = np.empty(fan.max(initial=-1) + 1, dtype=np.int64)
    of_fan[fan] = corner_vertex
    bad = np.flatnonzero(np.bincount(of_fan, minlength=vertex_count) > 1)
    if len(bad):
        raise MeshError(f"vertex {first_few(bad)}: separate parts of the surface meet in one vertex; split the vertex")
