# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A surface of triangles, fine enough for a function from which rows are read.

The faces of a mesh are divided into triangles. Edges longer than a given length are halved until none is left. An edge
is divided for both of its triangles at once, so that the surface stays closed along it. New vertices lie on the given
faces: the surface keeps its shape.

Gradients of functions that are linear on each triangle, and the stiffness matrix of the Laplacian (cotangent formula),
follow Pinkall and Polthier 1993.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.mesh.connectivity import linked_groups
from stitchmesh.mesh.face_triangles import face_triangles

if TYPE_CHECKING:
    from scipy.sparse import csr_array

MOST_TRIANGLES = 400_000
"""Edges are not divided any more beyond this number of triangles; this limits the time to about a minute."""


@dataclass(frozen=True, eq=False)
class TriangleSurface:
    """Triangles with the tables that a function on them needs."""

    vertices: FloatArray
    """Positions [cm], shape (V, 3)."""
    triangles: IntArray
    """Vertices of each triangle, anticlockwise seen from outside, shape (T, 3)."""

    @cached_property
    def mesh(self) -> Mesh:
        """The same triangles as a mesh."""
        return Mesh.from_polygons(self.vertices, self.triangles.tolist())

    @cached_property
    def borders(self) -> tuple[IntArray, ...]:
        """Vertices of each border, in the order in which its triangles pass them."""
        return tuple(self.mesh.face_vertex[loop] for loop in self.mesh.boundary_loops)

    @cached_property
    def vector_area(self) -> FloatArray:
        """Area of each triangle times its normal [cm^2], shape (T, 3)."""
        a, b, c = (self.vertices[self.triangles[:, k]] for k in range(3))
        return 0.5 * np.cross(b - a, c - a)

    @cached_property
    def area(self) -> FloatArray:
        """Area of each triangle [cm^2], shape (T,)."""
        return np.linalg.norm(self.vector_area, axis=1)

    @cached_property
    def corner_gradients(self) -> FloatArray:
        """Gradient of the linear function that is 1 at one corner and 0 at the others [1/cm], shape (T, 3, 3)."""
        corner = self.vertices[self.triangles]
        opposite = np.roll(corner, -2, axis=1) - np.roll(corner, -1, axis=1)
        double = 2.0 * np.maximum(self.area, np.finfo(np.float64).tiny)
        normal = self.vector_area / np.maximum(self.area, np.finfo(np.float64).tiny)[:, None]
        return np.cross(normal[:, None, :], opposite) / double[:, None, None]

    @cached_property
    def vertex_area(self) -> FloatArray:
        """A third of the area of the triangles around each vertex [cm^2], shape (V,)."""
        total = np.bincount(self.triangles.ravel(), np.repeat(self.area / 3.0, 3), len(self.vertices))
        return np.asarray(total, dtype=np.float64)

    @cached_property
    def edges(self) -> IntArray:
        """The two vertices of each edge, the smaller first, shape (E, 2)."""
        ends = np.sort(np.stack([self.triangles, np.roll(self.triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
        return np.unique(ends, axis=0)

    @cached_property
    def edge_length(self) -> FloatArray:
        """Length of each edge [cm], shape (E,)."""
        return np.linalg.norm(np.diff(self.vertices[self.edges], axis=1)[:, 0], axis=1)

    @cached_property
    def edge_graph(self) -> csr_array:
        """Matrix of the lengths of the edges between vertices [cm], each once, shape (V, V)."""
        from scipy.sparse import coo_array

        return coo_array((self.edge_length, self.edges.T), shape=(len(self.vertices),) * 2).tocsr()

    def gradient(self, values: FloatArray) -> FloatArray:
        """Return the gradient on each triangle [1/cm], shape (T, 3), of values at the vertices, shape (V,)."""
        return np.einsum("tci,tc->ti", self.corner_gradients, values[self.triangles])

    def divergence(self, field: FloatArray, weight: FloatArray | None = None) -> FloatArray:
        """Return the sum over triangles of gradient . field x area at each vertex, shape (V,).

        Args:
            field: a vector on each triangle, shape (T, 3).
            weight: weight of each triangle, shape (T,); 1 if None.
        """
        share = self.area if weight is None else self.area * weight
        flux = np.einsum("tci,ti->tc", self.corner_gradients, field) * share[:, None]
        total = np.bincount(self.triangles.ravel(), flux.ravel(), len(self.vertices))
        return np.asarray(total, dtype=np.float64)

    def stiffness(self, weight: FloatArray | None = None) -> csr_array:
        """Return the matrix of the integral of the product of two gradients, shape (V, V).

        Args:
            weight: weight of each triangle, shape (T,); 1 if None.
        """
        from scipy.sparse import coo_array

        share = self.area if weight is None else self.area * weight
        local = np.einsum("tai,tbi->tab", self.corner_gradients, self.corner_gradients) * share[:, None, None]
        row = np.repeat(self.triangles, 3, axis=1).ravel()
        column = np.tile(self.triangles, (1, 3)).ravel()
        return coo_array((local.ravel(), (row, column)), shape=(len(self.vertices),) * 2).tocsr()


def triangle_surface(mesh: Mesh, longest_edge: float) -> TriangleSurface:
    """Divide the faces of a mesh into triangles whose edges are at most ``longest_edge`` long.

    Args:
        mesh: the mesh.
        longest_edge: length of an edge that is not divided any more [cm].
    """
    return divided(in_triangles(mesh), longest_edge)


def in_triangles(mesh: Mesh) -> TriangleSurface:
    """Divide the faces of a mesh into triangles."""
    return TriangleSurface(mesh.vertices, mesh.face_vertex[face_triangles(mesh).corners])


def divided(surface: TriangleSurface, longest_edge: float) -> TriangleSurface:
    """Divide triangles until their edges are at most ``longest_edge`` long [cm], or there are ``MOST_TRIANGLES``."""
    vertices, triangles = surface.vertices, surface.triangles
    while len(triangles) < MOST_TRIANGLES:
        halved = _halve_long_edges(vertices, triangles, longest_edge)
        if halved is None:
            break
        vertices, triangles = halved
    return TriangleSurface(vertices, triangles)


def connected_parts(surface: TriangleSurface) -> list[tuple[TriangleSurface, IntArray]]:
    """Return the connected parts of a surface, each with the vertices of the surface that are its vertices."""
    part = linked_groups(len(surface.vertices), *surface.edges.T)
    found = []
    for number in range(int(part.max(initial=-1)) + 1):
        vertices = np.flatnonzero(part == number)
        place = np.full(len(part), -1)
        place[vertices] = np.arange(len(vertices))
        triangles = surface.triangles[part[surface.triangles[:, 0]] == number]
        found.append((TriangleSurface(surface.vertices[vertices], place[triangles]), vertices))
    return found


def without_fine_features(surface: TriangleSurface, size: float) -> TriangleSurface:
    """Return the surface without dents and ridges that are finer than a length; borders stay where they are.

    A fabric spans features that are finer than its stitches. The positions follow from one implicit step of diffusion
    over the time t = ``size``^2, in which a place of mean curvature H moves by about 2 H t (Desbrun, Meyer, Schroeder
    and Barr, *Implicit fairing of irregular meshes*, 1999).

    Args:
        surface: the surface.
        size: the length [cm].
    """
    from scipy.sparse import diags_array
    from scipy.sparse.linalg import splu

    fixed = np.zeros(len(surface.vertices), dtype=bool)
    fixed[np.concatenate([*surface.borders, np.zeros(0, dtype=np.int64)])] = True
    free = np.flatnonzero(~fixed)
    matrix = (diags_array(surface.vertex_area) + size**2 * surface.stiffness()).tocsr()
    right = surface.vertex_area[:, None] * surface.vertices - matrix[:, np.flatnonzero(fixed)] @ surface.vertices[fixed]
    vertices = surface.vertices.copy()
    vertices[free] = splu(matrix[free][:, free].tocsc()).solve(right[free])
    return TriangleSurface(vertices, surface.triangles)


def _halve_long_edges(
    vertices: FloatArray, triangles: IntArray, longest_edge: float
) -> tuple[FloatArray, IntArray] | None:
    """Divide all edges that are too long once; None if there are none."""
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)
    edges, edge_of_side = np.unique(np.sort(ends.reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    length = np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
    long = length > longest_edge
    if not long.any():
        return None
    middle = np.where(long, len(vertices) + np.cumsum(long) - 1, -1)[edge_of_side.reshape(-1, 3)]
    points = np.concatenate([vertices, vertices[edges[long]].mean(axis=1)])
    return points, _divide_triangles(points, triangles, middle)


def _divide_triangles(points: FloatArray, triangles: IntArray, middle: IntArray) -> IntArray:
    """Divide triangles by the middles of their sides, -1 where a side is kept, shape (T, 3)."""
    cut = middle >= 0
    count = cut.sum(axis=1)
    # Each triangle is turned so that its only divided side, or its only kept side, is the first.
    turn = np.where(count == 1, cut.argmax(axis=1), np.where(count == 2, (~cut).argmax(axis=1), 0))
    place = (turn[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(triangles, place, axis=1).T
    ab, bc, ca = np.take_along_axis(middle, place, axis=1).T
    one, two, three = count == 1, count == 2, count == 3
    short = two & (np.linalg.norm(points[bc] - points[a], axis=1) <= np.linalg.norm(points[ca] - points[b], axis=1))
    long = two & ~short
    parts = [
        (count == 0, (a, b, c)),
        (one, (a, ab, c)), (one, (ab, b, c)),
        (two, (bc, c, ca)),
        (short, (a, b, bc)), (short, (a, bc, ca)),
        (long, (a, b, ca)), (long, (b, bc, ca)),
        (three, (a, ab, ca)), (three, (ab, b, bc)), (three, (ca, bc, c)), (three, (ab, bc, ca)),
    ]  # fmt: skip
    return np.concatenate([np.stack([corner[chosen] for corner in corners], axis=1) for chosen, corners in parts])
