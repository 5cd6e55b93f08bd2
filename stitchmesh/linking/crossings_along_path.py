# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Crossings of yarn through yarn along a deformation path.

The path is sampled at equal times. Between two of these times the ends of edges move on straight lines. The crossings
of each two edges are counted exactly (``moving_edges``). The points count as displaced into general position
(``deformation_path``), by the same displacement at all times. The signs of the crossings of two closed curves therefore
add up to the change of their linking number, whatever the rounding. The sign of a yarn crossing is 1 where a
right-handed crossing becomes a left-handed one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.lattice import Lattice
from stitchmesh.linking.deformation_path import (
    DISPLACEMENT,
    FEWEST_UNITS,
    DeformationPath,
    WholeUnits,
    displacements,
)
from stitchmesh.linking.moving_edges import EdgePairs, NotInGeneralPosition, edge_crossings
from stitchmesh.linking.yarn_polylines import EdgeEnds, YarnPolylines, sampled_points
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet

MOMENTS = 24
"""Number of equal intervals of time on a path. In each interval, edges move on straight lines."""
ATTEMPTS = 8
"""Number of random displacements that are tried. The first one is nearly always in general position."""


@dataclass(frozen=True)
class YarnCrossing:
    """A crossing of two edges: one yarn passes through another one, or through itself."""

    first: int
    """Sampled point at which the first edge starts."""
    second: int
    """Sampled point at which the second edge starts."""
    image: tuple[int, int]
    """Lattice image of the second edge, seen from the first."""
    time: float
    """Time of the crossing, from 0 to 1."""
    sign: int
    """1 where a right-handed crossing becomes a left-handed one, else -1."""


@dataclass(frozen=True, eq=False)
class SampledPath:
    """Yarns at equal times on a deformation path, and the crossings of yarn through yarn between these times."""

    polylines: YarnPolylines
    """The polylines of the yarns."""
    radius: float
    """Mean radius of the yarns [cm]."""
    ends: list[EdgeEnds]
    """Ends of the edges at each time, from 0 to 1 inclusive, in general position."""
    lattices: list[Lattice | None]
    """Lattice at each time."""
    crossings: list[YarnCrossing]
    """All crossings in the order of time."""

    @classmethod
    def along(cls, path: DeformationPath) -> SampledPath:
        """Sample a deformation path and find all crossings on it.

        Raises:
            NotInGeneralPosition: no displacement brought the edges into general position.
        """
        polylines = YarnPolylines(path.begin)
        states = [path.at(moment / MOMENTS) for moment in range(MOMENTS + 1)]
        for seed in range(ATTEMPTS - 1):
            try:
                return cls._displaced(polylines, states, seed)
            except NotInGeneralPosition:
                continue
        return cls._displaced(polylines, states, ATTEMPTS - 1)

    @classmethod
    def _displaced(cls, polylines: YarnPolylines, states: list[YarnSet], seed: int) -> SampledPath:
        """The sampled path of points that are moved by random displacements."""
        points = [sampled_points(state) for state in states]
        radius = float(states[-1].radius.mean())
        units = _units(points, states)
        moved = displacements(len(points[0]), max(DISPLACEMENT * radius, FEWEST_UNITS * units.unit), seed)
        lattices = [units.rounded_lattice(state.lattice) for state in states]
        places = [units.rounded(place + moved) for place in points]
        ends = [EdgeEnds.at(polylines, place, lattice) for place, lattice in zip(places, lattices, strict=True)]
        crossings: list[YarnCrossing] = []
        for moment in range(MOMENTS):
            (before, after), (begin, end) = lattices[moment : moment + 2], ends[moment : moment + 2]
            between = _EdgeMotions(polylines, units.unit, before, after, begin, end)
            crossings += between.crossings(moment / MOMENTS, 1.0 / MOMENTS)
        return cls(polylines, radius, ends, lattices, crossings)

    def at(self, time: float) -> tuple[EdgeEnds, Lattice | None]:
        """Ends of the edges and the lattice at a time from 0 to 1."""
        moment = min(int(time * MOMENTS), MOMENTS - 1)
        part = time * MOMENTS - moment
        before, after = self.ends[moment : moment + 2]
        ends = EdgeEnds(
            (1 - part) * before.first + part * after.first, (1 - part) * before.second + part * after.second
        )
        one, two = self.lattices[moment : moment + 2]
        return ends, None if one is None or two is None else Lattice((1 - part) * one.periods + part * two.periods)


def _units(points: list[FloatArray], states: list[YarnSet]) -> WholeUnits:
    """The unit of all coordinates."""
    periods = [np.abs(state.lattice.periods).sum() for state in states if state.lattice is not None]
    return WholeUnits.fitting(float(max(np.abs(place).max() for place in points) + max(periods, default=0.0)))


