# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a fabric lacks of its surface: borders, handles, and places where parts are joined.

Features that are smaller than a stitch are lost: a hole closes, or a narrow strap between two holes parts. The numbers
of parts, borders and handles describe a surface up to deformation, by its Euler characteristic.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import BORDER, Mesh


@dataclass(frozen=True)
class Topology:
    """Numbers that do not change when a surface is deformed."""

    parts: int
    """Number of connected parts."""
    borders: int
    """Number of borders."""
    handles: int
    """Number of handles; a torus has one."""


def topology(mesh: Mesh, tips: int = 0) -> Topology:
    """Count the parts, borders and handles of a mesh.

    Args:
        mesh: the mesh.
        tips: number of borders that count as closed, because a yarn is drawn through the loops there.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    sides = np.flatnonzero(mesh.twin != BORDER)
    pairs = mesh.side_face[sides], mesh.side_face[mesh.twin[sides]]
    graph = coo_array((np.ones(len(sides)), pairs), shape=(mesh.face_count,) * 2)
    parts = int(connected_components(graph.tocsr(), directed=False)[0])
    borders = len(mesh.boundary_loops) - tips
    euler = len(np.unique(mesh.face_vertex)) - len(mesh.edge_side) + mesh.face_count + tips
    return Topology(parts, borders, (2 * parts - borders - euler) // 2)


def lost_features(given: Topology, fabric: Topology) -> str | None:
    """Return one sentence that says what a fabric lacks of its surface, with a remedy; None if it lacks nothing.

    Args:
        given: numbers of the surface.
        fabric: numbers of the fabric, whose tips count as closed.
    """
    differences = [
        f"{number} {name}s instead of {wanted}" if number != 1 else f"1 {name} instead of {wanted}"
        for name, number, wanted in (
            ("part", fabric.parts, given.parts),
            ("border", fabric.borders, given.borders),
            ("handle", fabric.handles, given.handles),
        )
        if number != wanted
    ]
    if not differences:
        return None
    return (
        f"the fabric has {', '.join(differences)}: a hole or a join of the mesh is finer than its stitches, or rows "
        "end all around it; choose a smaller stitch, or mark the border as begin or end"
    )
