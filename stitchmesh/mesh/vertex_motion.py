# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Motion of a deforming mesh: the positions of its vertices at given times, and linear motion between them.

Before the first time and after the last one nothing moves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.polygon_mesh import FloatArray, Mesh, frozen_array

FRAMES_PER_SECOND = 30.0
"""Frames per second if the caller gives no other number."""


@dataclass(frozen=True, eq=False)
class VertexMotion:
    """Positions of all vertices of a mesh at K times; the faces stay the same.

    Raises:
        ParameterError: times that do not increase, or arrays of other shapes or without finite numbers.
    """

    times: FloatArray
    """Times [s], increasing, shape (K,)."""
    vertices: FloatArray
    """Positions [cm], shape (K, V, 3)."""

    def __post_init__(self) -> None:
        count, positions = len(np.atleast_1d(self.times)), np.shape(self.vertices)[1:2]
        object.__setattr__(self, "times", checked_numbers("motion", "times", self.times, (count,)))
        shape = (count, *positions, 3)
        object.__setattr__(self, "vertices", checked_numbers("motion", "vertices", self.vertices, shape))
        check_increasing(self.times)

    @property
    def frames_per_second(self) -> float:
        """Mean number of keyframes for each second; 1 if there is only one."""
        span = float(self.times[-1] - self.times[0])
        return (len(self.times) - 1) / span if len(self.times) > 1 else 1.0

    def vertices_at(self, time: float) -> FloatArray:
        """Positions [cm] at a time [s], shape (V, 3)."""
        when = float(np.clip(time, self.times[0], self.times[-1]))
        later = int(np.clip(np.searchsorted(self.times, when), 1, max(len(self.times) - 1, 1)))
        if len(self.times) == 1:
            return self.vertices[0]
        span = self.times[later] - self.times[later - 1]
        part = (when - self.times[later - 1]) / span
        positions: FloatArray = (1.0 - part) * self.vertices[later - 1] + part * self.vertices[later]
        return positions


@dataclass(frozen=True, eq=False)
class MovingMesh:
    """A mesh that is deformed; its faces stay the same.

    Raises:
        ParameterError: a motion of another number of vertices.
    """

    mesh: Mesh
    """The mesh at the first time [cm]."""
    motion: VertexMotion
    """Positions of its vertices."""

    def __post_init__(self) -> None:
        count = self.motion.vertices.shape[1]
        if count != len(self.mesh.vertices):
            expected = f"expected {len(self.mesh.vertices)}, those of the mesh"
            raise ParameterError(f"moving mesh: got a motion of {count} vertices; {expected}")

    @staticmethod
    def of_frames(frames: Sequence[Mesh], times: Sequence[float] | FloatArray) -> MovingMesh:
        """Return the motion of a mesh that is given at some times [s].

        Raises:
            ParameterError: there is no frame, the faces of a frame differ from the faces of the first frame, or the
                times do not increase.
        """
        if not frames:
            raise ParameterError("moving mesh: got no frame; expected at least one")
        for number, frame in enumerate(frames):
            _check_same_faces(number, frame, frames[0])
        return MovingMesh(frames[0], VertexMotion(np.asarray(times), np.array([frame.vertices for frame in frames])))


@dataclass(frozen=True, eq=False)
class RigidPlace:
    """A rigid motion x -> R x + t."""

    rotation: FloatArray
    """R, shape (3, 3)."""
    shift: FloatArray
    """t [cm], shape (3,)."""

    def moved(self, points: FloatArray) -> FloatArray:
        """Return points [cm] after the motion, shape (n, 3)."""
        return points @ self.rotation.T + self.shift

    def brought_back(self, points: FloatArray) -> FloatArray:
        """Return points [cm] before the motion, shape (n, 3)."""
        return (points - self.shift) @ self.rotation


def best_rigid_place(before: FloatArray, after: FloatArray) -> RigidPlace:
    """Return the rigid motion that takes points nearest to others, in the least-squares sense (Kabsch 1976).

    Args:
        before: points [cm], shape (n, 3).
        after: the same points later [cm], shape (n, 3).
    """
    middles = before.mean(axis=0), after.mean(axis=0)
    left, _, right = np.linalg.svd((before - middles[0]).T @ (after - middles[1]))
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    rotation = (left * sign @ right).T
    return RigidPlace(rotation, middles[1] - rotation @ middles[0])


def _check_same_faces(number: int, frame: Mesh, first: Mesh) -> None:
    counts = [(len(mesh.vertices), mesh.face_count) for mesh in (frame, first)]
    if counts[0] != counts[1]:
        found = "got {} vertices and {} faces".format(*counts[0])
        expected = "expected {} and {}, those of the first frame".format(*counts[1])
        raise ParameterError(f"moving mesh: frame {number}: {found}; {expected}; export every frame of one mesh")
    if np.array_equal(frame.face_start, first.face_start) and np.array_equal(frame.face_vertex, first.face_vertex):
        return
    pairs = enumerate(zip(frame.polygons, first.polygons, strict=True))
    face, (own, other) = next((face, pair) for face, pair in pairs if pair[0] != pair[1])
    found = f"face {face}: got vertices {own}; expected {other}, those of the first frame"
    raise ParameterError(f"moving mesh: frame {number}: {found}; export every frame of one mesh")


def checked_numbers(place: str, name: str, values: object, shape: tuple[int, ...]) -> FloatArray:
    """Return an array of numbers of a motion.

    Raises:
        ParameterError: the array has another shape, or a number is not finite.
    """
    found = np.asarray(values, dtype=np.float64)
    if found.shape != shape:
        raise ParameterError(f"{place}: {name}: got shape {found.shape}; expected {shape}")
    if not np.isfinite(found).all():
        raise ParameterError(f"{place}: {name}: got numbers that are not finite; expected finite ones")
    return frozen_array(found, np.float64)


def check_increasing(times: FloatArray) -> None:
    """Check the times of a motion.

    Raises:
        ParameterError: there is no time, or the times do not increase.
    """
    if len(times) == 0:
        raise ParameterError("motion: got no keyframe; expected at least one")
    wrong = np.flatnonzero(np.diff(times) <= 0.0)
    if len(wrong):
        k = int(wrong[0])
        found = f"got {times[k + 1]:g} s after {times[k]:g} s"
        expected = "expected times that increase; sort the frames, or give each its own time"
        raise ParameterError(f"motion: keyframe {k + 1}: {found}; {expected}")
