# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Meshes cut into soups, and what of a mesh does not depend on the order of its faces."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import Mesh
from stitchmesh.mesh.face_triangles import face_triangles
from stitchmesh.mesh.repair import Repaired, repair_mesh
from tests.gallery import torus


def triangles(mesh: Mesh) -> list[list[int]]:
    """Vertices of the triangles of all faces."""
    return mesh.face_vertex[face_triangles(mesh).corners].tolist()


def cut(vertices: np.ndarray, faces: list[list[int]]) -> tuple[np.ndarray, list[list[int]]]:
    """The same faces, each with vertices of its own, as in an STL file."""
    ends = np.cumsum([len(face) for face in faces])
    own = [list(range(end - len(face), end)) for face, end in zip(faces, ends.tolist(), strict=True)]
    return np.asarray(vertices, dtype=float)[np.concatenate(faces)], own


def euler(mesh: Mesh) -> int:
    """Euler characteristic."""
    return len(mesh.vertices) - len(mesh.edge_side) + mesh.face_count


def shape(mesh: Mesh) -> tuple[int, int, int, list[int]]:
    """Numbers of vertices and faces, Euler characteristic, and the numbers of sides of the borders."""
    return len(mesh.vertices), mesh.face_count, euler(mesh), sorted(len(loop) for loop in mesh.boundary_loops)


def same(first: Mesh, second: Mesh) -> bool:
    """Whether two meshes have exactly equal vertices and faces in the same order."""
    names = ("vertices", "face_start", "face_vertex", "twin")
    return all(np.array_equal(getattr(first, name), getattr(second, name)) for name in names)


def volume(mesh: Mesh) -> float:
    """Signed volume of a closed mesh [cm^3]."""
    return float(np.einsum("fi,fi->", mesh.corner_position[mesh.face_start[:-1]], mesh.face_vector_area)) / 3.0


def actions(repaired: Repaired) -> dict[str, int]:
    """Number of changes of each name."""
    return {action.name: action.count for action in repaired.actions}


def ring() -> tuple[np.ndarray, list[list[int]]]:
    """Vertices and triangles of a closed surface."""
    mesh = torus(12, 20)
    return mesh.vertices, triangles(mesh)


def unchanged(mesh: Mesh) -> bool:
    """Whether a repair leaves a mesh as it is, and says so."""
    repaired = repair_mesh(mesh.vertices, mesh.polygons)
    return same(repaired.mesh, mesh) and repaired.actions == ()
