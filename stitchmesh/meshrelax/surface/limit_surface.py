# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The surface to which a fabric is attached: fine triangles whose vertices are on the Catmull-Clark limit surface.

Its borders are closed polylines, parametrized by arc length.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.compute.threads import each_block
from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.meshrelax.placement import VERTICES_OF_BLOCK
from stitchmesh.meshrelax.surface.catmull_clark import refine_surface


@dataclass(frozen=True, eq=False)
class BorderCurve:
    """One closed border, on the limit surface and on the input polygons."""

    points: FloatArray
    """Vertices of the border on the limit surface [cm], shape (N, 3)."""
    flat_points: FloatArray
    """The same vertices on the input polygons [cm], shape (N, 3)."""

    @cached_property
    def spans(self) -> FloatArray:
        """Vector from each vertex to the next [cm], shape (N, 3)."""
        return np.roll(self.points, -1, axis=0) - self.points

    @cached_property
    def arc(self) -> FloatArray:
        """Arc length at each vertex, and the length of the whole border at the end [cm], shape (N + 1,)."""
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(self.spans, axis=1))])

    def locate(self, targets: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Find the arc lengths of points near the border of the input polygons, and their distances from that border.

        Args:
            targets: points on or near the border of the input polygons [cm], shape (M, 3).

        Returns:
            Arc lengths on the limit surface [cm], shape (M,), and distances to the border of the input polygons [cm],
            shape (M,).
        """
        count = len(self.points)
        # The closest segment is searched at this number of nearest vertices of the polyline.
        near = cKDTree(self.flat_points).query(targets, k=min(4, count))[1].reshape(len(targets), -1)
        segment = np.concatenate([near, (near - 1) % count], axis=1)
        start = self.flat_points[segment]
        span = self.flat_points[(segment + 1) % count] - start
        along = np.einsum("mci,mci->mc", targets[:, None] - start, span)
        along = np.clip(along / np.maximum(np.einsum("mci,mci->mc", span, span), np.finfo(float).tiny), 0.0, 1.0)
        distance = np.linalg.norm(targets[:, None] - start - along[:, :, None] * span, axis=2)
        best = (np.arange(len(targets)), distance.argmin(axis=1))
        segment, along = segment[best], along[best]
        return self.arc[segment] + along * np.diff(self.arc)[segment], distance[best]

    def distance(self, targets: FloatArray) -> float:
        """Root mean square distance of points from the vertices of the border on the limit surface [cm].

        Args:
            targets: points [cm], shape (M, 3).
        """
        return float(np.sqrt(np.mean(cKDTree(self.points).query(targets)[0] ** 2)))

    @cached_property
    def tangents(self) -> FloatArray:
        """Unit tangent at each vertex, the mean of the directions of its two segments, shape (N, 3)."""
        length = np.diff(self.arc)[:, None]
        along = self.spans / np.where(length > 0.0, length, 1.0)
        return _directions(along + np.roll(along, 1, axis=0), along)

    def at(self, arc: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Evaluate the border at arc lengths; arc lengths beyond the ends wrap around.

        Tangents are interpolated between vertices. The directions of the segments would jump at the vertices, and then
        there might be no place where the forces on a vertex along the border balance.

        Args:
            arc: arc lengths [cm], shape (M,).

        Returns:
            Points [cm], unit tangents, and curvature vectors (derivatives of the tangent) [1/cm], shape (M, 3) each.
        """
        arc = np.mod(arc, self.arc[-1])
        segment = np.clip(np.searchsorted(self.arc, arc, side="right") - 1, 0, len(self.points) - 1)
        length = np.diff(self.arc)[segment][:, None]
        length = np.where(length > 0.0, length, 1.0)
        part = (arc - self.arc[segment])[:, None] / length
        first, last = self.tangents[segment], np.roll(self.tangents, -1, axis=0)[segment]
        tangent = _directions((1.0 - part) * first + part * last, first)
        return self.points[segment] + part * self.spans[segment], tangent, (last - first) / length


def _directions(vectors: FloatArray, instead: FloatArray) -> FloatArray:
    """Return the unit vectors along vectors, and other vectors in the place of zero vectors, shape (n, 3)."""
    return np.where(vectors.any(axis=1, keepdims=True), unit_vectors(vectors), instead)


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
        position, normal, vertex_normals = np.empty_like(weights), np.empty_like(weights), self.normals

        def interpolate(some: slice) -> None:
            corners, own = self.triangles[triangle[some]], weights[some]
            position[some] = np.einsum("nc,nci->ni", own, self.vertices[corners])
            normal[some] = unit_vectors(np.einsum("nc,nci->ni", own, vertex_normals[corners]))

        each_block(interpolate, len(triangle), VERTICES_OF_BLOCK)
        return position, normal

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
