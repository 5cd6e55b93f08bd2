# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Catmull-Clark subdivision of polygon meshes, and the points of its limit surface.

One step makes a quad of every corner of the mesh. F denotes face points and S the old vertex:

    face point    mean of the vertices of the face
    edge point    mean of the two vertices and the two face points of the edge; on a border the midpoint
    vertex point  (mean F + 2 mean midpoints + (n - 3) S) / n for n faces; on a border 1/8, 6/8, 1/8 along the border

A border is the cubic B-spline curve of its own vertices. A vertex of only one face is a sharp corner of the border, so
that a flat swatch keeps its corners. Connectivity follows from the twins and never from vertex numbers, so that the
rules also hold for meshes with two sides between the same two vertices. Sources: Catmull and Clark 1978; for borders,
Biermann et al. 2000.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array, vstack

from stitchmesh.errors import MeshError
from stitchmesh.mesh import BORDER, FloatArray, IntArray, Mesh


def subdivide(mesh: Mesh) -> Mesh:
    """Apply one Catmull-Clark step; the quad of corner ``c`` is face ``c``, and old vertices keep their numbers.

    Args:
        mesh: polygons with any number of corners, without a lattice.

    Returns:
        Quads whose vertices are the vertex points, then the edge points, then the face points.

    Raises:
        MeshError: the mesh has a lattice.
    """
    return refine(mesh, smooth_rule(mesh) @ mesh.vertices)


def refine(mesh: Mesh, vertices: FloatArray) -> Mesh:
    """Return the quads of one subdivision step for given positions of its vertices.

    Side 0 of the quad of corner ``c`` is the first half of side ``c``, and side 3 is the second half of the side before
    side ``c``.

    Args:
        mesh: polygons with any number of corners, without a lattice.
        vertices: positions of the vertex points, edge points and face points [cm], shape (V + E + F, 3).

    Raises:
        MeshError: the mesh has a lattice.
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
    """Return the weights of one step without smoothing, (V + E + F, V), which keeps the mesh on the input polygons.

    Old vertices keep their positions, and the edge points are midpoints.
    """
    count = len(mesh.vertices)
    keep = csr_array((np.ones(count), np.arange(count), np.arange(count + 1)), shape=(count, count))
    return vstack([keep, _midpoints(mesh), _face_means(mesh)], format="csr")


def smooth_rule(mesh: Mesh) -> csr_array:
    """Return the weights of one Catmull-Clark step, shape (V + E + F, V)."""
    faces, midpoints = _face_means(mesh), _midpoints(mesh)
    sides = np.arange(mesh.side_count)
    face_of_edge = _scatter(mesh.side_edge, mesh.side_face, np.ones(len(sides)), (midpoints.shape[0], faces.shape[0]))
    inner = (mesh.twin[mesh.edge_side] != BORDER).astype(np.float64)
    edges = _rows(1.0 - 0.5 * inner) @ midpoints + _rows(0.25 * inner) @ face_of_edge @ faces
    return vstack([_vertex_rule(mesh, faces, midpoints), edges, faces], format="csr")


def limit_rule(mesh: Mesh) -> csr_array:
    """Return the weights of the limit points of the vertices of a quad mesh, shape (V, V).

    The limit point of an inner vertex S with n faces is (n^2 S + 4 sum of neighbours + sum of opposite vertices) /
    (n (n + 5)) (Halstead et al. 1993). On a border the weights are 1/6, 4/6, 1/6 along the border. Corners do not move.
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
    """Return whether each vertex is on a border, shape (V,)."""
    on_border = np.zeros(len(mesh.vertices), dtype=bool)
    on_border[mesh.face_vertex[mesh.twin == BORDER]] = True
    return on_border


def corner_vertices(mesh: Mesh) -> NDArray[np.bool_]:
    """Return whether each vertex is a border vertex of only one face, like the corner of a swatch, shape (V,)."""
    return border_vertices(mesh) & (_valence(mesh) == 1)


def refine_surface(mesh: Mesh, spacing: float, max_faces: int) -> tuple[Mesh, FloatArray, FloatArray]:
    """Subdivide until edges are short enough or the number of faces reaches its limit.

    Args:
        mesh: the control polygons [cm].
        spacing: root mean square edge length at which subdivision stops [cm].
        max_faces: largest number of quads; at least one step is always applied.

    Returns:
        The quads of the last level; their vertices on the limit surface [cm], shape (V, 3); and the same vertices on
        the input polygons by ``linear_rule`` [cm], shape (V, 3).
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
    """Weights of the vertex points: (mean F + 2 mean midpoints + (n - 3) S) / n, on borders the cubic B-spline."""
    count, ones = len(mesh.vertices), np.ones(mesh.side_count)
    valence = _valence(mesh).astype(np.float64)
    around_faces = _scatter(mesh.face_vertex, mesh.side_face, ones, (count, faces.shape[0])) @ faces
    around_edges = _scatter(mesh.face_vertex, mesh.side_edge, ones, (count, midpoints.shape[0])) @ midpoints
    inner = 1.0 - border_vertices(mesh)
    means = _rows(inner / valence**2) @ (around_faces + 2.0 * around_edges)
    return means + _rows(inner * (valence - 3.0) / valence) + _border_rule(mesh, 1.0 / 8.0)


def _border_rule(mesh: Mesh, neighbour: float) -> csr_array:
    """Weights of border vertices: ``neighbour`` for each neighbour along the border; corners keep their positions."""
    count = len(mesh.vertices)
    sides = np.flatnonzero(mesh.twin == BORDER)
    tail, head = mesh.face_vertex[sides], mesh.face_vertex[mesh.side_next[sides]]
    smooth = ~corner_vertices(mesh)
    row, column = np.concatenate([tail, head]), np.concatenate([head, tail])
    neighbours = _scatter(row, column, neighbour * smooth[row], (count, count))
    own = np.where(smooth, 1.0 - 2.0 * neighbour, 1.0) * border_vertices(mesh)
    return neighbours + _rows(own)


def _midpoints(mesh: Mesh) -> csr_array:
    """Weights of the midpoints of edges, shape (E, V)."""
    edges = np.arange(len(mesh.edge_side))
    tail, head = mesh.face_vertex[mesh.edge_side], mesh.face_vertex[mesh.side_next[mesh.edge_side]]
    half = np.full(2 * len(edges), 0.5)
    return _scatter(np.tile(edges, 2), np.concatenate([tail, head]), half, (len(edges), len(mesh.vertices)))


def _face_means(mesh: Mesh) -> csr_array:
    """Weights of the face points, shape (F, V)."""
    weight = 1.0 / np.diff(mesh.face_start)
    shape = (mesh.face_count, len(mesh.vertices))
    return _scatter(mesh.side_face, mesh.face_vertex, weight[mesh.side_face], shape)


def _valence(mesh: Mesh) -> IntArray:
    """Number of faces around each vertex, shape (V,)."""
    return np.bincount(mesh.face_vertex, minlength=len(mesh.vertices))


def _scatter(row: IntArray, column: IntArray, weight: FloatArray, shape: tuple[int, int]) -> csr_array:
    return coo_array((weight, (row, column)), shape=shape).tocsr()


def _rows(weight: FloatArray) -> csr_array:
    """Diagonal matrix, which scales the rows of the matrix to its right."""
    count = len(weight)
    return csr_array((weight, np.arange(count), np.arange(count + 1)), shape=(count, count))
