# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn radius of curves that come without one, estimated from how closely they lie.

Where two strands touch, the distance from one to the nearest point of the other has a local minimum along the yarn,
and in a fabric most of these minima are contacts: they cluster at twice the radius. Half their lower quartile is the
estimate; the quartile, because some minima are strands that pass without touching, and those are farther apart.
Yarns press into each other, so an estimate is rather too small than too large: by up to 8 % for garments at rest, more
for yarn too thick for its stitches, and by 16 to 18 % for yarns as generated, where loops cross closer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn.yarn_set import YarnSet

SAMPLES_PER_SEGMENT = 4
"""Chords between them cut the bends of a loop drawn in 16 segments by a hundredth of the radius."""
STRETCH = 64
"""Samples in a row that are looked at together: several contacts of a knitted loop."""
MOST_STRETCHES = 1200
"""Stretches looked at in a large set; another choice of them changes the estimate by half a per cent."""
SEED = 20_240_607
NEIGHBOURS = 64
"""Nearest samples looked at around each."""
THINNINGS = (1, 4, 16, 64)
"""Where a yarn's own samples lie so densely that they hide the other strands, every fourth is looked at, and so on."""
DETOUR = 3.0
"""Points of one yarn are neighbours unless the way along it is this much longer than the way across; on half a
circle it is 1.6 times as long."""
TOUCHING = 0.25
"""Quantile of the local minima that counts as touching."""


def estimate_radius(yarns: YarnSet) -> float:
    """Half the distance [cm] at which strands typically touch, the same for all yarns; their ``radius`` is not read.

    Args:
        yarns: curves in contact with each other or with other parts of themselves.

    Raises:
        ParameterError: no strand comes near another.
    """
    samples = _sampled(yarns)
    minima = _local_minima(samples, _stretches(len(samples.points)))
    if len(minima) == 0:
        raise ParameterError(
            "yarn radius: the yarns never come close to each other, so it cannot be estimated; give it (--yarn-radius)"
        )
    return float(np.quantile(minima, TOUCHING)) / 2


@dataclass(frozen=True, eq=False)
class _Samples:
    """Points along yarns, one yarn after the other."""

    points: FloatArray
    """[cm], shape (n, 3)."""
    yarn: IntArray
    """Yarn of each, shape (n,)."""
    along: FloatArray
    """Way along its yarn to each [cm], shape (n,)."""
    around: FloatArray
    """Way around each yarn [cm], endless for an open one, shape (Y,)."""

    def thinned(self, by: int) -> _Samples:
        """Every ``by``-th sample."""
        return _Samples(self.points[::by], self.yarn[::by], self.along[::by], self.around)


def _sampled(yarns: YarnSet) -> _Samples:
    curves = yarns.sampled(SAMPLES_PER_SEGMENT)
    points = np.concatenate(curves)
    yarn = np.repeat(np.arange(len(curves)), [len(curve) for curve in curves])
    steps = np.linalg.norm(np.diff(points, axis=0, prepend=points[:1]), axis=1)
    first = np.searchsorted(yarn, np.arange(len(curves)))
    steps[first] = 0.0
    total = np.cumsum(steps)
    last = np.append(first[1:], len(points)) - 1
    closing = np.linalg.norm(points[first] - points[last], axis=1)
    around = np.where(yarns.closed, total[last] - total[first] + closing, np.inf)
    return _Samples(points, yarn, total - total[first][yarn], around)


def _stretches(count: int) -> IntArray:
    """Samples to look at, in stretches along the yarns, shape (stretches, samples); all of them in a small set."""
    length = min(STRETCH, count)
    first = np.arange(0, count - length + 1, max(length - 2, 1))  # minima are sought inside a stretch
    if len(first) > MOST_STRETCHES:
        first = np.sort(np.random.default_rng(SEED).choice(first, MOST_STRETCHES, replace=False))
    return first[:, None] + np.arange(length)


def _local_minima(samples: _Samples, stretches: IntArray) -> FloatArray:
    """Distances to the nearest other strand where they are smallest along a yarn [cm], in no order."""
    distance = _nearest_strand(samples, stretches.ravel()).reshape(stretches.shape)
    before, here, after = distance[:, :-2], distance[:, 1:-1], distance[:, 2:]
    on_one_yarn = samples.yarn[stretches[:, :-2]] == samples.yarn[stretches[:, 2:]]
    smallest = on_one_yarn & (here <= before) & (here <= after)
    return here[smallest & np.isfinite(here) & (here > 0.0)]


def _nearest_strand(samples: _Samples, queries: IntArray) -> FloatArray:
    """Distance from each sample asked for to the nearest strand that is not its own neighbourhood [cm], else inf."""
    distance = np.full(len(queries), np.inf)
    for thinning in THINNINGS:
        others, left = samples.thinned(thinning), np.flatnonzero(np.isinf(distance))
        distance[left] = _nearest_among(others, samples, queries[left])
        if len(others.points) <= NEIGHBOURS:
            break  # all of them were looked at
    return distance


def _nearest_among(others: _Samples, samples: _Samples, queries: IntArray) -> FloatArray:
    """Distance from each sample asked for to the nearest strand among others [cm]; inf where its own hides it."""
    from scipy.spatial import cKDTree

    here = samples.points[queries]
    across, found = cKDTree(others.points).query(here, k=min(NEIGHBOURS, len(others.points)))
    way = np.abs(others.along[found] - samples.along[queries][:, None])
    way = np.minimum(way, samples.around[samples.yarn[queries]][:, None] - way)
    apart = (others.yarn[found] != samples.yarn[queries][:, None]) | (way > DETOUR * across)
    first = apart.argmax(axis=1)[:, None]
    nearest = np.take_along_axis(found, first, axis=1)[:, 0]
    return np.where(apart.any(axis=1), _distance_to_chords(others, here, nearest), np.inf)


def _distance_to_chords(samples: _Samples, here: FloatArray, nearest: IntArray) -> FloatArray:
    """Distance from each position to the two chords that meet in its nearest sample [cm]."""
    best = np.full(len(here), np.inf)
    start = samples.points[nearest]
    for step in (-1, 1):
        beside = np.clip(nearest + step, 0, len(samples.points) - 1)
        beside = np.where(samples.yarn[beside] == samples.yarn[nearest], beside, nearest)
        chord = samples.points[beside] - start
        square = np.maximum(np.einsum("ij,ij->i", chord, chord), np.finfo(np.float64).tiny)
        place = np.clip(np.einsum("ij,ij->i", here - start, chord) / square, 0.0, 1.0)
        best = np.minimum(best, np.linalg.norm(start + place[:, None] * chord - here, axis=1))
    return best
