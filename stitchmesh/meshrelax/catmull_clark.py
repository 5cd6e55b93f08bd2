# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Catmull-Clark subdivision of polygon meshes, and the points of its limit surface.

One step turns every corner of the mesh into a quad; with face points F, edge points R and S the vertex itself:

    face point    mean of the face's vertices
    edge point    mean of the edge's two vertices and two face points; on a border the midpoint
    vertex point  (mean F + 2 mean midpoints + (n - 3) S) / n for n faces; on a border 1/8, 6/8, 1/8 along it

A border is a cubic B-spline curve of its own vertices. A vertex that only one face uses is a sharp corner of it, so
that a flat swatch keeps its corners. Everything follows the twins, never vertex numbers, so meshes whose sides share
both ends are refined like any other (Catmull and Clark 1978; borders as Biermann et al. 2000).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array, vstack

from stitchmesh.errors import MeshError
from stitchmesh.mesh import BORDER, FloatArray, IntArray, Mesh


def subdivide(mesh: Mesh) -> Mesh:
    """One Catmull-Clark step; the quad of corner ``c`` is face ``c``, the old vertices keep their numbers.

    Args:
        mesh: polygons of any size, not on a lattice.

    Returns:
        Quads whose control points are the vertex points, then the edge points, then the face points.

    Raises:
        MeshError: the mesh repeats on a lattice.
    """
    return refine(mesh, smooth_rule(mesh) @ mesh.vertices)


def refine(mesh: Mesh, vertices: FloatArray) -> Mesh:
    """The quads of one subdivision step at given places of its V + E + F vertices.

    Side 0 of the quad of corner ``c`` is the first half of side ``c``, side 3 the second half of the side before.
    """
    if mesh.lattice is not None:
        raise MeshError("subdivision: got a mesh on a lattice; expected a surface that does not repeat")
    corner, edge = np.arange(mesh.side_count), len(mesh.vertices) + mesh.side_edge
    face = len(mesh.vertices) + len(mesh.edge_side) + mesh.side_face
    corners = np.stack([mesh.face_vertex, edge, face, edge[mesh.side_previous]], axis=1)
    before = mesh.twin[mesh.side_previous]
    first = np.where(mesh.twin == BORDER, BORDER, 4 * mesh.side_next[mesh.twin] + 3)
    last = np.where(before == BORDER, BORDER, 4 * before)
    twin = np.stack([first, 4 * mesh.side_next + 2, 4 * mesh.side_previous + 1, last], axis=1)
    return Mesh(vertices, np.append(4 * corner, 4 * len(corner)), corners.ravel(), twin.ravel())


def linear_rule(mesh: Mesh) -> csr_array:
    """Midpoints instead of smoothing: the refined mesh stays on the input polygons, shape (V + E + F, V)."""
    count = len(mesh.vertices)
    keep = csr_array((np.ones(count), np.arange(count), np.arange(count + 1)), shape=(count, count))
    return vstack([keep, _midpoints(mesh), _face_means(mesh)], format="csr")


def smooth_rule(mesh: Mesh) -> csr_array:
    """Weights of one Catmull-Clark step, shape (V + E + F, V)."""
    faces, midpoints = _face_means(mesh), _midpoints(mesh)
    sides = np.arange(mesh.side_count)
    face_of_edge = _scatter(mesh.side_edge, mesh.side_face, np.ones(len(sides)), (midpoints.shape[0], faces.shape[0]))
    inner = (mesh.twin[mesh.edge_side] != BORDER).astype(np.float64)
    edges = _rows(1.0 - 0.5 * inner) @ midpoints + _rows(0.25 * inner) @ face_of_edge @ faces
    return vstack([_vertex_rule(mesh, faces, midpoints), edges, faces], format="csr")


def limit_rule(mesh: Mesh) -> csr_array:
    """Weights that move the vertices of a quad mesh to their places on the limit surface, shape (V, V).

    Inside (n^2 S + 4 sum of neighbours + sum of opposite vertices) / (n (n + 5)) for n faces (Halstead et al. 1993);
    on a border 1/6, 4/6, 1/6 along it; corners stay.
    """
    count = len(mesh.vertices)
    valence = _valence(mesh).astype(np.float64)
    along, opposite = mesh.side_next, mesh.side_next[mesh.side_next]
    inner = 1.0 - border_vertices(mesh)
    scale = _rows(inner / (valence * (valence + 5.0)))
    ones = np.ones(mesh.side_count)
    near = _scatter(mesh.face_vertex, mesh.face_vertex[along], ones, (count, count))
    far = _scatter(mesh.face_vertex, mesh.face_vertex[opposite], ones, (count, count))
    return (scale @ (_rows(valence**2) + 4.0 * near + far) + _border_rule(mesh, 1.0 / 6.0)).tocsr()


