# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The surface of a moving body on the device, at one time.

Between two frames the corners move along straight lines. Before each evaluation of forces, launches place them at the
time of the solver's clock. Outward directions follow from the corners by the formulas of ``mesh_features``, in the same
order of sums, and the tree of boxes is fitted to the corners. A surface that never moves launches nothing.

``travel`` is a bound of the distance that any point of the surface has moved since the last frame. If a distance from
the surface was measured at an earlier travel, its error is at most the difference of the travels.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3
from stitchmesh.mesh import IntArray
from stitchmesh.mesh.vertex_motion import MovingMesh
from stitchmesh.simulation.bodies.body_surface import single, surface_of
from stitchmesh.simulation.bodies.mesh_features import FeatureTopology, feature_topology, features_at
from stitchmesh.yarnrelax.model.constants import Model


@wp.func
def unit_of(along: Vec3) -> Any:
    """The vector of length one; zero if its length is zero."""
    length = wp.length(along)
    if length > type(length)(1.0e-12):
        return along / length
    return along - along


@wp.func
def part_of(interval: wp.array[wp.float64], clock: wp.array[wp.float64]) -> wp.float64:
    """Part of an interval (begin, end and speed) that has passed."""
    zero, one = wp.float64(0.0), wp.float64(1.0)
    return wp.clamp((clock[1] - interval[0]) / (interval[1] - interval[0]), zero, one)


@kernel
def place_triangles(
    # model
    before: wp.array[Vec3],
    after: wp.array[Vec3],
    interval: wp.array[wp.float64],
    # state in
    clock: wp.array[wp.float64],
    # state out
    corners: wp.array[Vec3],
    tree_points: wp.array[wp.vec3],
    outward: wp.array[Vec3],
    angle: wp.array[Scalar],
    travel: wp.array[Scalar],
) -> None:
    """Move the corners of each triangle to their places at a time between two frames; find normal and angles."""
    t = wp.tid()
    passed = part_of(interval, clock)
    part = type(travel[0])(passed)
    for k in range(3):
        here = before[3 * t + k] + (after[3 * t + k] - before[3 * t + k]) * part
        if passed == wp.float64(1.0):
            here = after[3 * t + k]
        corners[3 * t + k] = here
        tree_points[3 * t + k] = single(here)
    start = corners[3 * t]
    outward[7 * t] = unit_of(wp.cross(corners[3 * t + 1] - start, corners[3 * t + 2] - start))
    for k in range(3):
        ahead = corners[3 * t + (k + 1) % 3] - corners[3 * t + k]
        behind = corners[3 * t + (k + 2) % 3] - corners[3 * t + k]
        angle[3 * t + k] = wp.atan2(wp.length(wp.cross(ahead, behind)), wp.dot(ahead, behind))
    if t == 0:
        travel[0] = type(travel[0])(passed * (interval[1] - interval[0]) * interval[2])


@kernel
def place_outward(
    # model
    edge_triangle: wp.array[wp.vec3i],
    around_start: wp.array[wp.int32],
    around: wp.array[wp.int32],
    place: wp.array[wp.int32],
    on_border: wp.array[wp.int32],
    # state in
    angle: wp.array[Scalar],
    # state out
    outward: wp.array[Vec3],
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
                of_corner += outward[7 * (c // 3)] * angle[c]
        outward[7 * t + 4 + k] = unit_of(of_corner)


@dataclass(frozen=True, eq=False)
class Refit:
    """A launch that fits a tree of boxes to its points."""

    tree: wp.Mesh | wp.Bvh

    def launch(self) -> None:
        """Fit the tree."""
        self.tree.refit()


class MovingSurface:
    """The surface of a moving body on the device of a model."""

    def __init__(self, model: Model, moving: MovingMesh) -> None:
        """Put the surface on the device, at its first time."""
        self.model, self.motion = model, moving.motion
        self.topology = feature_topology(moving.mesh)
        features = features_at(self.topology, model.to_device(moving.motion.vertices[0]))
        self._surface = surface_of(features, model.scalar, model.device)
        self.constants = self._surface.constants
        """The struct that kernels receive."""
        self.travel = model.empty(1)
        """Bound of the distance that the surface has moved since the last frame [units], an array of one number."""
        self.angle = model.empty(len(self.constants.corners))
        """Angle of each triangle at each corner, shape (3 T,)."""
        self.clock = wp.zeros(2, dtype=wp.float64, device=model.device)
        """The clock of the solver, whose second number is the time [s]."""
        self._moves = bool((self.motion.vertices != self.motion.vertices[0]).any())
        self._tables = _neighbour_tables(model, self.topology)
        self._interval = wp.zeros(3, dtype=wp.float64, device=model.device)
        self._ends = [self._corners(0), self._corners(0)]

    def speed(self, frame: int) -> float:
        """Largest speed of a vertex between a frame and the next one [units / s]."""
        times, places = self.motion.times, self.motion.vertices
        apart = float(np.linalg.norm(places[frame + 1] - places[frame], axis=1).max())
        return apart / float(times[frame + 1] - times[frame]) / self.model.unit

    def begin(self, frame: int) -> None:
        """Let the surface move from a frame to the next one, and place it at the time of the clock."""
        times = self.motion.times
        self._interval.assign(np.array([times[frame], times[frame + 1], self.speed(frame)]))
        for k, end in enumerate(self._ends):
            wp.copy(end, self._corners(frame + k))
        self.place()

    def place(self) -> None:
        """Place the surface at the time of the clock."""
        for launch in self.launches(self.model.prepare):
            launch.launch()

    def launches(self, launcher: Launcher) -> list[Any]:
        """Return the prepared launches that place the surface at the time of the clock."""
        if not self._moves:
            return []
        surface, tree = self.constants, self._surface.tree
        count = len(surface.corners) // 3
        placed = [surface.corners, tree.points, surface.outward, self.angle, self.travel]
        return [
            launcher(place_triangles, count, [*self._ends, self._interval, self.clock], placed),
            launcher(place_outward, count, [*self._tables, self.angle], [surface.outward]),
            Refit(tree),
        ]

    def _corners(self, frame: int) -> wp.array[Any]:
        places = self.model.to_device(self.motion.vertices[frame])[self.topology.corner]
        return self.model.upload(places.reshape(-1, 3), 3)


def _neighbour_tables(model: Model, topology: FeatureTopology) -> list[wp.array[Any]]:
    """Return the triangles across the edges of each triangle, -1 at a border, and the corners around each place.

    Returns:
        Triangles across edges, the first corner of each place, the corners, the place of each corner, and 1 for each
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
    """Return for each entry the index of the other entry with the same number; -1 if there is none."""
    order = np.argsort(numbers, kind="stable")
    alike = numbers[order][1:] == numbers[order][:-1]
    other = np.full(len(numbers), -1, dtype=np.int64)
    other[order[1:][alike]] = order[:-1][alike]
    other[order[:-1][alike]] = order[1:][alike]
    return other
