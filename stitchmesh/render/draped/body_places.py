# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The bodies of a run where they are at a time."""

from __future__ import annotations

from collections.abc import Sequence

from stitchmesh.mesh import Mesh
from stitchmesh.mixed.assembly import LoadedBody
from stitchmesh.mixed.contact.motion import RigidMotion


def bodies_at(bodies: Sequence[LoadedBody], time: float) -> list[Mesh]:
    """Return the surfaces of bodies at a time [s]."""
    moved = []
    for each in bodies:
        mesh, motion = each.body.mesh, each.body.motion
        if isinstance(motion, RigidMotion):
            place = motion.places_at(mesh.vertices, time)
        else:
            place = motion.vertices_at(time)
        moved.append(Mesh(place, mesh.face_start, mesh.face_vertex, mesh.twin))
    return moved
