# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rigid motions of bodies and attachments by keyframes; ``stitchmesh.mesh.vertex_motion`` holds motions of vertices.

A rigid motion takes a point from its first place X to

    x = R(t) (X - c) + c + d(t)

with a centre c. Between keyframes the displacement d is linear in time, and the rotation R turns about one axis at
constant speed (spherical linear interpolation). Before the first keyframe and after the last one nothing moves.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray
from stitchmesh.mesh.vertex_motion import check_increasing, checked_numbers

Pose = tuple[FloatArray, FloatArray]
"""A rotation matrix (3, 3) and an offset (3,) [cm]: a point X is at R X + offset."""


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """A rigid motion by K keyframes.

    Raises:
        ParameterError: times do not increase, an array has the wrong shape or numbers that are not finite, or a matrix
            is not a rotation.
    """

    times: FloatArray
    """Times of the keyframes [s], increasing, shape (K,)."""
    displacement: FloatArray
    """Displacements of the centre [cm], shape (K, 3)."""
    rotation: FloatArray | None = None
    """Rotation matrices, shape (K, 3, 3); no rotation where not given."""
    centre: FloatArray = field(default_factory=lambda: np.zeros(3))
    """Centre of the rotations in the first place [cm], shape (3,)."""

    def __post_init__(self) -> None:
        count = len(np.atleast_1d(self.times))
        rotation = np.tile(np.eye(3), (count, 1, 1)) if self.rotation is None else self.rotation
        for name, values, shape in (
            ("times", self.times, (count,)),
            ("displacement", self.displacement, (count, 3)),
            ("rotation", rotation, (count, 3, 3)),
            ("centre", self.centre, (3,)),
        ):
            object.__setattr__(self, name, checked_numbers("motion", name, values, shape))
        check_increasing(self.times)
        matrices = np.asarray(self.rotation)
        error = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        wrong = np.flatnonzero((error > 1e-6) | (np.linalg.det(matrices) < 0.0))
        if len(wrong):
            raise ParameterError(f"motion: keyframe {int(wrong[0])}: got a matrix that is not a rotation; expected one")

    @staticmethod
    def at_rest() -> RigidMotion:
        """The motion of a body that stays at rest."""
        return RigidMotion(np.zeros(1), np.zeros((1, 3)))

    def pose_at(self, time: float) -> Pose:
        """Rotation and offset at a time [s]."""
        when = float(np.clip(time, self.times[0], self.times[-1]))
        shift = np.array([np.interp(when, self.times, self.displacement[:, axis]) for axis in range(3)])
        turns = Rotation.from_matrix(np.asarray(self.rotation))
        turn = (Slerp(self.times, turns)(when) if len(self.times) > 1 else turns[0]).as_matrix()
        return turn, self.centre + shift - turn @ self.centre

    def places_at(self, points: FloatArray, time: float) -> FloatArray:
        """Places at a time [cm] of points whose first places are given, shape (n, 3)."""
        turn, offset = self.pose_at(time)
        places: FloatArray = points @ turn.T + offset
        return places
