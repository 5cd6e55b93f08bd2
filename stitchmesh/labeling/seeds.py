# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Chains of course edges from which rows can start: borders between corners, and edge loops in the interior."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from stitchmesh.errors import ParameterError, first_few
from stitchmesh.mesh import BORDER, IntArray, Mesh

EdgeName = int | tuple[int, int]
"""A side number, or the two vertices of an edge. The seeded row is to the left of the side, or of the edge directed
from the first vertex to the second."""


def side_of(mesh: Mesh, edge: EdgeName) -> int:
    """Return the side of a side number or of a pair of vertices.

    Raises:
        ParameterError: there is no such side or edge.
    """
    if isinstance(edge, (int, np.integer)):
        if not 0 <= edge < mesh.side_count:
            raise ParameterError(f"edge: there is no side {edge}; the mesh has sides 0 to {mesh.side_count - 1}")
        return int(edge)
    start, end = edge
    tail = mesh.face_vertex
    around = np.flatnonzero((tail == start) | (tail == end))
    head = tail[mesh.side_next[around]]
    found = [*around[(tail[around] == start) & (head == end)], *around[(tail[around] == end) & (head == start)]]
    if not found:
        raise ParameterError(f"edge {start}-{end}: no edge joins these vertices; name two neighbours")
    return int(found[0])


def edge_name(mesh: Mesh, side: int) -> str:
    """Return the name of the edge of a side in messages: its two vertices."""
    return f"{mesh.face_vertex[side]}-{mesh.face_vertex[mesh.side_next[side]]}"


def seed_chain(mesh: Mesh, side: int) -> list[int]:
    """Return the course sides that a seed marks, starting with the seed itself."""
    if mesh.twin[side] == BORDER:
        return _border_chain(mesh, side)
    return _edge_loop(mesh, side)


def whole_border(mesh: Mesh, edge: EdgeName) -> list[int]:
    """Return all sides of the border that contains an edge, starting with this edge.

    Raises:
        ParameterError: there is no such edge, or it does not lie on a border.
    """
    side = side_of(mesh, edge)
    if mesh.twin[side] != BORDER:
        named = first_few([edge_name(mesh, loop[0]) for loop in mesh.boundary_loops])
        borders = f"edges of its borders are {named}" if mesh.boundary_loops else "the mesh has no border"
        raise ParameterError(f"edge {edge_name(mesh, side)}: does not lie on a border; {borders}")
    loop = [side]
    while (following := mesh.next_border_side(loop[-1])) != side:
        loop.append(following)
    return loop


def candidate_seeds(mesh: Mesh) -> list[list[int]]:
    """Return the border chains from which rows may start, best first.

    Closed borders without corners come first, in descending order of length. Chains between corners follow, in
    ascending order of height (y).
    """
    whole: list[list[int]] = []
    parts: list[list[int]] = []
    faces = _faces_at_vertex(mesh)
    for loop in mesh.boundary_loops:
        chains = _chains_of(mesh, loop.tolist(), faces)
        (whole if len(chains) == 1 and len(chains[0]) == len(loop) else parts).extend(chains)
    whole.sort(key=lambda chain: -round(float(mesh.side_length[chain].sum()), 6))
    parts.sort(key=lambda chain: round(float(mesh.corner_position[chain, 1].mean()), 6))
    return whole + parts


def _faces_at_vertex(mesh: Mesh) -> IntArray:
    """Number of faces at each vertex, shape (V,)."""
    return np.bincount(mesh.face_vertex, minlength=len(mesh.vertices))


def _chains_of(mesh: Mesh, loop: list[int], faces: IntArray) -> list[list[int]]:
    """Divide a border loop at its corners.

    Args:
        mesh: the mesh.
        loop: sides of the border, in order.
        faces: number of faces at each vertex, shape (V,).
    """
    # Number of faces at a border vertex that is not a corner; one wale edge starts there.
    cuts = [i for i, side in enumerate(loop) if faces[mesh.face_vertex[side]] != 2]
    if not cuts:
        return [loop]
    turned = loop[cuts[0] :] + loop[: cuts[0]]
    marks = [cut - cuts[0] for cut in cuts] + [len(loop)]
    return [turned[a:b] for a, b in pairwise(marks)]


def _border_chain(mesh: Mesh, side: int) -> list[int]:
    """The border sides between the corners on both sides of a border side, starting with the side itself."""
    chains = _chains_of(mesh, whole_border(mesh, side), _faces_at_vertex(mesh))
    chain = next(chain for chain in chains if side in chain)
    place = chain.index(side)
    return chain[place:] + chain[:place]


def _edge_loop(mesh: Mesh, side: int) -> list[int]:
    """The edge loop through a side, which continues straight through vertices with four faces, in both directions."""
    faces = _faces_at_vertex(mesh)
    chain = [side]
    current = side
    while faces[mesh.face_vertex[mesh.side_next[current]]] == 4:
        across = mesh.twin[mesh.side_next[current]]
        if across == BORDER or mesh.side_next[across] in (side, mesh.twin[side]):
            return chain
        current = int(mesh.side_next[across])
        chain.append(current)
        if mesh.twin[current] == BORDER:
            break
    current, known = side, set(chain)
    while faces[mesh.face_vertex[current]] == 4:
        across = mesh.twin[mesh.side_previous[current]]
        if across == BORDER or int(mesh.side_previous[across]) in known:
            break
        current = int(mesh.side_previous[across])
        chain.append(current)
        known.add(current)
        if mesh.twin[current] == BORDER:
            break
    return chain
