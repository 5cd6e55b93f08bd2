# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A continuous deformation of yarns into the same yarns at other positions, on which bent fabric rotates.

If each point moved on a straight line, an edge that rotates by half a turn would collapse to a point at half time. Each
place of the fabric therefore has a rotation: the best rotation of its neighbourhood (Kabsch 1976), reached at a
constant rate. Rotations are stored as vectors, axis times angle. The vectors are continued from neighbour to neighbour,
beginning with the pairs that agree best, so that angles above half a turn and above a whole turn are possible. Then
they are smoothed. Joints connect each point with its neighbours. A joint with the vector e at the start and f at the
end has at the time t the target vector

    R(t) ((1 - t) e + t R(1)^-1 f),     R(t) = exp(t w),

averaged over the rotations w of its two ends. The points are placed so that the mean square deviation of all joints
from their target vectors is smallest. This is a sparse linear system with the same matrix at all times (Alexa,
Cohen-Or, Levin 2000). At the start and at the end there is no deviation, whatever w is.
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
from stitchmesh.linking.general_position import DISPLACEMENT, displacements
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet

COVARIANCE_BIAS = 1e-9 * np.array([[1.0, 0.01, -0.02], [-0.01, 1.1, 0.03], [0.02, -0.03, 1.2]])
"""Added to the covariance of a neighbourhood, over its norm, where points on a line do not determine the rotation.

The bias then selects a rotation close to the identity. It is not symmetric, so it also determines the sense of a half
turn.
"""
TIE_BREAK_ANGLE = 1e-6
"""Angle [rad]; a random number from one to two times this angle is added to the angle between neighbours. It determines
the order of pairs that agree equally well, and is the same in every run."""


@dataclass(frozen=True, eq=False)
class DeformationPath:
    """A deformation of yarns into the same yarns at other positions."""

    begin: YarnSet
    """The yarns at time 0."""
    end: YarnSet
    """The yarns at time 1."""
    smoothing_steps: int
    """Number of times that rotations are averaged with the rotations of their neighbours."""
    neighbour_count: int
    """Number of control points from which each rotation is computed."""

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
        """Number of the connected part to which each control point belongs, shape (N,). No joints connect two parts."""
        part: IntArray = connected_components(self._incidence.T @ self._incidence, directed=False)[1]
        return part

    def _part_centres(self, points: FloatArray) -> FloatArray:
        """Mean position of each part [cm], shape (parts, 3)."""
        count = np.bincount(self._part)[:, None]
        return np.stack([np.bincount(self._part, values) for values in points.T], axis=1) / count

    def _lattice(self, time: float) -> Lattice | None:
        """The lattice at a time from 0 to 1, if the yarns have one."""
        if self.begin.lattice is None or self.end.lattice is None:
            return None
        return Lattice((1.0 - time) * self.begin.lattice.periods + time * self.end.lattice.periods)

    def _shifts(self, time: float) -> FloatArray:
        """Lattice shift of the second end of each joint [cm], shape (J, 3)."""
        lattice = self._lattice(time)
        return np.zeros((len(self._joints), 3)) if lattice is None else lattice.shift(self._joints[:, 2:])

    @cached_property
    def _near(self) -> IntArray:
        """Nearest control points of each control point, itself first, with their lattice images, shape (N, n, 3)."""
        lattice = self.begin.lattice
        largest = DISPLACEMENT * float(self.begin.radius.mean())
        points = self.begin.points + displacements(len(self.begin.points), largest)  # makes equal distances unequal
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
        """Pairs of control points that are joined, and the lattice image of the second one, shape (J, 4)."""
        # Number of nearest control points to which each control point has joints, besides its neighbours along the
        # yarn.
        near = self._near[:, 1 : 8 + 1]
        first = np.repeat(np.arange(len(near)), near.shape[1])
        pairs = np.concatenate([np.column_stack([first, near.reshape(-1, 3)]), *self._along_yarns()])
        over = (pairs[:, 0] > pairs[:, 1])[:, None]
        pairs = np.where(over, np.column_stack([pairs[:, 1], pairs[:, 0], -pairs[:, 2:]]), pairs)
        return np.unique(pairs, axis=0)

    def _along_yarns(self) -> list[IntArray]:
        """Joints between neighbouring control points of each yarn."""
        segments, yarns = self.begin.segment_points, self.begin
        step = yarns.lattice_step[yarns.segment_yarn] if yarns.lattice_step is not None else np.zeros((1, 2), np.int64)
        found = []
        for k in range(3):
            wrapped = (segments[:, k + 1] < segments[:, k])[:, None]
            image = np.where(wrapped, step, 0)
            found.append(np.column_stack([segments[:, k : k + 2], image]).astype(np.int64))
        return found

    def _edges(self, yarns: YarnSet) -> FloatArray:
        """Vector of each joint, from its second end to its first [cm], shape (J, 3)."""
        first, second = yarns.points[self._joints[:, :2].T]
        shift = 0.0 if yarns.lattice is None else yarns.lattice.shift(self._joints[:, 2:])
        edges: FloatArray = first - second - shift
        return edges

    @cached_property
    def _first_edges(self) -> FloatArray:
        """Vector of each joint at time 0 [cm], shape (J, 3)."""
        return self._edges(self.begin)

    @cached_property
    def _last_edges(self) -> FloatArray:
        """Vector of each joint at time 1 [cm], shape (J, 3)."""
        return self._edges(self.end)

    @cached_property
    def _incidence(self) -> csr_array:
        """Matrix with 1 and -1 at the ends of each joint, shape (J, N)."""
        count, joint = len(self._joints), np.arange(len(self._joints))
        values = np.concatenate([np.ones(count), -np.ones(count)])
        places = np.concatenate([joint, joint]), self._joints[:, :2].T.ravel()
        return coo_array((values, places), shape=(count, len(self.begin.points))).tocsr()

    @cached_property
    def _system(self) -> SuperLU:
        """Factorisation of the normal equations of all joints."""
        size = len(self.begin.points)
        anchored = np.zeros(size)
        # Stiffness that holds one point of each connected part in place, over the stiffness of a joint.
        anchored[np.unique(self._part, return_index=True)[1]] = 1e-3
        matrix = csc_array(self._incidence.T @ self._incidence + diags_array(anchored))
        return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    @cached_property
    def _rotation(self) -> FloatArray:
        """Rotation of each place from time 0 to time 1, axis times angle [rad], shape (N, 3)."""
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
        """Rotation matrices at time 1, shape (N, 3, 3)."""
        matrices: FloatArray = Rotation.from_rotvec(self._rotation).as_matrix()
        return matrices

    def _best_rotation(self) -> FloatArray:
        """Best rotation matrix of each neighbourhood, shape (N, 3, 3)."""
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
    """Rotation vectors that continue from place to place, beginning with the pairs that agree best, shape (N, 3).

    Args:
        rotations: rotation matrices, shape (N, 3, 3).
        joined: pairs of places, shape (J, 2).
    """
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
    """The vector of the same rotation, with whole turns added, that is nearest to another vector."""
    angle = float(np.linalg.norm(vector))
    axis = vector / angle if angle > 1e-9 else other / max(float(np.linalg.norm(other)), 1e-9)
    turns = round((float(other @ axis) - angle) / (2.0 * np.pi))
    return axis * (angle + 2.0 * np.pi * turns)
