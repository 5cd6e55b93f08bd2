# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Crossings of yarn through yarn along a deformation path.

The path is sampled at equal times. Between two of these times the ends of edges move on straight lines. The crossings
of each two edges are counted exactly (``moving_edges``). The points count as displaced into general position
(``general_position``), by the same displacement at all times. The signs of the crossings of two closed curves therefore
add up to the change of their linking number, whatever the rounding. The sign of a yarn crossing is 1 where a
right-handed crossing becomes a left-handed one.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.lattice import Lattice
from stitchmesh.linking.deformation_path import DeformationPath
from stitchmesh.linking.general_position import DISPLACEMENT, FEWEST_UNITS, WholeUnits, displacements
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
    crossings: list[YarnCrossing]
    """All crossings in the order of time."""

    @classmethod
    def along(cls, path: DeformationPath) -> SampledPath:
        """Sample a deformation path and find all crossings on it.

        Raises:
            NotInGeneralPosition: no displacement brought the edges into general position.
        """
        states = [path.at(moment / MOMENTS) for moment in range(MOMENTS + 1)]
        for seed in range(ATTEMPTS - 1):
            try:
                return cls._displaced(states, seed)
            except NotInGeneralPosition:
                continue
        return cls._displaced(states, ATTEMPTS - 1)

    @classmethod
    def _displaced(cls, states: list[YarnSet], seed: int) -> SampledPath:
        """The sampled path of points that are moved by random displacements."""
        polylines, radius = YarnPolylines(states[0]), float(states[-1].radius.mean())
        points = [sampled_points(state) for state in states]
        units = _units(points, states)
        moved = displacements(len(points[0]), max(DISPLACEMENT * radius, FEWEST_UNITS * units.unit), seed)
        ends = [
            EdgeEnds.at(polylines, units.rounded(place + moved), units.rounded_lattice(state.lattice))
            for place, state in zip(points, states, strict=True)
        ]
        crossings = [
            crossing
            for moment, (begin, end) in enumerate(pairwise(ends))
            for crossing in _crossings_between(polylines, begin, end, units, moment)
        ]
        return cls(polylines, radius, ends, crossings)

    def at(self, time: float) -> EdgeEnds:
        """Ends of the edges at a time from 0 to 1."""
        moment = min(int(time * MOMENTS), MOMENTS - 1)
        part = time * MOMENTS - moment
        before, after = self.ends[moment : moment + 2]
        lattice = None
        if before.lattice is not None and after.lattice is not None:
            lattice = Lattice((1 - part) * before.lattice.periods + part * after.lattice.periods)
        return EdgeEnds(
            (1 - part) * before.first + part * after.first, (1 - part) * before.second + part * after.second, lattice
        )


def _units(points: list[FloatArray], states: list[YarnSet]) -> WholeUnits:
    """The unit of all coordinates."""
    periods = [np.abs(state.lattice.periods).sum() for state in states if state.lattice is not None]
    return WholeUnits.fitting(float(max(np.abs(place).max() for place in points) + max(periods, default=0.0)))


def _crossings_between(
    polylines: YarnPolylines, begin: EdgeEnds, end: EdgeEnds, units: WholeUnits, moment: int
) -> list[YarnCrossing]:
    """Crossings of edges that move on straight lines from one sampled time to the next, in the order of time."""
    pairs = _without_shared_ends(polylines, _overlapping_boxes(begin, end, units))
    i, j, image = pairs[:, 0], pairs[:, 1], pairs[:, 2:]
    moving = EdgePairs(
        u=np.stack([ends.second[i] - ends.first[i] for ends in (begin, end)]),
        v=np.stack([ends.second[j] - ends.first[j] for ends in (begin, end)]),
        w=np.stack([ends.first[j] + ends.shift(image) - ends.first[i] for ends in (begin, end)]),
    )
    found = edge_crossings(moving, units.unit)
    starts = polylines.edges[pairs[found.pair, :2]].tolist()
    times = (moment / MOMENTS + 1.0 / MOMENTS * found.time).tolist()
    crossings = [
        YarnCrossing(first, second, (a, b), time, sign)
        for (first, second), (a, b), time, sign in zip(
            starts, image[found.pair].tolist(), times, found.sign.tolist(), strict=True
        )
    ]
    return sorted(crossings, key=lambda each: (each.time, each.first, each.second, each.image))


def _overlapping_boxes(begin: EdgeEnds, end: EdgeEnds, units: WholeUnits) -> IntArray:
    """Pairs of edges whose swept boxes overlap, and the lattice image of the second edge, shape (n, 4).

    The mean motion of all edges, which makes no crossings, is subtracted, in whole units.
    """
    images, count = _near_images(begin, end), len(begin.first)
    on = begin.shift(images)[:, None]
    back = end.shift(images)[:, None] - units.rounded((end.first - begin.first).mean(axis=0))
    corners = [begin.first + on, begin.second + on, end.first + back, end.second + back]
    low, high = (bound.reduce(corners).reshape(-1, 3) for bound in (np.minimum, np.maximum))
    near = np.flatnonzero(((low <= high[:count].max(axis=0)) & (high >= low[:count].min(axis=0))).all(axis=1))
    low, high = low[near], high[near]
    reach = float((high - low).max())
    i, j = cKDTree((low + high) / 2).query_pairs(reach, p=np.inf, output_type="ndarray").T
    i, j = i[i < count], j[i < count]
    for lower, upper in zip(np.ascontiguousarray(low.T), np.ascontiguousarray(high.T), strict=True):
        overlap = (lower[i] <= upper[j]) & (lower[j] <= upper[i])
        i, j = i[overlap], j[overlap]
    return np.column_stack([i, near[j] % count, images[near[j] // count]])


def _near_images(begin: EdgeEnds, end: EdgeEnds) -> IntArray:
    """Lattice images in which edges may come near each other, (0, 0) first, shape (m, 2).

    Of two opposite images only one is returned.
    """
    if begin.lattice is None or end.lattice is None:
        return np.zeros((1, 2), dtype=np.int64)
    moved = np.concatenate([end.first - begin.first, end.second - begin.second])
    reach = 2.0 * float(np.linalg.norm(moved - moved.mean(axis=0), axis=1).max())
    found = [
        image
        for lattice, ends in ((begin.lattice, begin), (end.lattice, end))
        for image in lattice.near_images(np.concatenate([ends.first, ends.second]), reach).tolist()
    ]
    return np.array(sorted({(a, b) for a, b in found if (a, b) >= (0, 0)}), dtype=np.int64)


def _without_shared_ends(polylines: YarnPolylines, pairs: IntArray) -> IntArray:
    """Pairs of edges that have no common end and are not an edge and its own image.

    An edge and its own image are parallel at all times.
    """
    (i, j), image = polylines.edges[pairs[:, :2].T], pairs[:, 2:]
    after, step = polylines.next_point, polylines.next_image
    shares = i == j
    shares |= (after[i] == j) & (step[i] == image).all(axis=1)
    shares |= (after[j] == i) & (step[j] == -image).all(axis=1)
    return pairs[~shares]