def border_vertices(mesh: Mesh) -> NDArray[np.bool_]:
    """Vertices on a border, shape (V,)."""
    on_border = np.zeros(len(mesh.vertices), dtype=bool)
    on_border[mesh.face_vertex[mesh.twin == BORDER]] = True
    return on_border


def corner_vertices(mesh: Mesh) -> NDArray[np.bool_]:
    """Border vertices that only one face uses: the corners of a swatch, shape (V,)."""
    return border_vertices(mesh) & (_valence(mesh) == 1)


def refine_surface(mesh: Mesh, spacing: float, max_faces: int) -> tuple[Mesh, FloatArray, FloatArray]:
    """Subdivide until edges are short or the faces many.

    Args:
        mesh: the control polygons [cm].
        spacing: root mean square edge length to reach [cm].
        max_faces: the step that would exceed this number of quads is not taken; one step is always taken.

    Returns:
        The quads at the control points of the last level; their vertices on the limit surface [cm], shape (V, 3);
        and the same vertices on the input polygons, where the midpoint rule puts them [cm], shape (V, 3).
    """
    flat = linear_rule(mesh) @ mesh.vertices
    fine = subdivide(mesh)
    while _edge_length(fine) > spacing and fine.side_count <= max_faces:
        flat = linear_rule(fine) @ flat
        fine = subdivide(fine)
    return fine, limit_rule(fine) @ fine.vertices, flat


def _edge_length(mesh: Mesh) -> float:
    return float(np.sqrt(np.mean(mesh.side_length**2)))


def _vertex_rule(mesh: Mesh, faces: csr_array, midpoints: csr_array) -> csr_array:
    """(mean F + 2 mean midpoints + (n - 3) S) / n inside, the cubic B-spline along borders."""
    count, ones = len(mesh.vertices), np.ones(mesh.side_count)
    valence = _valence(mesh).astype(np.float64)
    around_faces = _scatter(mesh.face_vertex, mesh.side_face, ones, (count, faces.shape[0])) @ faces
    around_edges = _scatter(mesh.face_vertex, mesh.side_edge, ones, (count, midpoints.shape[0])) @ midpoints
    inner = 1.0 - border_vertices(mesh)
    means = _rows(inner / valence**2) @ (around_faces + 2.0 * around_edges)
    return means + _rows(inner * (valence - 3.0) / valence) + _border_rule(mesh, 1.0 / 8.0)


def _border_rule(mesh: Mesh, neighbour: float) -> csr_array:
    """Rows of the border vertices: each neighbour along the border weighs ``neighbour``; corners keep their place."""
    count = len(mesh.vertices)
    sides = np.flatnonzero(mesh.twin == BORDER)
    tail, head = mesh.face_vertex[sides], mesh.face_vertex[mesh.side_next[sides]]
    smooth = ~corner_vertices(mesh)
    row, column = np.concatenate([tail, head]), np.concatenate([head, tail])
    neighbours = _scatter(row, column, neighbour * smooth[row], (count, count))
    own = np.where(smooth, 1.0 - 2.0 * neighbour, 1.0) * border_vertices(mesh)
    return neighbours + _rows(own)


def _midpoints(mesh: Mesh) -> csr_array:
    edges = np.arange(len(mesh.edge_side))
    tail, head = mesh.face_vertex[mesh.edge_side], mesh.face_vertex[mesh.side_next[mesh.edge_side]]
    half = np.full(2 * len(edges), 0.5)
    return _scatter(np.tile(edges, 2), np.concatenate([tail, head]), half, (len(edges), len(mesh.vertices)))


def _face_means(mesh: Mesh) -> csr_array:
    weight = 1.0 / np.diff(mesh.face_start)
    shape = (mesh.face_count, len(mesh.vertices))
    return _scatter(mesh.side_face, mesh.face_vertex, weight[mesh.side_face], shape)


def _valence(mesh: Mesh) -> IntArray:
    """Number of faces around each vertex."""
    return np.bincount(mesh.face_vertex, minlength=len(mesh.vertices))


def _scatter(row: IntArray, column: IntArray, weight: FloatArray, shape: tuple[int, int]) -> csr_array:
    return coo_array((weight, (row, column)), shape=shape).tocsr()


def _rows(weight: FloatArray) -> csr_array:
    """A diagonal matrix: scales the rows of what follows."""
    count = len(weight)
    return csr_array((weight, np.arange(count), np.arange(count + 1)), shape=(count, count))
