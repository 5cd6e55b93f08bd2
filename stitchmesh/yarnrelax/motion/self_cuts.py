# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Finds frames in which a moving body cuts through itself: an edge of one triangle passes through another triangle.

Triangles that share a place are neighbours and do not count. To touch is not to cut: all signed volumes must differ
from zero.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray
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


def refuse_self_cuts(moving: MovingMesh, device: wp.Device) -> None:
    """Check that no frame of a body cuts through itself.

    Raises:
        ParameterError: a frame does; the message names the frame, its time, two faces, and the place.
    """
    topology = feature_topology(moving.mesh)
    for number, vertices in enumerate(moving.motion.vertices):
        cut = _cuts(vertices[topology.corner].reshape(-1, 3), topology.place.ravel(), device)
        found = np.flatnonzero(cut >= 0)
        if not len(found):
            continue
        first = int(found[0])
        where = vertices[topology.corner[first]].mean(axis=0)
        at = f"frame {number} ({moving.motion.times[number]:g} s), near {np.round(where, 2).tolist()} cm"
        one, other = topology.face[[first, cut[first]]]
        pair = f"face {one} cuts through face {other}, and {len(found) - 1} more triangles do"
        raise ParameterError(f"moving body: {at}: {pair}; expected a body that does not cut itself; bend it less there")


def _cuts(corners: FloatArray, place: Any, device: wp.Device) -> Any:
    """Return the triangle through which each triangle cuts, or -1, shape (T,)."""
    indices = wp.array(np.arange(len(corners)), dtype=wp.int32, device=device)
    tree = wp.Mesh(wp.array(corners, dtype=wp.vec3, device=device), indices)
    count = len(corners) // 3
    cut = wp.zeros(count, dtype=wp.int32, device=device)
    places = wp.array(place.astype(np.int32), dtype=wp.int32, device=device)
    launch(find_cuts, count, [tree.id, wp.array(corners, dtype=wp.vec3d, device=device), places], [cut], device)
    return cut.numpy()
