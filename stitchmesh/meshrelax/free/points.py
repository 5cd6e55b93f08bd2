# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The points between which the forces of a free fabric act, the unknowns that move them, and the plane of the motion.

A point is a vertex in one image of the lattice. Without a lattice the points are the vertices. With a lattice the
periods u and v move too. Let (s, t) be the place of a vertex in the cell at the start, in parts of the periods, and let
(a, b) be the image of the point. A change of the unknowns moves the point by

    dx + (s + a) du + (t + b) dv

A period that no stitch crosses is no unknown, for example the period along the wales of a tube. A change of the periods
alone deforms the whole fabric evenly. The tension of all stitches therefore moves a period, and not the tension of a
few stitches at its border. All points stay in one plane, as on a table without friction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import MeshError
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.meshrelax.linear_solver import PATCH_VERTICES, Patches
from stitchmesh.meshrelax.placement import PlacedPoints


@dataclass(frozen=True, eq=False)
class Points:
    """The points of a fabric. The first V points are the vertices in the cell."""

    vertex: IntArray
    """Vertex of each point, shape (P,)."""
    share: FloatArray
    """Part of the change of each period by which each point moves, shape (P, periods); no periods without a lattice."""
    vertex_count: int
    """Number of vertices V."""

    @property
    def unknown_count(self) -> int:
        """Number of unknowns: the vertices, and then the periods."""
        return self.vertex_count + self.share.shape[1]

    def moved(self, position: FloatArray, step: FloatArray) -> FloatArray:
        """Return the positions of the points after a step of the unknowns [cm], shape (P, 3).

        Args:
            position: positions of the points [cm], shape (P, 3).
            step: displacement of each vertex and change of each period [cm], shape (U, 3).
        """
        moved: FloatArray = position + step[self.vertex] + self.share @ step[self.vertex_count :]
        return moved

    def on_unknowns(self, points: IntArray, weights: list[float]) -> tuple[IntArray, FloatArray]:
        """Return the unknowns on which some elements act, and the weight of each unknown, shapes (n, m + periods).

        Args:
            points: points of each element, shape (n, m).
            weights: weight of each of these points, m numbers.
        """
        periods = self.share.shape[1]
        numbers = np.broadcast_to(self.vertex_count + np.arange(periods), (len(points), periods))
        whole = np.einsum("nmk,m->nk", self.share[points], np.array(weights))
        each = np.broadcast_to(np.array(weights), points.shape)
        return np.concatenate([self.vertex[points], numbers], axis=1), np.concatenate([each, whole], axis=1)


@dataclass(frozen=True, eq=False)
class CornerPoints:
    """The points of a fabric, by mesh corner."""

    points: Points
    """The points."""
    position: FloatArray
    """Their positions at the start [cm], shape (P, 3)."""
    of_corner: IntArray
    """Point of each mesh corner, shape (C,)."""
    struts: IntArray
    """Points of the struts whose corners were given, shape (W, 3)."""


def corner_points(fabric: StitchMesh, strut_corners: IntArray) -> CornerPoints:
    """Find the points of a fabric.

    Args:
        fabric: stitch mesh.
        strut_corners: corners of its struts (``wale_strut_corners``), shape (W, 4). Struts cross borders of the cell,
            so that they have their own points around the vertex in the cell.
    """
    count = len(fabric.vertices)
    if fabric.lattice is None or fabric.corner_image is None:
        points = Points(np.arange(count), np.zeros((count, 0)), count)
        of_corner = fabric.face_vertex
        return CornerPoints(points, fabric.vertices, of_corner, of_corner[strut_corners[:, [0, 1, 3]]])
    corner, image = fabric.face_vertex, fabric.corner_image
    far, middle = strut_corners[:, [0, 3]], strut_corners[:, [1, 2]]
    vertex = np.concatenate([np.arange(count), corner, corner[far].ravel()])
    place = np.concatenate([np.zeros((count, 2), int), image, (image[far] - image[middle]).reshape(-1, 2)])
    found, number = np.unique(np.column_stack([place.any(axis=1), vertex, place]), axis=0, return_inverse=True)
    number = number.ravel()
    own, image = found[:, 1], found[:, 2:]
    periods = fabric.lattice.periods
    part = np.linalg.lstsq(periods.T, (fabric.vertices - fabric.vertices.mean(axis=0)).T, rcond=None)[0].T
    crossed = image.any(axis=0)
    points = Points(own, (part[own] + image)[:, crossed], count)
    ends = number[count + len(corner) :].reshape(-1, 2)
    struts = np.stack([ends[:, 0], corner[middle[:, 0]], ends[:, 1]], axis=1)
    return CornerPoints(points, fabric.vertices[own] + image @ periods, number[count : count + len(corner)], struts)


