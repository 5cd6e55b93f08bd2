# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Attachments, and rigid motions of bodies and attachments by keyframes.

``stitchmesh.mesh.vertex_motion`` holds motions of vertices. Attachments are vertices and yarn nodes that are held, or
moved by keyframes.

A rigid motion takes a point from its first place X to

    x = R(t) (X - c) + c + d(t)

with a centre c. Between keyframes the displacement d is linear in time, and the rotation R turns about one axis at
constant speed (spherical linear interpolation). Before the first keyframe and after the last one nothing moves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray, frozen_array
from stitchmesh.mesh.vertex_motion import check_increasing, checked_numbers
from stitchmesh.mixed.mixed_vector import Parts

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


def _none() -> IntArray:
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Attachment:
    """Vertices and nodes that are attached to something that does not move, or moves rigidly.

    Raises:
        ParameterError: nothing is attached, or a number occurs twice or is negative.
    """

    vertices: IntArray = field(default_factory=_none)
    """Numbers of vertices, ascending."""
    nodes: IntArray = field(default_factory=_none)
    """Numbers of yarn nodes, ascending."""
    motion: RigidMotion = field(default_factory=RigidMotion.at_rest)
    """How the attached points move, from where they are at the start."""
    name: str = "attachment"
    """Name in messages."""

    def __post_init__(self) -> None:
        for kind in ("vertices", "nodes"):
            numbers = np.sort(np.asarray(getattr(self, kind), dtype=np.int64))
            if len(numbers) and (numbers[0] < 0 or (np.diff(numbers) == 0).any()):
                raise ParameterError(
                    f"{self.name}: {kind}: got a number below 0 or one twice; expected distinct numbers"
                )
            object.__setattr__(self, kind, frozen_array(numbers, np.int64))
        if not len(self.vertices) + len(self.nodes):
            raise ParameterError(f"{self.name}: got no vertex and no node; expected some: change what is chosen")


def at_simulated_nodes(attachments: Sequence[Attachment], node_number: IntArray) -> list[Attachment]:
    """Return attachments with the numbers of simulated nodes in a state, without attachments that hold nothing there.

    Args:
        attachments: attachments whose nodes are numbered as in the layout.
        node_number: number of each node of the layout among the simulated ones, -1 for the others, shape (N,).
    """
    result = []
    for attachment in attachments:
        own = node_number[attachment.nodes]
        own = own[own >= 0]
        if len(own) + len(attachment.vertices):
            result.append(replace(attachment, nodes=own))
    return result


class PrescribedMotion:
    """Where attached vertices and nodes are at each time."""

    def __init__(self, attachments: Sequence[Attachment], vertices: FloatArray, nodes: FloatArray) -> None:
        """Prescribe the motion of attachments.

        Args:
            attachments: the attachments, whose nodes are numbered as ``nodes``.
            vertices: positions of all vertices at the start [cm], shape (V, 3).
            nodes: positions of all nodes at the start [cm], shape (N, 3).

        Raises:
            ParameterError: a number does not exist, or is in two attachments.
        """
        self._held = list(attachments)
        self._vertices, self._nodes = np.asarray(vertices, dtype=np.float64), np.asarray(nodes, dtype=np.float64)
        self.fixed_vertices = _numbers("vertex", [(a.name, a.vertices) for a in self._held], len(self._vertices))
        """Numbers of the fixed vertices, ascending."""
        self.fixed_nodes = _numbers("node", [(a.name, a.nodes) for a in self._held], len(self._nodes))
        """Numbers of the fixed nodes, ascending."""

    def positions(self, time: float) -> Parts:
        """Positions at a time [s]: vertices (V, 3), nodes (N, 3), and zeros; free points stay at their start."""
        v, p = self._vertices.copy(), self._nodes.copy()
        for attachment in self._held:
            v[attachment.vertices] = attachment.motion.places_at(self._vertices[attachment.vertices], time)
            p[attachment.nodes] = attachment.motion.places_at(self._nodes[attachment.nodes], time)
        return v, p, np.zeros((len(p), 2))

    def displacements(self, begin: float, end: float) -> Parts:
        """Displacements from one time to another [cm]; over many steps they add up to the motion without drift."""
        after, before = self.positions(end), self.positions(begin)
        return after[0] - before[0], after[1] - before[1], after[2]

    def places(self, time: float) -> Parts:
        """Start positions plus the displacements from time 0 to a time [s]: vertices, nodes, and zeros [cm]."""
        moved = self.displacements(0.0, time)
        return self._vertices + moved[0], self._nodes + moved[1], moved[2]

    def velocities(self, begin: float, end: float) -> Parts:
        """Mean velocities between two times [cm/s]: with them a step reaches the positions at its end."""
        v, p, s = self.displacements(begin, end)
        return v / (end - begin), p / (end - begin), s


def _numbers(kind: str, chosen: Sequence[tuple[str, IntArray]], count: int) -> IntArray:
    """All numbers of several attachments that share none."""
    taken: dict[int, str] = {}
    for name, numbers in chosen:
        for number in numbers.tolist():
            if number >= count:
                raise ParameterError(f"{name}: got {kind} {number}; expected 0 to {count - 1}")
            if number in taken:
                found = f"got {kind} {number}, which {taken[number]} holds"
                raise ParameterError(f"{name}: {found}; expected each in one attachment")
            taken[number] = name
    return np.array(sorted(taken), dtype=np.int64)
