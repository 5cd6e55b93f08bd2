# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rotation of the corners of each face into the knitting frame."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER, IntArray, Mesh, StitchMesh
from stitchmesh.mesh.stitch import Stitch


def in_knitting_frame(mesh: Mesh, left_wale: IntArray, right_wale: IntArray, row: IntArray) -> StitchMesh:
    """Return a stitch mesh of panels whose corners are rotated to start at the lower left.

    Args:
        mesh: the surface.
        left_wale: left wale side of each face, shape (F,).
        right_wale: right wale side of each face, shape (F,).
        row: row of each face, shape (F,).
    """
    sizes = np.diff(mesh.face_start)
    first = mesh.side_next[left_wale] - mesh.face_start[:-1]
    place = np.arange(mesh.side_count) - mesh.face_start[:-1][mesh.side_face]
    old = mesh.face_start[:-1][mesh.side_face] + (place + first[mesh.side_face]) % sizes[mesh.side_face]
    new = np.empty_like(old)
    new[old] = np.arange(mesh.side_count)
    twin = mesh.twin[old]
    n_bottom = (right_wale - mesh.side_next[left_wale]) % sizes
    return StitchMesh(
        vertices=mesh.vertices,
        face_start=mesh.face_start,
        face_vertex=mesh.face_vertex[old],
        twin=np.where(twin == BORDER, BORDER, new[twin]),
        lattice=mesh.lattice,
        corner_image=None if mesh.corner_image is None else mesh.corner_image[old],
        n_bottom=n_bottom,
        n_top=sizes - 2 - n_bottom,
        stitch=np.full(mesh.face_count, Stitch.PANEL),
        row=row,
    )
