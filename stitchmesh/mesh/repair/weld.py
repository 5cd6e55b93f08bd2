# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Vertices at one position that become one vertex.

Programs repeat the vertices along the seams of textures, and STL files repeat them for each triangle. Only vertices of
the border are welded: a vertex with faces all around it needs no other vertex. SciPy is imported inside the functions
that use it, because a start of the program must be fast.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.connectivity import linked_groups
from stitchmesh.mesh.polygon_mesh import FloatArray, IntArray
from stitchmesh.mesh.repair.action import RepairOptions
from stitchmesh.mesh.repair.soup import Soup, edges_of, numbers_in

LARGEST_OF_EDGE = 0.5
"""Largest weld distance as a multiple of the median length of an edge, if one is given."""


def weld_distance(soup: Soup, options: RepairOptions) -> float:
    """Return the weld distance [cm].

    Raises:
        ParameterError: the given distance is above half the median length of an edge.
    """
    edge = median_edge(soup)
    if options.weld_distance is None:
        used = soup.points[soup.vertex]
        # Points that a stray face far away makes look near are kept apart by the length of the usual edge.
        return min(1e-6 * float(np.linalg.norm(np.ptp(used, axis=0))), 0.01 * edge)
    if options.weld_distance > LARGEST_OF_EDGE * edge > 0.0:
        found = f"got {options.weld_distance:g} cm; half of all edges are shorter than {edge:g} cm"
        raise ParameterError(f"weld_distance: {found}, expected at most {LARGEST_OF_EDGE * edge:g} cm")
    return float(options.weld_distance)


def median_edge(soup: Soup) -> float:
    """Return the median length of the sides that have a length [cm], 0 if no side has one."""
    length = soup.side_length[soup.side_length > 0.0]
    return float(np.median(length)) if len(length) else 0.0


def weld(soup: Soup, distance: float) -> Soup:
    """Give vertices nearer than a distance one number, the lowest of them.

    Two corners of one face are welded only if the face has no area or is smaller than the distance.

    Args:
        soup: faces that visit each of their vertices once; ``vertex`` and ``source`` are equal.
        distance: the weld distance [cm].
    """
    small = soup.without_area | (_face_extent(soup) <= distance)
    members = _weldable(soup, small, distance)
    group = np.arange(len(soup.points))
    group[members] = _first_at_position(soup.points, members)
    pairs = _near_pairs(soup.points, numbers_in(group[members], len(group)), distance)
    if len(pairs):
        group = _merge(soup, group, pairs, small)
    return replace(soup, vertex=group[soup.vertex])


def _face_extent(soup: Soup) -> FloatArray:
    """Diagonal of the bounding box of each face [cm], shape (F,)."""
    position, first = soup.points[soup.vertex], soup.start[:-1]
    size = np.maximum.reduceat(position, first, axis=0) - np.minimum.reduceat(position, first, axis=0)
    return np.linalg.norm(size, axis=1)


def _weldable(soup: Soup, small: NDArray[np.bool_], distance: float) -> IntArray:
    """Vertices on edges that do not have two sides, and on very short sides of faces that vanish, ascending."""
    edges = edges_of(soup)
    chosen = small[soup.side_face] & (soup.side_length <= distance)
    chosen[edges.sides[np.repeat(edges.count != 2, edges.count)]] = True
    return numbers_in(np.concatenate([soup.vertex[chosen], soup.head[chosen]]), len(soup.points))


def _first_at_position(points: FloatArray, members: IntArray) -> IntArray:
    """Lowest member that lies exactly at the position of each member, shape (n,)."""
    x, y, z = points[members].T
    order = np.lexsort((z, y, x))  # Members at one position stay in ascending order.
    moved = (np.diff(points[members[order]], axis=0) != 0.0).any(axis=1)
    run = np.concatenate([[0], np.cumsum(moved)])[: len(order)]
    first = np.empty_like(members)
    first[order] = members[order][np.searchsorted(run, run)]
    return first


def _near_pairs(points: FloatArray, members: IntArray, distance: float) -> IntArray:
    """Pairs of members nearer than a distance, shape (n, 2)."""
    from scipy.spatial import cKDTree

    if distance == 0.0 or not len(members):
        return np.zeros((0, 2), dtype=np.int64)
    pairs = cKDTree(points[members]).query_pairs(distance, output_type="ndarray")
    return members[pairs.reshape(-1, 2)]


def _merge(soup: Soup, group: IntArray, pairs: IntArray, small: NDArray[np.bool_]) -> IntArray:
    """Join the groups of near pairs, and return the lowest vertex that each vertex is welded to, shape (V,)."""
    together = _lowest_linked(pairs, len(group))
    crushed = _numbers_twice_in_a_face(soup, group, together, small)
    if len(crushed):
        whole = ~np.isin(together[pairs[:, 0]], crushed)
        doubtful = _joined_one_by_one(soup, group, pairs[~whole], small)
        together = _lowest_linked(np.concatenate([pairs[whole], doubtful]), len(group))
    return together[group]


def _lowest_linked(pairs: IntArray, count: int) -> IntArray:
    """Lowest number that each number is linked to by pairs, shape (count,)."""
    group = linked_groups(count, pairs[:, 0], pairs[:, 1])
    return np.unique(group, return_index=True)[1][group]


def _numbers_twice_in_a_face(soup: Soup, group: IntArray, together: IntArray, small: NDArray[np.bool_]) -> IntArray:
    """Joined numbers at different corners of a face that must not vanish, ascending."""
    corners = np.flatnonzero(~small[soup.side_face])
    old = group[soup.vertex[corners]]
    new, face = together[old], soup.side_face[corners]
    order = np.lexsort((old, new, face))
    twice = (np.diff(new[order]) == 0) & (np.diff(face[order]) == 0) & (np.diff(old[order]) != 0)
    return np.unique(new[order[1:]][twice])


def _joined_one_by_one(soup: Soup, group: IntArray, pairs: IntArray, small: NDArray[np.bool_]) -> IntArray:
    """The pairs that can be joined, the nearest first, so that no two corners of one face become one, shape (n, 2)."""
    offset = soup.points[pairs[:, 0]] - soup.points[pairs[:, 1]]
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0], np.linalg.norm(offset, axis=1)))]
    root = {int(number): int(number) for number in np.unique(pairs)}
    faces: dict[int, set[int]] = {number: set() for number in root}
    touched = np.flatnonzero(np.isin(group[soup.vertex], list(root)) & ~small[soup.side_face])
    for number, face in zip(group[soup.vertex[touched]].tolist(), soup.side_face[touched].tolist(), strict=True):
        faces[number].add(face)
    joined = []
    for first, second in pairs.tolist():
        a, b = _root(root, first), _root(root, second)
        if a != b and faces[a].isdisjoint(faces[b]):
            root[b] = a
            faces[a] |= faces[b]
            joined.append([first, second])
    return np.array(joined, dtype=np.int64).reshape(-1, 2)


def _root(root: dict[int, int], number: int) -> int:
    while root[number] != number:
        root[number] = root[root[number]]
        number = root[number]
    return number