@dataclass(frozen=True, eq=False)
class _EdgeMotions:
    """Edges that move on straight lines between two times."""

    polylines: YarnPolylines
    """The polylines to which the edges belong."""
    unit: float
    """Unit of all coordinates [cm]."""
    before: Lattice | None
    """Lattice at the start."""
    after: Lattice | None
    """Lattice at the end."""
    begin: EdgeEnds
    """Ends of the edges at the start."""
    end: EdgeEnds
    """Ends of the edges at the end."""

    def crossings(self, begun: float, duration: float) -> list[YarnCrossing]:
        """Crossings in the order of time.

        Args:
            begun: start of the interval of time.
            duration: length of the interval of time.
        """
        pairs = self._without_shared_ends(self._overlapping_boxes())
        found = edge_crossings(self._edge_pairs(pairs), self.unit)
        starts = self.polylines.edges[pairs[found.pair, :2]].tolist()
        images, times, signs = pairs[found.pair, 2:].tolist(), found.time.tolist(), found.sign.tolist()
        crossings = [
            YarnCrossing(first, second, (image[0], image[1]), begun + duration * time, sign)
            for (first, second), image, time, sign in zip(starts, images, times, signs, strict=True)
        ]
        return sorted(crossings, key=lambda each: (each.time, each.first, each.second, each.image))

    def _overlapping_boxes(self) -> IntArray:
        """Pairs of edges whose swept boxes overlap, and the lattice image of the second edge, shape (n, 4).

        The mean motion of all edges is subtracted.
        """
        images = self._images()
        count = len(self.begin.first)
        low, high = (np.concatenate([bound(image) for image in images]) for bound in (self._lower, self._upper))
        near = np.flatnonzero(((low <= high[:count].max(axis=0)) & (high >= low[:count].min(axis=0))).all(axis=1))
        low, high = low[near], high[near]
        reach = float((high - low).max())
        i, j = cKDTree((low + high) / 2).query_pairs(reach, p=np.inf, output_type="ndarray").T
        i, j = i[i < count], j[i < count]
        for lower, upper in zip(np.ascontiguousarray(low.T), np.ascontiguousarray(high.T), strict=True):
            overlap = (lower[i] <= upper[j]) & (lower[j] <= upper[i])
            i, j = i[overlap], j[overlap]
        return np.column_stack([i, near[j] % count, images[near[j] // count]])

    def _images(self) -> IntArray:
        """Lattice images in which edges may come near each other, (0, 0) first, shape (m, 2).

        Of two opposite images only one is returned.
        """
        if self.before is None or self.after is None:
            return np.zeros((1, 2), dtype=np.int64)
        moved = np.concatenate([self.end.first - self.begin.first, self.end.second - self.begin.second])
        reach = 2.0 * float(np.linalg.norm(moved - moved.mean(axis=0), axis=1).max())
        found = [
            image
            for lattice, ends in ((self.before, self.begin), (self.after, self.end))
            for image in lattice.near_images(np.concatenate([ends.first, ends.second]), reach).tolist()
        ]
        return np.array(sorted({(a, b) for a, b in found if (a, b) >= (0, 0)}), dtype=np.int64)

    def _shifts(self, image: IntArray) -> list[FloatArray]:
        """Lattice shifts at both moments [cm], shape (..., 3)."""
        return [
            np.zeros((*np.shape(image)[:-1], 3)) if lattice is None else lattice.shift(image)
            for lattice in (self.before, self.after)
        ]

    def _lower(self, image: IntArray) -> FloatArray:
        """Lower corner of the box that each edge sweeps in a lattice image [cm], shape (E, 3)."""
        return np.minimum.reduce(self._corners(image))

    def _upper(self, image: IntArray) -> FloatArray:
        """Upper corner of the box that each edge sweeps in a lattice image [cm], shape (E, 3)."""
        return np.maximum.reduce(self._corners(image))

    def _corners(self, image: IntArray) -> list[FloatArray]:
        """Both ends of each edge in a lattice image, at the start and at the end [cm], four arrays of shape (E, 3)."""
        before, after = self._shifts(image)
        after = after - self._mean_motion
        return [self.begin.first + before, self.begin.second + before, self.end.first + after, self.end.second + after]

    @cached_property
    def _mean_motion(self) -> FloatArray:
        """Mean motion of all edges, which makes no crossings, in whole units [cm], shape (3,)."""
        return WholeUnits(self.unit).rounded((self.end.first - self.begin.first).mean(axis=0))

    def _without_shared_ends(self, pairs: IntArray) -> IntArray:
        """Pairs of edges that have no common end and are not an edge and its own image.

        An edge and its own image are parallel at all times.
        """
        (i, j), image = self.polylines.edges[pairs[:, :2].T], pairs[:, 2:]
        after, step = self.polylines.next_point, self.polylines.next_image
        shares = i == j
        shares |= (after[i] == j) & (step[i] == image).all(axis=1)
        shares |= (after[j] == i) & (step[j] == -image).all(axis=1)
        return pairs[~shares]

    def _edge_pairs(self, pairs: IntArray) -> EdgePairs:
        """The selected pairs as moving edges."""
        i, j = pairs[:, :2].T
        moments = list(zip((self.begin, self.end), self._shifts(pairs[:, 2:]), strict=True))
        return EdgePairs(
            u=np.stack([ends.second[i] - ends.first[i] for ends, _ in moments]),
            v=np.stack([ends.second[j] - ends.first[j] for ends, _ in moments]),
            w=np.stack([ends.first[j] + shift - ends.first[i] for ends, shift in moments]),
        )
