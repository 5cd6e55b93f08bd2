# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns as polylines, for pictures and for file formats without splines.

Each point of a polyline stores the segment and the control point from which it comes.
"""

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
    """Sampled curves: c curves with p points in total."""

    points: list[FloatArray]
    """Points of each curve [cm], shape (n, 3) each; a closed curve does not repeat its first point."""
    closed: list[bool]
    """Whether each curve is closed."""
    yarn: IntArray
    """Yarn of each curve, shape (c,)."""
    segment: IntArray
    """Segment of each point, curve by curve, shape (p,)."""
    control_point: IntArray
    """Nearest control point of each point, curve by curve, shape (p,)."""


def polylines_of_segments(yarns: YarnSet, segments: IntArray, samples: int) -> Polylines:
    """Sample some segments of a set of yarns; consecutive segments of one yarn become one curve.

    Args:
        yarns: the set of yarns.
        segments: numbers of the segments, ascending, at least one.
        samples: points per segment.
    """
    parameter = np.arange(samples) / samples
    corners = yarns.corners_of(segments)
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
    """First and end index, in ``segments``, of each run of consecutive segments of one yarn."""
    owner = yarns.segment_yarn[segments]
    breaks = np.flatnonzero((np.diff(segments) != 1) | (np.diff(owner) != 0)) + 1
    return pairwise([0, *breaks.tolist(), len(segments)])


def _is_whole_ring(yarns: YarnSet, segment: int, count: int) -> bool:
    """Whether a run of ``count`` segments from ``segment`` is a complete closed yarn without a lattice."""
    yarn = yarns.segment_yarn[segment]
    size = yarns.segment_start[yarn + 1] - yarns.segment_start[yarn]
    return bool(yarns.closed[yarn] and yarns.lattice is None and count == size)


def _with_end(values: NDArray, end: NDArray, whole: bool) -> NDArray:
    """Append the value at the end of a run, unless the run is a whole ring."""
    return values if whole else np.concatenate([values, end[None]])
