# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Closest points on those triangles whose orientation agrees with a given normal, on a CPU or on a GPU.

In some places of a garment two sheets of fabric are close to each other, for example the fingers of a glove, the sides
of a slit, or a sleeve and the body. Each query therefore contains the normal of its vertex's sheet, and only triangles
with a normal on the same side are candidates. Search boxes are in single precision, distances in double precision.
"""

from __future__ import annotations

import numpy as np
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.mesh import FloatArray, IntArray


@wp.func
def closest_weights(p: wp.vec3d, a: wp.vec3d, b: wp.vec3d, c: wp.vec3d) -> wp.vec3d:
    """Barycentric weights of a, b, c at the closest point of their triangle to p (Ericson 2005, section 5.1.5)."""
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
    """Search boxes of doubling size until a triangle is found; the last box accepts triangles of any orientation."""
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
    """Search for closest points on a fixed set of triangles."""

    def __init__(self, vertices: FloatArray, triangles: IntArray, reach: float, device: str | None) -> None:
        """Upload the triangles.

        Args:
            vertices: positions of the vertices [cm], shape (V, 3).
            triangles: vertices of each triangle, shape (T, 3).
            reach: half the size of the first search box [cm]; most points should find their triangle within it.
            device: Warp's name of the device; None for the first GPU, or the CPU if there is no GPU.

        Raises:
            ParameterError: there is no such device.
        """
        self._origin = vertices.mean(axis=0)  # Boxes in single precision are most accurate near the origin.
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
        """Find the closest triangle to each point among the triangles with a normal on the same side.

        Args:
            points: positions [cm], shape (N, 3).
            facings: normal of the sheet that each point belongs to, shape (N, 3).

        Returns:
            The triangle, shape (N,), and the barycentric weights of its corners, shape (N, 3), for each point.
        """
        count = len(points)
        triangle = wp.empty(count, dtype=wp.int32, device=self._device)
        weights = wp.empty(count, dtype=wp.vec3d, device=self._device)
        centred = points - self._origin
        # The last box is at least large enough to contain every triangle, whatever the position of the point.
        farthest = self._size + float(np.abs(centred).max(initial=0.0))
        doublings = max(1, int(np.ceil(np.log2(2.0 * farthest / self._reach))))
        position = wp.array(centred, dtype=wp.vec3d, device=self._device)
        facing = wp.array(facings, dtype=wp.vec3d, device=self._device)
        model = [self._mesh.id, self._vertices, self._triangles, self._reach, doublings]
        launch(find_closest, count, [*model, position, facing], [triangle, weights], self._device)
        return triangle.numpy().astype(np.int64), weights.numpy().astype(np.float64)
