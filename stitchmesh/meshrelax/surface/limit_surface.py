# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The surface to which a fabric is attached: fine triangles whose vertices are on the Catmull-Clark limit surface."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.mesh.unit_vectors import unit_vectors
from stitchmesh.meshrelax.surface.border_curve import BorderCurve
from stitchmesh.meshrelax.surface.catmull_clark import refine_surface


@dataclass(frozen=True, eq=False)
class LimitSurface:
    """Triangles on the limit surface, with the corresponding positions on the input polygons."""

    vertices: FloatArray
    """Vertices on the limit surface [cm], shape (V, 3)."""
    flat_vertices: FloatArray
    """The same vertices on the input polygons [cm], shape (V, 3)."""
    triangles: IntArray
    """Vertices of each triangle, shape (T, 3)."""
    borders: tuple[BorderCurve, ...]
    """Borders of the surface."""

    @cached_property
    def triangle_vector_area(self) -> FloatArray:
        """Area of each triangle times its normal [cm^2], shape (T, 3)."""
        a, b, c = (self.vertices[self.triangles[:, k]] for k in range(3))
        return 0.5 * np.cross(b - a, c - a)

    @cached_property
    def area(self) -> float:
        """Area of the surface [cm^2]."""
        return float(np.linalg.norm(self.triangle_vector_area, axis=1).sum())

    @cached_property
    def normals(self) -> FloatArray:
        """Unit normal of each vertex, shape (V, 3)."""
        vertex, weight = self.triangles.ravel(), np.repeat(self.triangle_vector_area, 3, axis=0)
        total: FloatArray = np.stack([np.bincount(vertex, weight[:, k], len(self.vertices)) for k in range(3)], axis=1)
        return unit_vectors(total)

    @cached_property
    def outward(self) -> FloatArray:
        """Direction off the surface at each border vertex, zero at inner vertices, shape (V, 3)."""
        start, end = self.triangles.ravel(), self.triangles[:, [1, 2, 0]].ravel()
        count = len(self.vertices)
        side = np.flatnonzero(~np.isin(start * count + end, end * count + start))
        start, end = start[side], end[side]
        off = np.cross(self.vertices[end] - self.vertices[start], self.triangle_vector_area[side // 3])
        off = unit_vectors(off)
        total = np.zeros_like(self.vertices)
        for vertex in (start, end):
            np.add.at(total, vertex, off)
        return total

    def outward_at(self, triangle: IntArray, weights: FloatArray, normal: FloatArray) -> FloatArray:
        """Return the unit direction along the surface and off its end for points on a border, zero for others, (N, 3).

        A point is on a border if all corners of its triangle with a nonzero weight are on a border. The search for
        closest points gives the other corners a weight of exactly zero.

        Args:
            triangle: triangle of each point, shape (N,).
            weights: weights of the corners of the triangle, shape (N, 3).
            normal: unit normal at each point, shape (N, 3).
        """
        corner = self.outward[self.triangles[triangle]]
        on_border = ((weights == 0.0) | corner.any(axis=2)).all(axis=1) & (weights == 0.0).any(axis=1)
        off = np.einsum("nc,nci->ni", weights, corner)
        off -= np.einsum("ni,ni->n", off, normal)[:, None] * normal
        return np.where(on_border[:, None], unit_vectors(off), 0.0)

    def evaluate(self, triangle: IntArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return points [cm] and unit normals of the limit surface at barycentric coordinates, shape (N, 3) each.

        Args:
            triangle: triangle of each point, shape (N,).
            weights: weights of the corners of the triangle, shape (N, 3).
        """
        corners = self.triangles[triangle]
        normal = np.einsum("nc,nci->ni", weights, self.normals[corners])
        return np.einsum("nc,nci->ni", weights, self.vertices[corners]), unit_vectors(normal)

    def shape_operator(self, triangle: IntArray, normal: FloatArray) -> FloatArray:
        """Return the symmetric shape operator (derivative of the normal) in triangles [1/cm], shape (N, 3, 3).

        Args:
            triangle: triangles, shape (N,).
            normal: unit normal, in whose direction the shape operator is zero, shape (N, 3).
        """
        corners = self.triangles[triangle]
        position, normals = self.vertices[corners], self.normals[corners]
        first, second = position[:, 1] - position[:, 0], position[:, 2] - position[:, 0]
        across = np.cross(first, second)
        square = np.einsum("ni,ni->n", across, across)[:, None]
        square = np.where(square > 0.0, square, 1.0)
        # Gradients of the barycentric coordinates of the second and the third corner.
        gradients = np.stack([np.cross(second, across) / square, np.cross(across, first) / square], axis=1)
        change = np.einsum("nci,ncj->nij", normals[:, 1:] - normals[:, :1], gradients)
        tangential = np.eye(3) - normal[:, :, None] * normal[:, None, :]
        return tangential @ (0.5 * (change + change.transpose(0, 2, 1))) @ tangential


def limit_surface(mesh: Mesh, spacing: float) -> LimitSurface:
    """Return the Catmull-Clark limit surface of a mesh as triangles.

    Args:
        mesh: polygons with any number of corners [cm].
        spacing: requested root mean square edge length [cm].

    Raises:
        MeshError: the mesh has a lattice.
    """
    # Largest number of quads, which limits the memory to 1 GB; edges may then be longer than requested.
    fine, vertices, flat = refine_surface(mesh, spacing, 400_000)
    quads = fine.face_vertex.reshape(-1, 4)
    triangles = np.stack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
    loops = [fine.face_vertex[loop] for loop in fine.boundary_loops]
    borders = tuple(BorderCurve(vertices[loop], flat[loop]) for loop in loops)
    return LimitSurface(vertices, flat, triangles, borders)
