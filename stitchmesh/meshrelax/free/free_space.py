# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A fabric that no surface holds: it moves in its plane if it is flat or on a lattice, and in space otherwise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.meshrelax.free.points import Points
from stitchmesh.meshrelax.placement import Placement
from stitchmesh.meshrelax.preconditioner import PATCH_VERTICES, Patches


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """Where the points of a free fabric may move (``placement.Constraint``)."""

    points: Points
    """The points and their unknowns."""
    quads: IntArray
    """Points of each sub-quad, counter-clockwise from the lower left, shape (Q, 4)."""
    plane: FloatArray | None
    """Unit normal of the plane of the fabric, None for a fabric in space."""

    def projector(self, placement: Placement) -> FloatArray:
        """Return the projector onto the allowed directions of each unknown, shape (U, 3, 3)."""
        allowed = np.eye(3) if self.plane is None else np.eye(3) - np.outer(self.plane, self.plane)
        return np.broadcast_to(allowed, (self.points.unknown_count, 3, 3))

    def turning_stiffness(self, placement: Placement, force: FloatArray) -> FloatArray:
        """Return zeros, shape (U, 3, 3), because the allowed directions do not turn."""
        return np.zeros((self.points.unknown_count, 3, 3))

    def move(self, placement: Placement, step: FloatArray, stride: float) -> Placement:
        """Return the placement after a step of the unknowns [cm], shape (U, 3)."""
        return self.place(self.points.moved(placement.position, step))

    def place(self, position: FloatArray) -> Placement:
        """Return the placement of points at some positions [cm], shape (P, 3)."""
        if self.plane is not None:
            return Placement(position, np.broadcast_to(self.plane, position.shape))
        lower_left, lower_right, upper_right, upper_left = (position[self.quads[:, corner]] for corner in range(4))
        area = np.cross(upper_right - lower_left, upper_left - lower_right)
        normal = np.zeros_like(position)
        for corner in range(4):
            np.add.at(normal, self.quads[:, corner], area)
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        return Placement(position, normal / np.where(length > 0.0, length, 1.0))

    def patches(self, position: FloatArray, size: float) -> Patches:
        """Divide the unknowns into patches for the preconditioner: vertices by place, and each period for itself.

        Args:
            position: positions of the points [cm], shape (P, 3).
            size: size of a stitch [cm].
        """
        count, unknowns = self.points.vertex_count, self.points.unknown_count
        own = position[:count]
        cell = np.floor((own - own.mean(axis=0)) / (size * np.sqrt(PATCH_VERTICES)))
        patch = np.unique(cell, axis=0, return_inverse=True)[1].ravel()
        numbers = np.concatenate([patch, patch.max() + 1 + np.arange(unknowns - count)])
        motions = np.eye(3) if self.plane is None else _plane_axes(self.plane)
        return Patches(numbers, int(numbers.max()) + 1, np.broadcast_to(motions, (unknowns, *motions.shape)))


def _plane_axes(normal: FloatArray) -> FloatArray:
    """Return two unit vectors that span a plane with a unit normal, as columns, shape (3, 2)."""
    first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)], axis=1)
