# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The features of a triangle mesh: the outward direction of each feature, and its weight in sums.

A triangle has seven features: itself, its edges opposite to corners 0, 1, 2, and these corners. The outward direction
of a face is its normal. The outward direction of an edge is the sum of the normals of its two faces. The outward
direction of a corner is the sum of the normals of the faces around it, each weighted by its angle at the corner. The
sign of (place - nearest point) . outward then distinguishes inside from outside everywhere around a closed surface
(Baerentzen and Aanaes 2005, "Signed distance computation using the angle weighted pseudonormal", theorem 1). A border
has no inside, so its edges and corners have no direction.

A sum over triangles of a function of their distances counts a point on an edge twice, and a point at a corner once for
each triangle around it. If edges and corners are added with the shares

    edge:  1 - (its triangles),        corner:  1 - (its triangles) - (sum of the shares of its edges)

every point counts once (inclusion and exclusion). The shares of an inner edge and its corners are -1 and 1; at a border
they are 0 and 0. The share of each edge and corner is assigned to one of its triangles.

Polygons are divided into triangles by their ears (``face_triangles``). Vertices at one place count as one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.mesh.face_triangles import face_triangles


@dataclass(frozen=True, eq=False)
class MeshFeatures:
    """Triangles and their features; in each list of three, the edge number k lies opposite to corner k."""

    corners: FloatArray
    """Corners of the triangles [cm], shape (T, 3, 3)."""
    outward: FloatArray
    """Unit vectors out of each triangle's seven features, zero where there is no direction, shape (T, 7, 3)."""
    shares: FloatArray
    """Shares of each triangle's edges and of its corners, zero if another triangle has the share, shape (T, 2, 3)."""


@dataclass(frozen=True, eq=False)
class FeatureTopology:
    """Which features the triangles of a mesh share; it does not change while a mesh is deformed."""

    corner: IntArray
    """Vertices of the mesh at the corners of the triangles, shape (T, 3)."""
    face: IntArray
    """Face of the mesh that each triangle covers, shape (T,)."""
    place: IntArray
    """Numbers of the places of the corners, equal for vertices at one place, shape (T, 3)."""
    edge: IntArray
    """Edge opposite to each corner, shape (T, 3)."""
    ends: IntArray
    """Places at the two ends of these edges, shape (T, 3, 2)."""


def feature_topology(mesh: Mesh) -> FeatureTopology:
    """Return the triangles into which a mesh is divided, without degenerate ones with two corners at one place."""
    found = face_triangles(mesh)
    corner = mesh.face_vertex[found.corners]
    place = np.unique(mesh.vertices[corner].reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1, 3)
    distinct = (place != np.roll(place, 1, axis=1)).all(axis=1)
    corner, place = corner[distinct], place[distinct]
    ends = np.stack([np.roll(place, -1, axis=1), np.roll(place, -2, axis=1)], axis=2)
    key = ends.min(axis=2) * (place.max() + 1) + ends.max(axis=2)
    edge = np.unique(key, return_inverse=True)[1].reshape(key.shape)
    return FeatureTopology(corner, found.face[distinct], place, edge, ends)


def mesh_features(mesh: Mesh) -> MeshFeatures:
    """The features of a mesh."""
    return features_at(feature_topology(mesh), mesh.vertices)


def features_at(topology: FeatureTopology, vertices: FloatArray) -> MeshFeatures:
    """Return the features of a mesh with its vertices at other places [cm], shape (V, 3)."""
    corners = vertices[topology.corner]
    shares = _shares(topology.place, topology.edge, topology.ends)
    return MeshFeatures(corners, _outward(corners, topology.place, topology.edge, topology.ends), shares)


def enclosed_volume(mesh: Mesh) -> float:
    """Volume inside a closed surface [cm^3]; negative if its faces look inwards."""
    corner = mesh.face_vertex[face_triangles(mesh).corners]
    a, b, c = (mesh.vertices - mesh.vertices.mean(axis=0))[corner].transpose(1, 0, 2)
    return float(np.einsum("td,td->", a, np.cross(b, c)) / 6)


def _outward(corners: FloatArray, vertex: IntArray, edge: IntArray, ends: IntArray) -> FloatArray:
    after, before = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    cross, dot = np.cross(after, before), np.einsum("tkd,tkd->tk", after, before)
    angle = np.arctan2(np.linalg.norm(cross, axis=2), dot)
    normal = _unit(cross[:, 0] / np.einsum("tkd,tkd->t", after, after)[:, None])
    edge_sum = _sums(edge, np.repeat(normal[:, None], 3, axis=1))
    vertex_sum = _sums(vertex, normal[:, None] * angle[:, :, None])
    border = np.bincount(edge.ravel())[edge] == 1
    edge_sum[edge[border]] = 0.0
    vertex_sum[ends[border].ravel()] = 0.0
    return _unit(np.concatenate([normal[:, None], edge_sum[edge], vertex_sum[vertex]], axis=1))


def _shares(vertex: IntArray, edge: IntArray, ends: IntArray) -> FloatArray:
    of_edge = 1.0 - np.bincount(edge.ravel())
    first_edge, first_vertex = (np.unique(number, return_index=True)[1] for number in (edge, vertex))
    around = np.bincount(ends.reshape(-1, 2)[first_edge].ravel(), weights=np.repeat(of_edge, 2))
    shares = np.zeros((2, vertex.size))
    shares[0, first_edge] = of_edge
    shares[1, first_vertex] = 1.0 - np.bincount(vertex.ravel()) - around
    return shares.reshape(2, -1, 3).transpose(1, 0, 2)


def _sums(group: IntArray, vectors: FloatArray) -> FloatArray:
    """Sum of the vectors of each group, shape (groups, 3)."""
    flat = vectors.reshape(-1, 3)
    return np.stack([np.bincount(group.ravel(), weights=flat[:, axis]) for axis in range(3)], axis=1)


def _unit(vectors: FloatArray) -> FloatArray:
    """Vectors of length one, zero where they cancel."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(length > 1e-12, vectors / np.maximum(length, 1e-300), 0.0)
