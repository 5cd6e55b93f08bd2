# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The surface of the panels, closed along the seams at which their stitches are joined."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from stitchmesh.mesh import BORDER, IntArray, Mesh
from stitchmesh.mesh.connectivity import find_fans
from stitchmesh.shaping.panels.outline_pieces import Piece
from stitchmesh.shaping.panels.seam_gap import drawn_back, gap_at


def sewn_surface(mesh: Mesh, pieces: list[Piece], joined: Iterable[int], width: float) -> Mesh:
    """Close panels along some seams; borders of the stitches are then borders of the surface, and no others.

    Args:
        mesh: the panels.
        pieces: pieces of the outlines.
        joined: numbers of the pieces that are joined to their partners.
        width: width of a stitch [cm], for the gap at the other seams.
    """
    border = np.flatnonzero(mesh.twin == BORDER)
    side_at = np.full(len(mesh.vertices), BORDER)
    side_at[mesh.face_vertex[border]] = border
    twin = mesh.twin.copy()
    for number in joined:
        one, other = _sides(side_at, pieces[number]), _sides(side_at, pieces[pieces[number].partner])[::-1]
        twin[one], twin[other] = other, one
    fan = find_fans(np.where(twin == BORDER, BORDER, mesh.side_next[twin]))
    vertices = np.zeros((int(fan.max()) + 1, 3))
    vertices[fan] = mesh.vertices[mesh.face_vertex]
    surface = Mesh(vertices, mesh.face_start, fan, twin)
    gap = np.zeros(mesh.side_count)
    for piece in pieces:
        if piece.partner >= 0:
            gap[_sides(side_at, piece)] = gap_at(piece, width)
    sewn = np.flatnonzero((gap > 0.0) & (twin == BORDER))
    return replace(surface, vertices=drawn_back(surface, sewn, gap[sewn]))


def _sides(side_at: IntArray, piece: Piece) -> IntArray:
    """Border sides along a piece."""
    return side_at[piece.vertices[:-1]]
