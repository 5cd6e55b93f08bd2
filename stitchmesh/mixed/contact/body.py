# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bodies: closed surfaces that a cloth cannot enter, at rest or in a given motion.

A body in rigid motion keeps its triangles and their tree of boxes on the device; contact points are transformed to the
frame of the body instead. A deforming body gets new corners, outward directions and boxes at each new time.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.precision import Mat33, ScalarType, Vec3, matrix, vector
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, Mesh
from stitchmesh.mesh.vertex_motion import VertexMotion
from stitchmesh.mixed.contact.motion import RigidMotion
from stitchmesh.simulation.bodies.body_surface import surface_of
from stitchmesh.simulation.bodies.mesh_features import enclosed_volume, feature_topology, features_at


@wp.func
def to_body(frame: Mat33, origin: Vec3, place: Vec3) -> Any:
    """A place of the world in the frame of a body."""
    return wp.transpose(frame) * (place - origin)


@dataclass(frozen=True, eq=False)
class SolidBody:
    """A closed surface that a cloth cannot enter; its faces are oriented outwards.

    Raises:
        ParameterError: the mesh is open, inside out, without volume or on a lattice, or the motion has another number
            of vertices.
    """

    mesh: Mesh
    """The surface [cm]."""
    motion: RigidMotion | VertexMotion = field(default_factory=RigidMotion.at_rest)
    """How the surface moves."""
    name: str = "body"
    """Name in messages."""

    def __post_init__(self) -> None:
        if self.mesh.lattice is not None:
            raise ParameterError(f"{self.name}: got a mesh on a lattice; expected one without")
        sides = int((self.mesh.twin == BORDER).sum())
        if sides:
            found = f"got an open mesh, with {sides} sides on a border"
            raise ParameterError(f"{self.name}: {found}; expected a closed one: fill its holes")
        volume = enclosed_volume(self.mesh)
        if not volume > 0.0:
            found = f"got a mesh that is inside out (volume {volume:.3g} cm^3)"
            raise ParameterError(f"{self.name}: {found}; expected faces that look outwards: reverse them")
        self._check_motion()

    def _check_motion(self) -> None:
        expected = len(self.mesh.vertices)
        if isinstance(self.motion, VertexMotion) and self.motion.vertices.shape[1] != expected:
            found = f"got a motion of {self.motion.vertices.shape[1]} vertices"
            raise ParameterError(f"{self.name}: {found}; expected {expected}, those of its mesh")


class PlacedBody:
    """A body on a device, at one time."""

    def __init__(self, body: SolidBody, scalar: ScalarType, device: wp.Device) -> None:
        """Put a body where it is at time 0."""
        self.body = body
        self._topology = feature_topology(body.mesh)
        self._surface = surface_of(features_at(self._topology, body.mesh.vertices), scalar, device)
        self.surface = self._surface.constants
        self.frame = wp.array(np.eye(3)[None], dtype=matrix(3, scalar), device=device)
        self.origin = wp.zeros(1, dtype=vector(3, scalar), device=device)
        self._time: float | None = None
        self.move_to(0.0)

    @property
    def moves(self) -> bool:
        """Whether the body is not at rest."""
        return len(self.body.motion.times) > 1

    @property
    def deforms(self) -> bool:
        """Whether the shape of the body changes."""
        return self.moves and isinstance(self.body.motion, VertexMotion)

    def move_to(self, time: float) -> None:
        """Put the body where it is at a time [s]."""
        if time == self._time or (self._time is not None and not self.moves):
            return
        if isinstance(self.body.motion, RigidMotion):
            frame, origin = self.body.motion.pose_at(time)
            self.frame.assign(frame[None])
            self.origin.assign(origin[None])
        else:
            self._deform(self.body.motion, time)
        self._time = time

    def largest_motion(self, begin: float, end: float) -> float:
        """An upper bound of the distance that a point of the body moves between two times [cm]."""
        motion = self.body.motion
        if isinstance(motion, VertexMotion):
            return float(np.linalg.norm(motion.vertices_at(end) - motion.vertices_at(begin), axis=1).max())
        low, high = self.body.mesh.vertices.min(axis=0), self.body.mesh.vertices.max(axis=0)
        corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
        return float(np.linalg.norm(motion.places_at(corners, end) - motion.places_at(corners, begin), axis=1).max())

    def _deform(self, motion: VertexMotion, time: float) -> None:
        features = features_at(self._topology, motion.vertices_at(time))
        corners = features.corners.reshape(-1, 3)
        self.surface.corners.assign(corners)
        self.surface.outward.assign(features.outward.reshape(-1, 3))
        self._surface.tree.points.assign(corners)
        self._surface.tree.refit()
