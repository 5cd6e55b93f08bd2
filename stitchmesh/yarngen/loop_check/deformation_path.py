# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A way from yarns as drawn to the same yarns elsewhere, on which fabric turns as it bends.

On straight lines an edge that curls by half a turn would collapse on its way. So each place of the fabric has a
rotation, the best one of its neighbourhood (Kabsch 1976), and on the way it turns evenly. Rotations are vectors, axis
times angle, which go on from neighbour to neighbour, those that agree best first, past half turns and whole ones; then
they are evened out. Points close to one another are joined by edges, and at the time t an edge that is e at first and f
at last wants to be

    R(t) ((1 - t) e + t R(1)^-1 f),     R(t) = exp(t w),

with the mean rotation of its ends. Points lie where all edges are as they want to be in the mean of squares: a sparse
linear system, the same for all times (Alexa, Cohen-Or, Levin 2000). At both ends all of them are, whatever w is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csc_array, csr_array, diags_array, eye_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.sparse.linalg import SuperLU, splu
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.loop_check.general_position import DISPLACEMENT, displacements

NEIGHBOUR_JOINTS = 8
"""Nearest control points that each one is joined to, beside those along its yarn."""
ANCHOR_STIFFNESS = 1e-3
"""Stiffness that holds one point of each part in place, over that of an edge."""
COVARIANCE_BIAS = 1e-9 * np.array([[1.0, 0.01, -0.02], [-0.01, 1.1, 0.03], [0.02, -0.03, 1.2]])
"""Added to the covariance of a neighbourhood, over its norm, where points on a line leave the rotation open.

Nearly no rotation is preferred then; not being symmetric, it also decides in which sense a half turn goes.
"""
TIE_BREAK_ANGLE = 1e-6
"""Angle [rad] up to twice which neighbours agree equally well; which comes first is random, the same every time."""


