# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Attachment of a fabric to its surface.

Inner vertices stay on the surface, border vertices stay on their border, and vertices at corners are fixed. A border of
the fabric may lie on no border of the surface, for example between two rows that an edit has separated; it may then
move anywhere on the surface. Held vertices do not move.

The first placement on the surface follows Yuksel et al. 2012, section 6.1. Vertices are projected onto the input
polygons, which are refined like the surface but not smoothed. The barycentric coordinates of the projections are then
evaluated on the limit surface.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.compute.threads import each_block
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.meshrelax.bobbles import NO_BOBBLES, Bobbles
from stitchmesh.meshrelax.placement import VERTICES_OF_BLOCK, SurfacePlacement
from stitchmesh.meshrelax.surface.catmull_clark import border_vertices
from stitchmesh.meshrelax.surface.closest_point import ClosestPoint
from stitchmesh.meshrelax.surface.limit_surface import LimitSurface

TINY = np.finfo(np.float64).tiny


@dataclass(frozen=True, eq=False)
class SurfaceAttachment:
    """A surface and the constraint of each vertex of a fabric."""

    surface: LimitSurface
    """The limit surface."""
    closest: ClosestPoint
    """Search for closest points on the triangles of the limit surface."""
    border: IntArray
    """Number of the border of each vertex, -1 for inner vertices, shape (V,)."""
    fixed: NDArray[np.bool_]
    """Whether each vertex is fixed, because it is at a corner or is held, shape (V,)."""

    stops_at_end: bool = False
    """Whether an inner vertex that a force presses against the end of the surface may move only along it."""

    def projector(self, placement: SurfacePlacement, force: FloatArray) -> FloatArray:
        """Return the projector onto the allowed directions of each vertex, shape (V, 3, 3), under forces (V, 3)."""
        allowed = np.empty_like(placement.shape)

        def project(some: slice) -> None:
            """Find the projectors of some vertices."""
            normal, tangent, outward = placement.normal[some], placement.tangent[some], placement.outward[some]
            inner = np.eye(3) - normal[:, :, None] * normal[:, None, :]
            along = tangent[:, :, None] * tangent[:, None, :]
            own = np.where((self.border[some] >= 0)[:, None, None], along, inner)
            if self.stops_at_end:
                pressed = np.einsum("vi,vi->v", force[some], outward) > 0.0
                own = own - np.einsum("v,vi,vj->vij", pressed, outward, outward)
            allowed[some] = np.where(self.fixed[some][:, None, None], 0.0, own)

        each_block(project, len(allowed), VERTICES_OF_BLOCK)
        return allowed

    def within(self) -> SurfaceAttachment:
        """Return the same attachment with ``stops_at_end``."""
        return replace(self, stops_at_end=True)

    def turning_stiffness(self, placement: SurfacePlacement, force: FloatArray) -> FloatArray:
        """Return the turning stiffness of each vertex [1/cm], shape (V, 3, 3), under forces of shape (V, 3)."""
        return turning_stiffness(placement, force)

    def move(self, placement: SurfacePlacement, step: FloatArray, stride: float) -> SurfacePlacement:
        """Return the placement after a step along the surface.

        The step is divided into parts that are so short that the projection does not jump to another part of the
        surface.

        Args:
            placement: placement before the step.
            step: allowed displacement of each vertex [cm], shape (V, 3).
            stride: largest distance between two projections [cm].
        """
        strides = max(1, int(np.ceil(np.linalg.norm(step, axis=1).max() / stride)))
        position, normal, part = placement.position, placement.normal, step / strides
        length = np.linalg.norm(part, axis=1, keepdims=True)
        for _ in range(strides):
            found = self.closest.find(position + part + self._leaning(placement, part), normal)
            position, normal = self.surface.evaluate(*found)
            position = np.where(self.fixed[:, None], placement.position, position)
            turned = part - np.einsum("vi,vi->v", part, normal)[:, None] * normal
            part = turned * (length / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), TINY))
        arc = placement.arc + np.einsum("vi,vi->v", step, placement.tangent)
        return self.place(*found, position, normal, arc)

    def place(
        self, triangle: IntArray, weights: FloatArray, position: FloatArray, normal: FloatArray, arc: FloatArray
    ) -> SurfacePlacement:
        """Return the placement of vertices whose triangles on the surface are known.

        Args:
            triangle: triangle of each vertex, shape (V,).
            weights: barycentric weights of each vertex in its triangle, shape (V, 3).
            position: position of each inner vertex on its triangle [cm], shape (V, 3).
            normal: unit normal of the surface at each vertex, shape (V, 3).
            arc: arc length of each border vertex [cm], which determines its position, shape (V,).
        """
        shape = np.zeros((len(normal), 3, 3))

        def curve(some: slice) -> None:
            own = np.flatnonzero(self.border[some] < 0) + some.start
            shape[own] = self.surface.shape_operator(triangle[own], normal[own])

        each_block(curve, len(shape), VERTICES_OF_BLOCK)
        position, tangent, curvature = position.copy(), np.zeros_like(position), np.zeros_like(position)
        for number, border in enumerate(self.surface.borders):
            members = np.flatnonzero(self.border == number)
            position[members], tangent[members], curvature[members] = border.at(arc[members])
        tangent[self.fixed] = 0.0
        inner = (self.border < 0) & ~self.fixed & self.stops_at_end
        outward = np.zeros_like(position)
        if inner.any():
            outward[inner] = self.surface.outward_at(triangle[inner], weights[inner], normal[inner])
        return SurfacePlacement(position, normal, shape, arc, tangent, curvature, outward)

    def _leaning(self, placement: SurfacePlacement, part: FloatArray) -> FloatArray:
        """Return the displacement [cm] that keeps vertices on a concave end as they move along it, shape (V, 3)."""
        length = np.linalg.norm(part, axis=1)
        # Largest cosine between the outward direction and a direction along the end of the surface that is only
        # rounding.
        inwards = np.einsum("vi,vi->v", part, placement.outward) < -1e-9 * length
        return np.where(inwards, 0.0, length)[:, None] * placement.outward


