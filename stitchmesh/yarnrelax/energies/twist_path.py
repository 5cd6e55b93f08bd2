# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Order of the chords along each yarn, including its clamped ends, and their division into strands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, first_few
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.model.constants import Model


@dataclass(frozen=True, eq=False)
class Path:
    """The chords of all yarns on the device: one for each segment, and after these two clamps for each yarn."""

    before: wp.array[Any]
    """Chord before the chord of each segment, shape (S,)."""
    after: wp.array[Any]
    """Chord after the chord of each segment, shape (S,)."""
    strand_start: wp.array[Any]
    """Where each strand's segments start, shape (K + 1,)."""
    yarn_strand: wp.array[Any]
    """Where each yarn's strands start, shape (Y + 1,)."""
    yarn_start: wp.array[Any]
    """Where each yarn's segments start, shape (Y + 1,)."""
    closing: wp.array[Any]
    """Rotation from the last clamp of each open yarn to the first, as quaternions, shape (Y, 4)."""
    chord: wp.array[Any]
    """The chords [units], and then the clamps as unit vectors, shape (S + 2 Y, 3)."""
    strand_turn: wp.array[Any]
    """Product of each strand's rotations, as quaternions, shape (K, 4)."""


def put_path(model: Model) -> Path:
    """Send the order of the chords and the clamps to the device.

    Raises:
        ParameterError: the end of an open yarn has no direction.
    """
    yarns = model.yarns
    clamp = end_tangents(yarns)
    segments, count = model.segment_count, yarns.yarn_count
    first, last = yarns.segment_start[:-1], yarns.segment_start[1:] - 1
    before, after = np.arange(segments) - 1, np.arange(segments) + 1
    before[first] = np.where(yarns.closed, last, segments + 2 * np.arange(count))
    after[last] = np.where(yarns.closed, first, segments + 2 * np.arange(count) + 1)
    strand_start, yarn_strand = _strands(yarns.segment_start)
    closing = np.where(yarns.closed[:, None], [0.0, 0.0, 0.0, 1.0], smallest_rotations(clamp[:, 1], clamp[:, 0]))
    return Path(
        before=model.integers(before),
        after=model.integers(after),
        strand_start=model.integers(strand_start),
        yarn_strand=model.integers(yarn_strand),
        yarn_start=model.integers(yarns.segment_start),
        closing=wp.array(closing, dtype=wp.quatd, device=model.device),
        chord=model.upload(np.concatenate([np.zeros((segments, 3)), clamp.reshape(-1, 3)]), 3),
        strand_turn=wp.zeros(len(strand_start) - 1, dtype=wp.quatd, device=model.device),
    )


def end_tangents(yarns: YarnSet) -> NDArray[np.float64]:
    """Unit tangents at the two ends of each yarn as it lies, shape (Y, 2, 3); for closed yarns they mean nothing.

    Raises:
        ParameterError: the end of an open yarn has no direction.
    """
    first, last = yarns.start[:-1], yarns.start[1:] - 1
    tangent = np.stack([yarns.points[first + 2] - yarns.points[first], yarns.points[last] - yarns.points[last - 2]], 1)
    length = np.linalg.norm(tangent, axis=2, keepdims=True)
    bad = np.flatnonzero((length == 0.0).any(axis=(1, 2)) & ~yarns.closed)
    if len(bad):
        raise ParameterError(f"twist: an end of yarn {first_few(bad)} has no direction; move its control points apart")
    return tangent / np.where(length > 0.0, length, 1.0)


def smallest_rotations(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Quaternions (x, y, z, w) that take unit vectors to others; half turns about some axis if they are opposite."""
    scalar = 1.0 + (first * second).sum(axis=1, keepdims=True)
    axis = np.cross(first, second)
    # at right angles to the first vector: its product with the coordinate axis from which it is farthest
    aside = np.cross(first, np.eye(3)[np.abs(first).argmin(axis=1)])
    opposite = scalar < 1e-9
    turn = np.concatenate([np.where(opposite, aside, axis), np.where(opposite, 0.0, scalar)], axis=1)
    return turn / np.linalg.norm(turn, axis=1, keepdims=True)


def _strands(segment_start: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the first segment of each strand, and the first strand of each yarn."""
    counts = np.diff(segment_start)
    size = np.maximum(np.ceil(np.sqrt(counts)).astype(np.int64), 32)  # the shortest strand
    strands = -(-counts // size)
    yarn_strand = np.concatenate([[0], np.cumsum(strands)])
    place = np.arange(yarn_strand[-1]) - np.repeat(yarn_strand[:-1], strands)
    start = np.repeat(segment_start[:-1], strands) + place * np.repeat(size, strands)
    return np.concatenate([start, segment_start[-1:]]), yarn_strand