@dataclass(frozen=True, eq=False)
class DeformationPath:
    """From yarns to the same yarns elsewhere."""

    begin: YarnSet
    """Where it begins."""
    end: YarnSet
    """Where it ends."""
    smoothing_steps: int
    """How often rotations are averaged with those of their neighbours."""
    neighbour_count: int
    """Control points that tell how a place has turned."""

    def at(self, time: float) -> YarnSet:
        """The yarns at a time from 0 to 1."""
        if time in (0.0, 1.0):
            return self.end if time else self.begin
        rotation = Rotation.from_rotvec(time * self._rotation).as_matrix()
        final_inverse = self._final_rotation
        target_edges = np.zeros_like(self._first_edges)
        for place in self._joints[:, :2].T:
            final = np.einsum("nji,nj->ni", final_inverse[place], self._last_edges)
            target_edges += 0.5 * np.einsum(
                "nij,nj->ni", rotation[place], (1.0 - time) * self._first_edges + time * final
            )
        points = self._system.solve(self._incidence.T @ (target_edges + self._shifts(time)))
        centres = (1.0 - time) * self._part_centres(self.begin.points) + time * self._part_centres(self.end.points)
        points += (centres - self._part_centres(points))[self._part]
        return replace(self.end, points=points, lattice=self._lattice(time))

    @cached_property
    def _part(self) -> IntArray:
        """Which of the parts that no joint connects each control point belongs to, shape (N,)."""
        part: IntArray = connected_components(self._incidence.T @ self._incidence, directed=False)[1]
        return part

    def _part_centres(self, points: FloatArray) -> FloatArray:
        """Mean position of each part [cm], shape (parts, 3)."""
        count = np.bincount(self._part)[:, None]
        return np.stack([np.bincount(self._part, values) for values in points.T], axis=1) / count

    def _lattice(self, time: float) -> Lattice | None:
        if self.begin.lattice is None or self.end.lattice is None:
            return None
        return Lattice((1.0 - time) * self.begin.lattice.periods + time * self.end.lattice.periods)

    def _shifts(self, time: float) -> FloatArray:
        """Lattice shift of the second end of each joint [cm], shape (J, 3)."""
        lattice = self._lattice(time)
        return np.zeros((len(self._joints), 3)) if lattice is None else lattice.shift(self._joints[:, 2:])

    @cached_property
    def _near(self) -> IntArray:
        """Nearest control points, itself first, and their images, shape (N, n, 3)."""
        lattice = self.begin.lattice
        largest = DISPLACEMENT * float(self.begin.radius.mean())
        points = self.begin.points + displacements(len(self.begin.points), largest)  # of equal distances one is less
        images = np.zeros((1, 2), dtype=np.int64)
        if lattice is not None:
            reach = 2.0 * np.sqrt(self.neighbour_count * lattice.area / len(points))
            images = lattice.near_images(points, reach)
        shift = np.zeros((len(images), 3)) if lattice is None else lattice.shift(images)
        count = min(self.neighbour_count, len(points) * len(images))
        copies = cKDTree((points + shift[:, None]).reshape(-1, 3))
        number = copies.query(points, k=count)[1].reshape(len(points), count)
        return np.concatenate([(number % len(points))[:, :, None], images[number // len(points)]], axis=2)

    @cached_property
    def _joints(self) -> IntArray:
        """Pairs of control points that are joined, and the image of the second one, shape (J, 4)."""
        near = self._near[:, 1 : NEIGHBOUR_JOINTS + 1]
        first = np.repeat(np.arange(len(near)), near.shape[1])
        pairs = np.concatenate([np.column_stack([first, near.reshape(-1, 3)]), *self._along_yarns()])
        over = (pairs[:, 0] > pairs[:, 1])[:, None]
        pairs = np.where(over, np.column_stack([pairs[:, 1], pairs[:, 0], -pairs[:, 2:]]), pairs)
        return np.unique(pairs, axis=0)

    def _along_yarns(self) -> list[IntArray]:
        """Control points that follow one another, as joints."""
        segments, yarns = self.begin.segment_points, self.begin
        step = yarns.lattice_step[yarns.segment_yarn] if yarns.lattice_step is not None else np.zeros((1, 2), np.int64)
        found = []
        for k in range(3):
            wrapped = (segments[:, k + 1] < segments[:, k])[:, None]
            image = np.where(wrapped, step, 0)
            found.append(np.column_stack([segments[:, k : k + 2], image]).astype(np.int64))
        return found

    def _edges(self, yarns: YarnSet) -> FloatArray:
        """From the second end of each joint to the first [cm], shape (J, 3)."""
        first, second = yarns.points[self._joints[:, :2].T]
        shift = 0.0 if yarns.lattice is None else yarns.lattice.shift(self._joints[:, 2:])
        edges: FloatArray = first - second - shift
        return edges

    @cached_property
    def _first_edges(self) -> FloatArray:
        return self._edges(self.begin)

    @cached_property
    def _last_edges(self) -> FloatArray:
        return self._edges(self.end)

    @cached_property
    def _incidence(self) -> csr_array:
        """1 and -1 at the ends of each joint, shape (J, N)."""
        count, joint = len(self._joints), np.arange(len(self._joints))
        values = np.concatenate([np.ones(count), -np.ones(count)])
        places = np.concatenate([joint, joint]), self._joints[:, :2].T.ravel()
        return coo_array((values, places), shape=(count, len(self.begin.points))).tocsr()

    @cached_property
    def _system(self) -> SuperLU:
        """The normal equations of all joints, factorised."""
        size = len(self.begin.points)
        anchored = np.zeros(size)
        anchored[np.unique(self._part, return_index=True)[1]] = ANCHOR_STIFFNESS
        matrix = csc_array(self._incidence.T @ self._incidence + diags_array(anchored))
        return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    @cached_property
    def _rotation(self) -> FloatArray:
        """By how much each place turns, axis times angle, shape (N, 3)."""
        vectors = _unwrapped(self._best_rotation(), self._joints[:, :2])
        if not self.smoothing_steps:
            return vectors
        first, second = self._joints[:, :2].T
        size = len(vectors)
        joined = coo_array((np.ones(len(first)), (first, second)), shape=(size, size)).tocsr()
        joined = joined + joined.T
        mean = diags_array(1.0 / np.maximum(joined.sum(axis=1), 1.0)) @ joined
        mixed = 0.5 * (mean + eye_array(size))
        for _ in range(self.smoothing_steps):
            vectors = mixed @ vectors
        return vectors

    @cached_property
    def _final_rotation(self) -> FloatArray:
        """At the end of the way, shape (N, 3, 3)."""
        matrices: FloatArray = Rotation.from_rotvec(self._rotation).as_matrix()
        return matrices

    def _best_rotation(self) -> FloatArray:
        """The best rotation of each neighbourhood, shape (N, 3, 3)."""
        places = []
        for yarns in (self.begin, self.end):
            near = yarns.points[self._near[:, :, 0]]
            near = near if yarns.lattice is None else near + yarns.lattice.shift(self._near[:, :, 1:])
            places.append(near - near.mean(axis=1, keepdims=True))
        covariance = np.einsum("nki,nkj->nij", places[1], places[0])
        covariance += np.linalg.norm(covariance, axis=(1, 2))[:, None, None] * COVARIANCE_BIAS
        left, _, right = np.linalg.svd(covariance)
        left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
        rotations: FloatArray = left @ right
        return rotations


def _unwrapped(rotations: FloatArray, joined: IntArray) -> FloatArray:
    """Rotations as vectors that go on from place to place, those that agree best first, shape (N, 3)."""
    first, second = joined[joined[:, 0] != joined[:, 1]].T
    between = Rotation.from_matrix(np.einsum("nji,njk->nik", rotations[first], rotations[second])).magnitude()
    size = len(rotations)
    between += np.random.default_rng(0).uniform(TIE_BREAK_ANGLE, 2.0 * TIE_BREAK_ANGLE, len(between))
    differences = coo_array((between, (first, second)), shape=(size, size)).tocsr()
    tree = minimum_spanning_tree(differences)
    tree = tree + tree.T
    vectors = Rotation.from_matrix(rotations).as_rotvec()
    order, before = breadth_first_order(tree, int(np.linalg.norm(vectors, axis=1).argmin()), directed=False)
    for place in order[1:].tolist():
        vectors[place] = _nearest_equivalent(vectors[place], vectors[before[place]])
    return vectors


def _nearest_equivalent(vector: FloatArray, other: FloatArray) -> FloatArray:
    """The same rotation with the whole turns that bring it closest to another."""
    angle = float(np.linalg.norm(vector))
    axis = vector / angle if angle > 1e-9 else other / max(float(np.linalg.norm(other)), 1e-9)
    turns = round((float(other @ axis) - angle) / (2.0 * np.pi))
    return axis * (angle + 2.0 * np.pi * turns)
