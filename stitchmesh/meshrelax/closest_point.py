# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Closest points on triangles that face the same way as the point asking, on the CPU or a GPU.

A garment has places where two sheets lie close: fingers of a glove, a slit, a sleeve along the body. A vertex therefore
brings the normal of the sheet it is on, and only triangles that agree with it are candidates. The boxes of the search
are single precision, the distances double.
"""

from __future__ import annotations

import numpy as np
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.compute.kernel import kernel
from stitchmesh.mesh import FloatArray, IntArray


@wp.func
def closest_weights(p: wp.vec3d, a: wp.vec3d, b: wp.vec3d, c: wp.vec3d) -> wp.vec3d:
    """Weights of a, b, c at the point of their triangle closest to p (Ericson 2005, section 5.1.5)."""
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    d1 = wp.dot(b - a, p - a)
    d2 = wp.dot(c - a, p - a)
    if d1 <= zero and d2 <= zero:
        return wp.vec3d(one, zero, zero)
    d3 = wp.dot(b - a, p - b)
    d4 = wp.dot(c - a, p - b)
    if d3 >= zero and d4 <= d3:
        return wp.vec3d(zero, one, zero)
    vc = d1 * d4 - d3 * d2
    if vc <= zero and d1 >= zero and d3 <= zero:
        along = d1 / (d1 - d3)
        return wp.vec3d(one - along, along, zero)
    d5 = wp.dot(b - a, p - c)
    d6 = wp.dot(c - a, p - c)
    if d6 >= zero and d5 <= d6:
        return wp.vec3d(zero, zero, one)
    vb = d5 * d2 - d1 * d6
    if vb <= zero and d2 >= zero and d6 <= zero:
        along = d2 / (d2 - d6)
        return wp.vec3d(one - along, zero, along)
    va = d3 * d6 - d5 * d4
    if va <= zero and d4 >= d3 and d5 >= d6:
        along = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return wp.vec3d(zero, one - along, along)
    total = va + vb + vc
    return wp.vec3d(va / total, vb / total, vc / total)


@kernel
def find_closest(
    # model
    mesh: wp.uint64,
    vertices: wp.array[wp.vec3d],
    triangles: wp.array2d[wp.int32],
    first_reach: float,
    doublings: int,
    # state in
    points: wp.array[wp.vec3d],
    facings: wp.array[wp.vec3d],
    # output
    triangle: wp.array[wp.int32],
    weights: wp.array[wp.vec3d],
) -> None:
    """Search boxes that double until one holds a triangle; the last takes triangles whichever way they face."""
    n = wp.tid()
    p = points[n]
    centre = wp.vec3(float(p[0]), float(p[1]), float(p[2]))
    found = int(-1)
    nearest = wp.float64(1.0e300)
    reach = float(first_reach)
    attempt = int(0)
    while found < 0 and attempt <= doublings:
        corner = wp.vec3(reach, reach, reach)
        query = wp.mesh_query_aabb(mesh, centre - corner, centre + corner)
        t = wp.int32(0)
        while wp.mesh_query_aabb_next(query, t):
            a = vertices[triangles[t, 0]]
            b = vertices[triangles[t, 1]]
            c = vertices[triangles[t, 2]]
            agrees = wp.dot(wp.cross(b - a, c - a), facings[n]) > wp.float64(0.0)
            if agrees or attempt == doublings:
                w = closest_weights(p, a, b, c)
                distance = wp.length(p - (a * w[0] + b * w[1] + c * w[2]))
                inside = distance <= wp.float64(reach) or attempt == doublings
                if inside and (distance < nearest or (distance == nearest and t < found)):
                    nearest = distance
                    found = t
                    weights[n] = w
        reach = 2.0 * reach
        attempt += 1
    triangle[n] = found


class ClosestPoint:
    """Triangles ready to be asked for closest points."""

    def __init__(self, vertices: FloatArray, triangles: IntArray, reach: float, device: str | None) -> None:
        """Upload the triangles.

        Args:
            vertices: shape (V, 3).
            triangles: shape (T, 3).
            reach: distance within which a point usually finds its triangle: the half size of the first search box.
            device: Warp's name of the device; None for the first GPU, else the CPU.

        Raises:
            ParameterError: there is no such device.
        """
        self._origin = vertices.mean(axis=0)  # single precision boxes lose least near the origin
        centred = vertices - self._origin
        self._device = device_named(device)
        corners = np.ascontiguousarray(triangles, dtype=np.int32)
        points = wp.array(centred, dtype=wp.vec3, device=self._device)
        self._mesh = wp.Mesh(points, wp.array(corners.ravel(), dtype=wp.int32, device=self._device))
        self._vertices = wp.array(centred, dtype=wp.vec3d, device=self._device)
        self._triangles = wp.array(corners, dtype=wp.int32, device=self._device)
        self._reach = reach
        self._size = float(np.abs(centred).max())

    def find(self, points: FloatArray, facings: FloatArray) -> tuple[IntArray, FloatArray]:
        """The triangle closest to each point among those that face its way, and the weights of its corners.

        Args:
            points: shape (N, 3).
            facings: normal of the sheet that each point lies on, shape (N, 3).
        """
        count = len(points)
        triangle = wp.empty(count, dtype=wp.int32, device=self._device)
        weights = wp.empty(count, dtype=wp.vec3d, device=self._device)
        centred = points - self._origin
        # the last box, twice as large as needed, holds every triangle wherever the point is
        farthest = self._size + float(np.abs(centred).max(initial=0.0))
        doublings = max(1, int(np.ceil(np.log2(2.0 * farthest / self._reach))))
        position = wp.array(centred, dtype=wp.vec3d, device=self._device)
        facing = wp.array(facings, dtype=wp.vec3d, device=self._device)
        model = [self._mesh.id, self._vertices, self._triangles, self._reach, doublings]
        wp.launch(
            find_closest, count, inputs=[*model, position, facing], outputs=[triangle, weights], device=self._device
        )
        return triangle.numpy().astype(np.int64), weights.numpy().astype(np.float64)