def attach(
    fabric: StitchMesh, surface: LimitSurface, reach: float, device: str | None, *, bobbles: Bobbles = NO_BOBBLES,
    held: NDArray[np.bool_] | None = None,
) -> tuple[SurfaceAttachment, SurfacePlacement]:  # fmt: skip
    """Attach a fabric whose vertices are on the input polygons to the limit surface of these polygons.

    Args:
        fabric: stitch mesh whose vertices are on the input polygons.
        surface: limit surface of the input polygons.
        reach: distance within which a vertex usually finds its triangle [cm].
        device: Warp's name of the device.
        bobbles: the bobbles of the fabric, whose slits are no borders of the surface.
        held: whether each vertex is held at its place, shape (V,); None if all vertices may move.

    Returns:
        The attachment, and the placement of the vertices on the limit surface.
    """
    flat = ClosestPoint(surface.flat_vertices, surface.triangles, reach, device)
    triangle, weights = flat.find(fabric.vertices, _normals_beside(fabric, bobbles))
    position, normal = surface.evaluate(triangle, weights)
    # If a border of the fabric is farther than this from every border of the surface, it is free: it lies on the
    # surface. The distance is divided by the reach of the search; with the reach of ``relax`` it is the size of a
    # stitch.
    border, arc = _locate_borders(fabric, surface, 5.0 * reach, bobbles)
    closest = ClosestPoint(surface.vertices, surface.triangles, reach, device)
    without_corners = SurfaceAttachment(surface, closest, border, np.zeros(len(border), dtype=bool))
    placement = without_corners.place(triangle, weights, position, normal, arc)
    corner = border_corners(fabric, placement.position) & (border >= 0)
    if held is None:
        attachment = replace(without_corners, fixed=corner)
        return attachment, attachment.place(triangle, weights, position, normal, arc)
    attachment = replace(without_corners, fixed=corner | held, border=np.where(held, -1, border))
    position = np.where(held[:, None], fabric.vertices, placement.position)
    return attachment, attachment.place(triangle, weights, position, normal, arc)


def _normals_beside(fabric: StitchMesh, bobbles: Bobbles) -> FloatArray:
    """Unit normal of each vertex, shape (V, 3), without the faces of bobbles, which do not lie on the surface."""
    if bobbles.count == 0:
        return fabric.vertex_normal
    area = fabric.face_vector_area.copy()
    area[bobbles.faces] = 0.0
    total = np.zeros_like(fabric.vertices)
    np.add.at(total, fabric.face_vertex, area[fabric.side_face])
    return np.where(total.any(axis=1, keepdims=True), unit_vectors(total), fabric.vertex_normal)


