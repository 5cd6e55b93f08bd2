# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The outline of some faces of a mesh."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh.polygon_mesh import BORDER, IntArray, Mesh


def outline_sides(mesh: Mesh, faces: IntArray) -> IntArray:
    """Return the sides of some faces that no other of these faces touches, shape (n,).

    Args:
        mesh: the mesh.
        faces: the faces, shape (m,).
    """
    within = np.zeros(mesh.face_count, dtype=bool)
    within[faces] = True
    sides = mesh.sides_of(faces)
    across = mesh.twin[sides]
    return sides[(across == BORDER) | ~within[mesh.side_face[across]]]
