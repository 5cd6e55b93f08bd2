# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Estimate of the yarn radius from the curves of yarns, for files that do not store a radius.

Where two strands touch, the distance from a point of one strand to the nearest point of the other has a local minimum
along the yarn. In a fabric most of these minima are contacts, and their values are close to twice the radius. The
estimate is half the lower quartile of the minima. The quartile is used because some minima belong to strands that pass
without contact, at a larger distance.

Yarns press into each other, so that the estimate is usually too small: by up to 8 % for relaxed garments, by more for
yarn that is too thick for its stitches, and by 16 to 18 % for generated yarns before relaxation, where loops cross at
smaller distances.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn.yarn_set import YarnSet

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

SAMPLES_PER_SEGMENT = 4
"""Samples per segment; for a loop of 16 segments the chords between samples deviate by 1 % of the radius."""
WINDOW = 64
"""Consecutive samples in one window; a window spans several contacts of a knitted loop."""
MAX_WINDOWS = 1200
"""Number of windows that are evaluated in a large set; another random choice changes the estimate by 0.5 %."""
SEED = 20_240_607
"""Seed of the random choice of windows."""
NEIGHBOURS = 64
"""Number of nearest samples that are searched around each sample."""
BLOCK = 4096
"""Number of samples that are searched at once: each takes about 3 kB."""
STRIDES = (1, 4, 16, 64)
"""Strides of the samples to search. If all nearest samples belong to the same strand, the next stride is tried."""
MIN_DETOUR = 3.0
"""Two points of one yarn belong to different strands if their distance along the yarn is more than this factor times
their distance in space. For the two ends of half a circle the factor is 1.6, so that they belong to one strand."""


def estimate_radius(yarns: YarnSet) -> float:
    """Estimate one radius for all yarns [cm]: half the typical distance of strands in contact.

    Args:
        yarns: curves in contact with each other or with other parts of themselves; their ``radius`` is not used.

    Raises:
        ParameterError: no strand is close to another.
    """
    check_kind("estimate_radius", yarns, YarnSet)
    samples = _sample(yarns)
    minima = _local_minima(samples, _windows(len(samples.points)))
    if len(minima) == 0:
        raise ParameterError(
            "yarn radius: the yarns never come close to each other, so it cannot be estimated; give it (--yarn-radius)"
        )
    # A quarter of the places where strands are nearest to each other are surely contacts.
    return float(np.quantile(minima, 0.25)) / 2


@dataclass(frozen=True, eq=False)
class _Samples:
    """Points along yarns, yarn by yarn."""

    points: FloatArray
    """Positions [cm], shape (n, 3)."""
    yarn: IntArray
    """Yarn of each sample, shape (n,)."""
    arc_length: FloatArray
    """Length of the yarn from its first sample to each sample [cm], shape (n,)."""
    circumference: FloatArray
    """Length of each closed yarn [cm], infinite for an open yarn, shape (Y,)."""

    def chosen(self, which: slice | IntArray) -> _Samples:
        """Some of the samples."""
        return _Samples(self.points[which], self.yarn[which], self.arc_length[which], self.circumference)


def _sample(yarns: YarnSet) -> _Samples:
    """Sample all yarns with ``SAMPLES_PER_SEGMENT`` samples per segment."""
    curves = yarns.sampled(SAMPLES_PER_SEGMENT)
    points = np.concatenate(curves)
    yarn = np.repeat(np.arange(len(curves)), [len(curve) for curve in curves])
    steps = np.linalg.norm(np.diff(points, axis=0, prepend=points[:1]), axis=1)
    first = np.searchsorted(yarn, np.arange(len(curves)))
    steps[first] = 0.0
    total = np.cumsum(steps)
    last = np.append(first[1:], len(points)) - 1
    closing = np.linalg.norm(points[first] - points[last], axis=1)
    circumference = np.where(yarns.closed, total[last] - total[first] + closing, np.inf)
    return _Samples(points, yarn, total - total[first][yarn], circumference)


def _windows(count: int) -> IntArray:
    """Samples to evaluate, in windows of consecutive samples, shape (windows, samples); all samples in a small set."""
    length = min(WINDOW, count)
    # A minimum is searched among the inner samples of a window, so that windows overlap by two samples.
    first = np.arange(0, count - length + 1, max(length - 2, 1))
    if len(first) > MAX_WINDOWS:
        first = np.sort(np.random.default_rng(SEED).choice(first, MAX_WINDOWS, replace=False))
    return first[:, None] + np.arange(length)


def _local_minima(samples: _Samples, windows: IntArray) -> FloatArray:
    """Local minima along the yarn of the distance to the nearest other strand [cm], unordered."""
    distance = _nearest_strand(samples, windows.ravel()).reshape(windows.shape)
    before, here, after = distance[:, :-2], distance[:, 1:-1], distance[:, 2:]
    on_one_yarn = samples.yarn[windows[:, :-2]] == samples.yarn[windows[:, 2:]]
    smallest = on_one_yarn & (here <= before) & (here <= after)
    return here[smallest & np.isfinite(here) & (here > 0.0)]


def _nearest_strand(samples: _Samples, queries: IntArray) -> FloatArray:
    """Distance from each queried sample to the nearest other strand [cm], infinite if none is found, shape (q,)."""
    distance = np.full(len(queries), np.inf)
    for stride in STRIDES:
        others, left = samples.chosen(slice(None, None, stride)), np.flatnonzero(np.isinf(distance))
        distance[left] = _nearest_among(others, samples, queries[left])
        if len(others.points) <= NEIGHBOURS:
            break  # The search has covered all samples.
    return distance


def _nearest_among(others: _Samples, samples: _Samples, queries: IntArray) -> FloatArray:
    """Distance from each queried sample to the nearest other strand [cm], shape (q,)."""
    from scipy.spatial import cKDTree

    # A tree cannot divide points at one place, and would compare each sample with all of them.
    others = others.chosen(np.sort(np.unique(others.points, axis=0, return_index=True)[1]))
    tree, starts = cKDTree(others.points), range(0, len(queries), BLOCK)
    blocks = [_nearest_of_block(tree, others, samples, queries[start : start + BLOCK]) for start in starts]
    return np.concatenate(blocks) if blocks else np.zeros(0)


def _nearest_of_block(tree: cKDTree, others: _Samples, samples: _Samples, queries: IntArray) -> FloatArray:
    """Distance from each queried sample to the nearest other strand [cm], shape (q,).

    Args:
        tree: the points of the samples that are searched.
        others: these samples.
        samples: all samples.
        queries: indices of the queried samples in ``samples``, shape (q,).

    Returns:
        The distances; infinite if all nearest samples belong to the strand of the queried sample.
    """
    here = samples.points[queries]
    across, found = tree.query(here, k=min(NEIGHBOURS, len(others.points)))
    along = np.abs(others.arc_length[found] - samples.arc_length[queries][:, None])
    along = np.minimum(along, samples.circumference[samples.yarn[queries]][:, None] - along)
    is_other = (others.yarn[found] != samples.yarn[queries][:, None]) | (along > MIN_DETOUR * across)
    first = is_other.argmax(axis=1)[:, None]
    nearest = np.take_along_axis(found, first, axis=1)[:, 0]
    return np.where(is_other.any(axis=1), _distance_to_chords(others, here, nearest), np.inf)


def _distance_to_chords(samples: _Samples, here: FloatArray, nearest: IntArray) -> FloatArray:
    """Distance from each position to the two chords that meet at its nearest sample [cm], shape (q,)."""
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
