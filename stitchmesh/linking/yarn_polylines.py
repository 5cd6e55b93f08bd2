# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns as polylines of sampled points.

Each control point has ``SAMPLES_PER_POINT`` sampled points; the first of them is at the knot of the control point.
Points are numbered along the yarn. In a closed yarn of n points, point k + n is point k one turn later; on a lattice it
is shifted by the lattice step of the yarn.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet, basis

SAMPLES_PER_POINT = 2
"""Number of sampled points for each control point. The yarn is cut at sampled points half way between control
points."""


def sampled_points(yarns: YarnSet) -> FloatArray:
    """Sampled points of all yarns [cm], shape (SAMPLES_PER_POINT N, 3).

    The ends of open yarns, which belong to no arc, are extended as straight lines.
    """
    first, last = yarns.start[:-1][yarns.point_yarn], yarns.start[1:][yarns.point_yarn] - 1
    place, size = np.arange(len(yarns.points)) - first, last - first + 1
    offset = place[:, None] + np.arange(-1, 3)
    wrapped_index, ends = offset % size[:, None], np.clip(offset, 0, size[:, None] - 1)
    control_points = yarns.points[
        first[:, None] + np.where(yarns.closed[yarns.point_yarn][:, None], wrapped_index, ends)
    ]
    if yarns.lattice is not None and yarns.lattice_step is not None:
        turns = np.where(yarns.closed[yarns.point_yarn][:, None], offset // size[:, None], 0)
        control_points = (
            control_points + turns[:, :, None] * yarns.lattice.shift(yarns.lattice_step)[yarns.point_yarn][:, None, :]
        )
    weights = basis(np.arange(SAMPLES_PER_POINT) / SAMPLES_PER_POINT)
    points: FloatArray = np.einsum("kj,njd->nkd", weights, control_points).reshape(-1, 3)
    return points


@dataclass(frozen=True, eq=False)
class YarnPolylines:
    """Polylines of yarns, and how each point continues in the next one."""

    yarns: YarnSet
    """The yarns to which the sampled points belong. The functions of this class do not require that the yarns are still
    at these positions."""

    @cached_property
    def start(self) -> IntArray:
        """Index of the first sampled point of each yarn, shape (Y + 1,)."""
        return self.yarns.start * SAMPLES_PER_POINT

    @cached_property
    def yarn(self) -> IntArray:
        """Yarn of each sampled point, shape (n,)."""
        return np.repeat(self.yarns.point_yarn, SAMPLES_PER_POINT)

    @cached_property
    def step(self) -> IntArray:
        """Lattice step of each yarn, shape (Y, 2)."""
        step = self.yarns.lattice_step
        return np.zeros((self.yarns.yarn_count, 2), dtype=np.int64) if step is None else step

    @cached_property
    def edges(self) -> IntArray:
        """Points at which edges start, shape (E,): all points except the last point of each open yarn."""
        ends = self.start[1:][~self.yarns.closed] - 1
        return np.setdiff1d(np.arange(self.start[-1]), ends)

    @cached_property
    def next_point(self) -> IntArray:
        """The next point after each point, shape (n,)."""
        after = np.arange(1, self.start[-1] + 1)
        after[self.start[1:] - 1] = self.start[:-1]
        return after

    @cached_property
    def next_image(self) -> IntArray:
        """Lattice image of the next point, seen from each point, shape (n, 2)."""
        image = np.zeros((self.start[-1], 2), dtype=np.int64)
        image[self.start[1:] - 1] = self.step
        return image

    @cached_property
    def arc_length(self) -> FloatArray:
        """Length of yarn up to each point and up to the end of the last yarn [cm], shape (n + 1,).

        The length is counted through all yarns, from the first point of the first yarn.
        """
        ends = EdgeEnds.of(self, self.yarns)
        length = np.linalg.norm(ends.second - ends.first, axis=1)
        each = np.zeros(self.start[-1])
        each[self.edges] = length
        return np.concatenate([[0.0], np.cumsum(each)])

    def distance(self, yarn: int, first: int, second: int) -> float:
        """Length of yarn between two points of a yarn, which may be several turns apart [cm].

        Args:
            yarn: number of the yarn.
            first: index of a point along the yarn.
            second: index of the other point along the yarn.
        """
        start, size = int(self.start[yarn]), int(self.start[yarn + 1] - self.start[yarn])
        turn = self.arc_length[start + size] - self.arc_length[start]
        a, b = (self.arc_length[start + k % size] + turn * (k // size) for k in (first, second))
        return float(abs(b - a))

    def wrapped(self, yarn: int, places: IntArray) -> tuple[IntArray, IntArray]:
        """Sampled points for indices along a yarn, which may be several turns apart.

        Args:
            yarn: number of the yarn.
            places: indices along the yarn, shape (n,).

        Returns:
            Numbers of the sampled points, shape (n,), and their lattice images, shape (n, 2).
        """
        start, size = self.start[yarn], self.start[yarn + 1] - self.start[yarn]
        return start + places % size, (places // size)[:, None] * self.step[yarn]


@dataclass(frozen=True, eq=False)
class EdgeEnds:
    """Both ends of each edge at one time."""

    first: FloatArray
    """First end of each edge [cm], shape (E, 3)."""
    second: FloatArray
    """Second end of each edge [cm], shape (E, 3)."""
    lattice: Lattice | None
    """The lattice at this time, if there is one."""

    @classmethod
    def of(cls, polylines: YarnPolylines, yarns: YarnSet) -> EdgeEnds:
        """Ends of the edges at the positions of ``yarns``."""
        return cls.at(polylines, sampled_points(yarns), yarns.lattice)

    @classmethod
    def at(cls, polylines: YarnPolylines, points: FloatArray, lattice: Lattice | None) -> EdgeEnds:
        """Ends of the edges at the given positions.

        Args:
            polylines: the polylines.
            points: positions of the sampled points [cm], shape (n, 3).
            lattice: the lattice at that time, if there is one.
        """
        edges = polylines.edges
        second = points[polylines.next_point[edges]]
        if lattice is not None:
            second = second + lattice.shift(polylines.next_image[edges])
        return cls(points[edges], second, lattice)

    def shift(self, image: ArrayLike) -> FloatArray:
        """Displacements of lattice images [cm], shape (..., 3); zero without a lattice."""
        if self.lattice is None:
            return np.zeros((*np.shape(image)[:-1], 3))
        return self.lattice.shift(image)
