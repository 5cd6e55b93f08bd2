# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns as polylines, for pictures and for formats that hold no splines; each point knows where it comes from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn.yarn_set import YarnSet, basis


@dataclass(frozen=True)
class Polylines:
    """Sampled curves."""

    points: list[FloatArray]
    """Points of each curve [cm], shape (n, 3) each; the first of a closed one is not repeated."""
    closed: list[bool]
    """Whether each curve is closed."""
    yarn: IntArray
    """Yarn of each curve."""
    segment: IntArray
    """Segment of each point of all curves."""
    control_point: IntArray
    """Nearest control point of each point of all curves."""


def polylines_of_segments(yarns: YarnSet, segments: IntArray, samples: int) -> Polylines:
    """Sample some segments of a set, an unbroken run of segments to a curve.

    Args:
        yarns: the set.
        segments: numbers of the segments, ascending, at least one.
        samples: points to a segment.
    """
    parameter = np.arange(samples) / samples
    corners = yarns.points[yarns.segment_points[segments]]
    if yarns.point_shift is not None:
        corners = corners + yarns.point_shift[segments]
    points = np.einsum("kj,sjd->skd", basis(parameter), corners)
    ends = np.einsum("j,sjd->sd", basis(1.0)[0], corners)
    nearest = yarns.segment_points[segments][:, np.where(parameter < 0.5, 1, 2)]
    nearest_to_end = yarns.segment_points[segments][:, 2]
    curves, closed, starts, segment, control_point = [], [], [], [], []
    for first, last in _runs(yarns, segments):
        whole = _is_whole_ring(yarns, segments[first], last - first)
        curves.append(_with_end(points[first:last].reshape(-1, 3), ends[last - 1], whole))
        segment.append(_with_end(np.repeat(segments[first:last], samples), segments[last - 1], whole))
        control_point.append(_with_end(nearest[first:last].ravel(), nearest_to_end[last - 1], whole))
        closed.append(whole)
        starts.append(segments[first])
    return Polylines(curves, closed, yarns.segment_yarn[starts], np.concatenate(segment), np.concatenate(control_point))


def _runs(yarns: YarnSet, segments: IntArray) -> Iterator[tuple[int, int]]:
    owner = yarns.segment_yarn[segments]
    breaks = np.flatnonzero((np.diff(segments) != 1) | (np.diff(owner) != 0)) + 1
    return pairwise([0, *breaks.tolist(), len(segments)])


def _is_whole_ring(yarns: YarnSet, segment: int, count: int) -> bool:
    yarn = yarns.segment_yarn[segment]
    size = yarns.segment_start[yarn + 1] - yarns.segment_start[yarn]
    return bool(yarns.closed[yarn] and yarns.lattice is None and count == size)


def _with_end(values: NDArray, end: NDArray, whole: bool) -> NDArray:
    return values if whole else np.concatenate([values, end[None]])