@dataclass(frozen=True, eq=False)
class FabricPlane:
    """Where the points of a free fabric may move (``placement.MeshConstraint``)."""

    points: Points
    """The points and their unknowns."""
    normal: FloatArray
    """Unit normal of the plane, shape (3,)."""

    def projector(self, placement: PlacedPoints, force: FloatArray) -> FloatArray:
        """Return the projector onto the plane for each unknown, shape (U, 3, 3)."""
        allowed = np.eye(3) - np.outer(self.normal, self.normal)
        return np.broadcast_to(allowed, (self.points.unknown_count, 3, 3))

    def within(self) -> FabricPlane:
        """Return the plane itself, which has no end."""
        return self

    def turning_stiffness(self, placement: PlacedPoints, force: FloatArray) -> FloatArray:
        """Return zeros, shape (U, 3, 3), because a plane does not turn."""
        return np.zeros((self.points.unknown_count, 3, 3))

    def move(self, placement: PlacedPoints, step: FloatArray, stride: float) -> PlacedPoints:
        """Return the placement after a step of the unknowns [cm], shape (U, 3); no projection limits the stride."""
        return self.place(self.points.moved(placement.position, step))

    def place(self, position: FloatArray) -> PlacedPoints:
        """Return the placement of points at some positions [cm], shape (P, 3)."""
        return PlacedPoints(position, np.broadcast_to(self.normal, position.shape))

    def patches(self, position: FloatArray, size: float) -> Patches:
        """Divide the unknowns into patches for the preconditioner: vertices by place, and a patch for each period.

        Args:
            position: positions of the points [cm], shape (P, 3).
            size: size of a stitch [cm].
        """
        count, unknowns = self.points.vertex_count, self.points.unknown_count
        own = position[:count]
        cell = np.floor((own - own.mean(axis=0)) / (size * np.sqrt(PATCH_VERTICES)))
        patch = np.unique(cell, axis=0, return_inverse=True)[1].ravel()
        numbers = np.concatenate([patch, patch.max() + 1 + np.arange(unknowns - count)])
        first = np.cross(self.normal, np.eye(3)[np.abs(self.normal).argmin()])
        first /= np.linalg.norm(first)
        motions = np.stack([first, np.cross(self.normal, first)], axis=1)
        return Patches(numbers, int(numbers.max()) + 1, np.broadcast_to(motions, (unknowns, 3, 2)))


def plane_normal(fabric: StitchMesh) -> FloatArray:
    """Return the unit normal of the plane of a fabric, shape (3,).

    Raises:
        MeshError: the fabric does not lie in a plane.
    """
    area = fabric.face_vector_area
    total = area.sum(axis=0)
    size, whole = float(np.linalg.norm(total)), float(np.linalg.norm(area, axis=1).sum())
    # A flat fabric may lose this part of its area in the projection onto its plane; it covers rounding.
    if size < (1.0 - 1e-9) * whole:
        found = f"got a fabric of {whole:.3g} cm^2 that covers {size:.3g} cm^2 of its plane"
        raise MeshError(f"natural outline: {found}; expected a flat piece (a pattern can be a tube too)")
    normal: FloatArray = total / size
    return normal
