# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Chains of course edges from which rows can start: borders between corners, and edge loops in the interior."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, Mesh

REGULAR_BORDER_FACES = 2
"""Number of faces at a border vertex that is not a corner; one wale edge starts there."""


def side_of(mesh: Mesh, edge: int | tuple[int, int]) -> int:
    """Return the side of a side number or of a pair of vertices.

    Raises:
        ParameterError: there is no such side or edge.
    """
    if isinstance(edge, (int, np.integer)):
        if not 0 <= edge < mesh.side_count:
            raise ParameterError(f"seed {edge}: no such side; the mesh has sides 0 to {mesh.side_count - 1}")
        return int(edge)
    start, end = edge
    tail, head = mesh.face_vertex, mesh.face_vertex[mesh.side_next]
    forward = np.flatnonzero((tail == start) & (head == end))
    backward = np.flatnonzero((tail == end) & (head == start))
    found = np.concatenate([forward, backward])
    if len(found) == 0:
        raise ParameterError(f"seed ({start}, {end}): no edge joins these vertices; name two neighbours")
    return int(found[0])


def seed_chain(mesh: Mesh, side: int) -> list[int]:
    """Return the course sides that a seed marks, starting with the seed itself."""
    if mesh.twin[side] == BORDER:
        return _border_chain(mesh, side)
    return _edge_loop(mesh, side)


def candidate_seeds(mesh: Mesh) -> list[list[int]]:
    """Return the border chains from which rows may start, best first.

    Closed borders without corners come first, in descending order of length. Chains between corners follow, in
    ascending order of height (y).
    """
    whole: list[list[int]] = []
    parts: list[list[int]] = []
    for loop in mesh.boundary_loops:
        chains = _chains_of(mesh, loop.tolist())
        (whole if len(chains) == 1 and len(chains[0]) == len(loop) else parts).extend(chains)
    whole.sort(key=lambda chain: -round(float(mesh.side_length[chain].sum()), 6))
    parts.sort(key=lambda chain: round(float(mesh.corner_position[chain, 1].mean()), 6))
    return whole + parts


def _chains_of(mesh: Mesh, loop: list[int]) -> list[list[int]]:
    """Divide a border loop at its corners."""
    faces = np.bincount(mesh.face_vertex, minlength=len(mesh.vertices))
    cuts = [i for i, side in enumerate(loop) if faces[mesh.face_vertex[side]] != REGULAR_BORDER_FACES]
    if not cuts:
        return [loop]
    turned = loop[cuts[0] :] + loop[: cuts[0]]
    marks = [cut - cuts[0] for cut in cuts] + [len(loop)]
    return [turned[a:b] for a, b in pairwise(marks)]


def _border_chain(mesh: Mesh, side: int) -> list[int]:
    """The border sides between the corners on both sides of a border side, starting with the side itself."""
    for loop in mesh.boundary_loops:
        if side in loop:
            chain = next(chain for chain in _chains_of(mesh, loop.tolist()) if side in chain)
            place = chain.index(side)
            return chain[place:] + chain[:place]
    raise AssertionError("every border side lies on a border loop")


def _edge_loop(mesh: Mesh, side: int) -> list[int]:
    """The edge loop through a side, which continues straight through vertices with four faces, in both directions."""
    faces = np.bincount(mesh.face_vertex, minlength=len(mesh.vertices))
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
    current = side
    while faces[mesh.face_vertex[current]] == 4:
        across = mesh.twin[mesh.side_previous[current]]
        if across == BORDER or mesh.side_previous[across] in chain:
            break
        current = int(mesh.side_previous[across])
        chain.append(current)
        if mesh.twin[current] == BORDER:
            break
    return chain
