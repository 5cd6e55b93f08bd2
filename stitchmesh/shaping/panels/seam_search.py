# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Seams of panels: borders that lie on each other in space."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER, IntArray, Mesh
from stitchmesh.shaping.panels.panel_mesh import Seam

NEAR = 1e-3
"""Distance of two vertices on borders, over the mean length of a border side, up to which they are at one place. The
two sides of a seam are written with rounded coordinates."""


def find_seams(mesh: Mesh, face_panel: IntArray) -> tuple[Seam, ...]:
    """Find the seams of a mesh that is cut along them.

    Two border sides are sewn if their vertices lie at equal places up to ``NEAR``, in opposite order. Where three or
    more panels meet along one line, nothing is sewn.

    Args:
        mesh: the panels.
        face_panel: panel of each face, shape (F,).
    """
    across = _sides_across(mesh)
    used = across == BORDER
    seams = []
    for start in _line_starts(mesh, across):
        line: list[int] = []
        side = start
        while not used[side]:
            line.append(side)
            used[[side, across[side]]] = True
            side = _next_on_seam(mesh, across, side)
        if line:
            seams.append(_seam(mesh, face_panel, np.array(line), across[line]))
    return tuple(seams)


def _sides_across(mesh: Mesh) -> IntArray:
    """The border side that lies on each border side in the opposite direction, ``BORDER`` if none does, shape (C,)."""
    border = np.flatnonzero(mesh.twin == BORDER)
    ends = _places(mesh, np.stack([mesh.face_vertex[border], mesh.face_vertex[mesh.side_next[border]]], axis=1))
    _, line, count = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True)
    line = line.reshape(-1)
    order = np.argsort(line, kind="stable")
    pairs = order[np.isin(line[order], np.flatnonzero(count == 2))].reshape(-1, 2)
    pairs = pairs[ends[pairs[:, 0], 0] == ends[pairs[:, 1], 1]]
    across = np.full(mesh.side_count, BORDER)
    across[border[pairs[:, 0]]], across[border[pairs[:, 1]]] = border[pairs[:, 1]], border[pairs[:, 0]]
    return across


def _places(mesh: Mesh, ends: IntArray) -> IntArray:
    """Number of the place of each end of some sides, shape (n, 2); vertices that are near each other share a place."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    own, end = np.unique(ends, return_inverse=True)
    points = mesh.vertices[own]
    length = np.linalg.norm(mesh.vertices[ends[:, 1]] - mesh.vertices[ends[:, 0]], axis=1)
    pairs = cKDTree(points).query_pairs(NEAR * float(length.mean()), output_type="ndarray") if len(own) else ends
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(own),) * 2)
    place: IntArray = connected_components(graph.tocsr(), directed=False)[1].astype(np.int64)
    return place[end.reshape(-1, 2)]


def _line_starts(mesh: Mesh, across: IntArray) -> list[int]:
    """Sides at which seams may begin: first those that follow on no other side, then all others for closed seams."""
    sewn = np.flatnonzero(across != BORDER).tolist()
    follows = {_next_on_seam(mesh, across, side) for side in sewn}
    return [*(side for side in sewn if side not in follows), *sewn]


def _next_on_seam(mesh: Mesh, across: IntArray, side: int) -> int:
    """The next border side if it continues the seam of a side; else the side itself.

    A seam ends where another panel begins on either side, and at the tip of a dart.
    """
    following = mesh.next_border_side(side)
    beyond = int(across[following])
    goes_on = beyond not in (BORDER, side) and mesh.next_border_side(beyond) == across[side]
    return following if goes_on else side


def _seam(mesh: Mesh, face_panel: IntArray, sides: IntArray, across: IntArray) -> Seam:
    tail, head = mesh.face_vertex, mesh.face_vertex[mesh.side_next]
    first, second = np.append(tail[sides], head[sides[-1]]), np.append(head[across], tail[across[-1]])
    panels = face_panel[mesh.side_face[[sides[0], across[0]]]].tolist()
    return Seam((panels[0], panels[1]), first, second)