def border_corners(fabric: StitchMesh, position: FloatArray) -> NDArray[np.bool_]:
    """Return whether each vertex is a corner of a border, shape (V,).

    One face contains the corner of a swatch, and three or more faces the end of a slit. The ends of a flat closed tip
    are also corners, because the direction of the border reverses there within a stitch.

    Args:
        fabric: stitch mesh.
        position: positions of its vertices [cm], shape (V, 3).
    """
    faces = np.bincount(fabric.face_vertex, minlength=len(position))
    corner = border_vertices(fabric) & (faces != 2)
    for loop in fabric.boundary_loops:
        members = fabric.face_vertex[loop]
        ahead = np.roll(position[members], -1, axis=0) - position[members]
        behind = np.roll(ahead, 1, axis=0)
        size = np.linalg.norm(ahead, axis=1) * np.linalg.norm(behind, axis=1)
        # Tolerance of the cosine of a right angle: a border that turns by a right angle, up to rounding, has no
        # corner.
        corner[members] |= np.einsum("ni,ni->n", ahead, behind) < -1e-9 * size
    return corner


def _locate_borders(
    fabric: StitchMesh, surface: LimitSurface, within: float, bobbles: Bobbles
) -> tuple[IntArray, FloatArray]:
    """Return the border of the surface, or -1, and the arc length [cm] of each vertex of the fabric.

    Each border loop of the fabric belongs to the border of the surface with the smallest mean square distance. If that
    distance is large, it belongs to none.

    Args:
        fabric: stitch mesh.
        surface: the surface.
        within: largest root mean square distance from a border of the surface [cm].
        bobbles: the bobbles of the fabric, whose slits belong to no border.
    """
    border, arc = np.full(len(fabric.vertices), -1), np.zeros(len(fabric.vertices))
    loops = [loop for loop in fabric.boundary_loops if not np.isin(fabric.side_face[loop], bobbles.faces).all()]
    for loop in loops if surface.borders else []:
        members = fabric.face_vertex[loop]
        found = [curve.locate(fabric.vertices[members]) for curve in surface.borders]
        distance = [np.sqrt(np.mean(apart**2)) for _, apart in found]
        best = int(np.argmin(distance))
        if min(distance[best], surface.borders[best].distance(fabric.vertices[members])) <= within:
            border[members], arc[members] = best, found[best][0]
    return border, arc


def turning_stiffness(placement: SurfacePlacement, force: FloatArray) -> FloatArray:
    """Compute the positive semidefinite turning stiffness of each vertex [1/cm], shape (V, 3, 3).

    It comes from the curvature of the surface and of its border. Only the part of the force f in the allowed directions
    of a vertex counts, and these directions turn when the vertex moves. On a border with tangent t this part is f . t,
    whose derivative with respect to the arc length s is f . dt/ds. On a surface with normal n and shape operator S,
    where dn = S dx, a tangent t turns by -(t . S dx) n. The part of f along t therefore changes by -(f . n) t . S dx,
    which is a stiffness of (f . n) S. This stiffness dominates the springs where a surface or a border turns within a
    stitch, for example between the fingers of a glove or at the ends of a slit. Only the positive part of the stiffness
    is kept, so that the matrices are positive semidefinite.

    Args:
        placement: placement of the vertices.
        force: net force on each vertex before projection onto the allowed directions, shape (V, 3).
    """
    stiffness = np.empty_like(placement.shape)

    def compute(some: slice) -> None:
        own, tangent = force[some], placement.tangent[some]
        across = np.einsum("vi,vi->v", own, placement.normal[some])
        change = np.einsum("vi,vi->v", own, placement.curvature[some])
        along = np.maximum(-change, 0.0)[:, None, None] * (tangent[:, :, None] * tangent[:, None, :])
        stiffness[some] = positive_part(across[:, None, None] * placement.shape[some]) + along

    each_block(compute, len(stiffness), VERTICES_OF_BLOCK)
    return stiffness


def positive_part(matrix: FloatArray) -> FloatArray:
    """Return the positive semidefinite part of symmetric matrices M that have one eigenvalue zero, shape (n, 3, 3).

    If the other two eigenvalues a and b are both positive, it is M, and if neither is, it is zero. If a > 0 > b, it is
    (M^2 - b M) / (a - b), because this matrix has the eigenvalues a, 0 and 0 on the axes of M.
    """
    square = matrix @ matrix
    mean = 0.5 * np.trace(matrix, axis1=1, axis2=2)
    half = np.sqrt(np.maximum(0.5 * np.trace(square, axis1=1, axis2=2) - mean**2, 0.0))
    most, least = (mean + half)[:, None, None], (mean - half)[:, None, None]
    mixed = (square - least * matrix) / np.maximum(most - least, TINY)
    return np.where(least >= 0.0, matrix, np.where(most > 0.0, mixed, 0.0))
