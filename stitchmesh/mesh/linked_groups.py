# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Groups of elements that links connect, among them the connected parts of a mesh."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh.polygon_mesh import BORDER, IntArray, Mesh


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

    links = coo_array((np.ones(len(one)), (one, other)), shape=(count, count))
    group: IntArray = connected_components(links.tocsr(), directed=False)[1].astype(np.int64)
    return group


def connected_faces(mesh: Mesh) -> IntArray:
    """Number the connected parts of a mesh, and return the part of each face, shape (F,).

    Args:
        mesh: the mesh.
    """
    inner = np.flatnonzero(mesh.twin != BORDER)
    return linked_groups(mesh.face_count, mesh.side_face[inner], mesh.side_face[mesh.twin[inner]])
