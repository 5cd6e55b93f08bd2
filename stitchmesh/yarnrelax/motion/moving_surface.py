# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The surface of a moving body on the device, at one time.

Between two frames the corners move along straight lines. Outward directions follow from the corners by the formulas of
``mesh_features``, in the same order of sums, and the tree of boxes is fitted to them.

``travel`` is a bound of the distance that any point of the surface has moved since the start. A distance from the
surface that was measured at an earlier travel is wrong by no more than the difference.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.vertex_motion import MovingMesh
from stitchmesh.yarnrelax.energies.body_surface import single, surface_of
from stitchmesh.yarnrelax.energies.mesh_features import FeatureTopology, feature_topology, features_at
from stitchmesh.yarnrelax.model.constants import Model


@wp.func
def unit_of(along: Any) -> Any:
    """The vector of length one; zero if its length is zero."""
    length = wp.length(along)
    if length > type(length)(1.0e-12):
        return along / length
    return along - along


@kernel
def place_triangles(
    # model
    before: wp.array[Any],
    after: wp.array[Any],
    part: Any,
    # state out
    corners: wp.array[Any],
    tree_points: wp.array[wp.vec3],
    outward: wp.array[Any],
) -> None:
    """Move the corners of each triangle to a part of the way between two frames, and find its normal."""
    t = wp.tid()
    for k in range(3):
        here = before[3 * t + k] + (after[3 * t + k] - before[3 * t + k]) * part
        if part == type(part)(1.0):
            here = after[3 * t + k]
        corners[3 * t + k] = here
        tree_points[3 * t + k] = single(here)
    start = corners[3 * t]
    outward[7 * t] = unit_of(wp.cross(corners[3 * t + 1] - start, corners[3 * t + 2] - start))


@kernel
def place_outward(
    # model
    edge_triangle: wp.array[wp.vec3i],
    around_start: wp.array[wp.int32],
    around: wp.array[wp.int32],
    place: wp.array[wp.int32],
    on_border: wp.array[wp.int32],
    # state in
    corners: wp.array[Any],
    # state out
    outward: wp.array[Any],
) -> None:
    """Outward directions of the edges and the corners of each triangle."""
    t = wp.tid()
    across = edge_triangle[t]
    for k in range(3):
        of_edge = type(outward[0])()
        if across[k] >= 0:
            of_edge = outward[7 * wp.min(t, across[k])] + outward[7 * wp.max(t, across[k])]
        outward[7 * t + 1 + k] = unit_of(of_edge)
        p = place[3 * t + k]
        of_corner = type(outward[0])()
        if on_border[p] == 0:
            for n in range(around_start[p], around_start[p + 1]):
                c = around[n]
                o = c // 3
                here = corners[c]
                ahead = corners[3 * o + (c + 1) % 3] - here
                behind = corners[3 * o + (c + 2) % 3] - here
                angle = wp.atan2(wp.length(wp.cross(ahead, behind)), wp.dot(ahead, behind))
                of_corner += outward[7 * o] * angle
        outward[7 * t + 4 + k] = unit_of(of_corner)


class MovingSurface:
    """The surface of a moving body on the device of a model."""

    def __init__(self, model: Model, moving: MovingMesh) -> None:
        """Put the surface where it is at the first time."""
        self.model, self.motion = model, moving.motion
        self.topology = feature_topology(moving.mesh)
        features = features_at(self.topology, model.to_device(moving.mesh.vertices))
        self.triangle_count = len(features.corners)
        self._surface = surface_of(features, model.scalar, model.device)
        self.constants = self._surface.constants
        """The struct that kernels receive."""
        self.travel = model.empty(1)
        """Bound of the distance that the surface has moved [units], an array of one number."""
        self._tables = _neighbour_tables(model, self.topology)
        self._moves = bool((self.motion.vertices != self.motion.vertices[0]).any())
        self._interval, self._time = -1, float(self.motion.times[0])
        self._speed = self._moved = 0.0
        self._ends: list[wp.array[Any]] = []

    def speed(self, begin: float, end: float) -> float:
        """Largest mean speed of a vertex between two times of one interval [units / s]."""
        apart = self.motion.vertices_at(end) - self.motion.vertices_at(begin)
        return float(np.linalg.norm(apart, axis=1).max()) / (end - begin) / self.model.unit

    def move_to(self, time: float) -> None:
        """Move the surface to a time [s]; a surface that does not move keeps all its bits."""
        if not self._moves or time == self._time:
            return
        times = self.motion.times
        interval = int(np.clip(np.searchsorted(times, time), 1, len(times) - 1)) - 1
        if interval != self._interval:
            self._begin_interval(interval)
        elif self._speed == 0.0:
            return
        self._moved += self._speed * abs(time - self._time)
        self._time = time
        self.travel.fill_(self.model.number(self._moved))
        begin, end = float(times[interval]), float(times[interval + 1])
        self._place(min(max((time - begin) / (end - begin), 0.0), 1.0))

    def forget_travel(self) -> None:
        """Count the travel from here; distances that were measured before are no longer used."""
        self._moved = 0.0
        self.travel.zero_()

    def _begin_interval(self, interval: int) -> None:
        motion, times = self.motion, self.motion.times
        self._interval = interval
        self._speed = self.speed(float(times[interval]), float(times[interval + 1]))
        self._ends = [self._corners(motion.vertices[interval + k]) for k in range(2)]

    def _corners(self, vertices: FloatArray) -> wp.array[Any]:
        return self.model.upload(self.model.to_device(vertices)[self.topology.corner].reshape(-1, 3), 3)

    def _place(self, part: float) -> None:
        surface, count = self.constants, self.triangle_count
        points = self._surface.tree.points
        inputs = [*self._ends, self.model.number(part)]
        self.model.launch(place_triangles, count, inputs, [surface.corners, points, surface.outward])
        self.model.launch(place_outward, count, [*self._tables, surface.corners], [surface.outward])
        self._surface.tree.refit()


def _neighbour_tables(model: Model, topology: FeatureTopology) -> list[wp.array[Any]]:
    """For each triangle the triangles across its edges, -1 at a border; for each place the corners around it.

    Returns:
        Triangles across edges, starts of the corners of a place, the corners, the place of each corner, and 1 for each
        place on a border.
    """
    edges, places = topology.edge.ravel(), topology.place.ravel()
    across = _other_of_pairs(edges) // 3
    border = np.zeros(places.max() + 1, dtype=np.int64)
    border[topology.ends.reshape(-1, 2)[across < 0].ravel()] = 1
    around = np.argsort(places, kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(places))])
    triangles = wp.array(across.reshape(-1, 3).astype(np.int32), dtype=wp.vec3i, device=model.device)
    return [triangles, *(model.integers(values) for values in (start, around, places, border))]


def _other_of_pairs(numbers: IntArray) -> IntArray:
    """For each entry the index of the other entry with the same number; -1 if there is none."""
    order = np.argsort(numbers, kind="stable")
    alike = numbers[order][1:] == numbers[order][:-1]
    other = np.full(len(numbers), -1, dtype=np.int64)
    other[order[1:][alike]] = order[:-1][alike]
    other[order[:-1][alike]] = order[1:][alike]
    return other
