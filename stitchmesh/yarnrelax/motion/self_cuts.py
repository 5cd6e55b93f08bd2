# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Finds frames in which a moving body cuts through itself: an edge of one triangle passes through another triangle.

Triangles that share a place are neighbours and do not count. To touch is not to cut: all signed volumes must differ
from zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.mesh.vertex_motion import MovingMesh
from stitchmesh.simulation.bodies.mesh_features import feature_topology


@wp.func
def volume_sign(a: wp.vec3d, b: wp.vec3d, c: wp.vec3d, d: wp.vec3d) -> int:
    """Sign of the volume of a tetrahedron, -1, 0 or 1."""
    volume = wp.dot(wp.cross(b - a, c - a), d - a)
    if volume > wp.float64(0.0):
        return 1
    if volume < wp.float64(0.0):
        return -1
    return 0


@wp.func
def passes_through(corners: wp.array[wp.vec3d], place: wp.array[wp.int32], i: int, j: int, o: int) -> bool:
    """Whether the edge between two corners passes through a triangle of other places."""
    for m in range(3):
        if place[3 * o + m] == place[i] or place[3 * o + m] == place[j]:
            return False
    a, b, p, q, r = corners[i], corners[j], corners[3 * o], corners[3 * o + 1], corners[3 * o + 2]
    if volume_sign(p, q, r, a) * volume_sign(p, q, r, b) != -1:
        return False
    turn = volume_sign(a, b, p, q)
    return turn != 0 and turn == volume_sign(a, b, q, r) and turn == volume_sign(a, b, r, p)


@kernel
def find_cuts(
    # model
    tree: wp.uint64,
    corners: wp.array[wp.vec3d],
    place: wp.array[wp.int32],
    # state out
    cut: wp.array[wp.int32],
) -> None:
    """The first triangle through which an edge of each triangle passes; -1 if there is none."""
    t = wp.tid()
    first = int(-1)
    for k in range(3):
        i, j = 3 * t + k, 3 * t + (k + 1) % 3
        low, high = wp.vec3(wp.min(corners[i], corners[j])), wp.vec3(wp.max(corners[i], corners[j]))
        room = wp.vec3(1.0e-4, 1.0e-4, 1.0e-4)  # the boxes are single precision
        query = wp.mesh_query_aabb(tree, low - room, high + room)
        o = wp.int32(0)
        while wp.mesh_query_aabb_next(query, o):
            if passes_through(corners, place, i, j, o) and (first < 0 or o < first):
                first = o
    cut[t] = first


@dataclass(frozen=True)
class SelfCut:
    """A place where a surface cuts through itself."""

    faces: tuple[int, int]
    """Two faces of the mesh that cut through each other."""
    triangles: int
    """Number of triangles that are cut."""
    middle: tuple[float, float, float]
    """Middle of the first of them [cm]."""

    def __str__(self) -> str:
        one, other = self.faces
        where = [round(value, 2) for value in self.middle]
        return f"near {where} cm: face {one} cuts through face {other}, and {self.triangles - 1} more triangles do"


class SelfCuts:
    """Finds where a moving mesh cuts through itself."""

    def __init__(self, mesh: Mesh, device: wp.Device) -> None:
        """Divide the mesh into triangles, and put them on a device."""
        self.topology, self.device = feature_topology(mesh), device
        corners = mesh.vertices[self.topology.corner].reshape(-1, 3)
        indices = wp.array(np.arange(len(corners)), dtype=wp.int32, device=device)
        self._corners = wp.array(corners, dtype=wp.vec3d, device=device)
        self._tree = wp.Mesh(wp.array(corners, dtype=wp.vec3, device=device), indices)
        self._places = wp.array(self.topology.place.ravel().astype(np.int32), dtype=wp.int32, device=device)
        self._cut = wp.zeros(len(corners) // 3, dtype=wp.int32, device=device)

    def first(self, vertices: FloatArray) -> SelfCut | None:
        """Return the first place where the mesh cuts through itself with its vertices at some places [cm], or None."""
        corners = vertices[self.topology.corner].reshape(-1, 3)
        self._corners.assign(corners)
        self._tree.points.assign(corners.astype(np.float32))
        self._tree.refit()
        inputs = [self._tree.id, self._corners, self._places]
        launch(find_cuts, len(self._cut), inputs, [self._cut], self.device)
        cut = self._cut.numpy()
        found = np.flatnonzero(cut >= 0)
        if not len(found):
            return None
        first = int(found[0])
        one, other = self.topology.face[[first, cut[first]]].tolist()
        x, y, z = vertices[self.topology.corner[first]].mean(axis=0).tolist()
        return SelfCut((one, other), len(found), (x, y, z))


def refuse_self_cuts(moving: MovingMesh, device: wp.Device) -> None:
    """Check that no frame of a body cuts through itself.

    Raises:
        ParameterError: a frame does; the message names the frame, its time, two faces, and the place.
    """
    finder = SelfCuts(moving.mesh, device)
    for number, vertices in enumerate(moving.motion.vertices):
        found = finder.first(vertices)
        if found is not None:
            at = f"frame {number} ({moving.motion.times[number]:g} s)"
            expected = "expected a body that does not cut itself; bend it less there"
            raise ParameterError(f"moving body: {at}, {found}; {expected}")
