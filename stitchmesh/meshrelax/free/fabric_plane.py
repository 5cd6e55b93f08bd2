# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The plane in which a fabric without a surface moves, as on a table without friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import MeshError
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.meshrelax.free.points import Points
from stitchmesh.meshrelax.placement import PlacedPoints
from stitchmesh.meshrelax.preconditioner import PATCH_VERTICES, Patches


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
