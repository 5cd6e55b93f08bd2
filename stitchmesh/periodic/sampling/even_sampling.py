# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Other samplings of the same curves: control points at equal distances along the yarn, as it lies at rest.

Yarn without friction slides through its loops, and a spline is most accurate where its knots are equally far apart. The
state of rest of a fabric depends on the whole length of a yarn alone, not on its distribution over the segments. Each
yarn therefore gets segments of one rest length. With l_i the rest lengths of a yarn of n control points, the new knots
stand at the places

    u_k = -l_(n-1) / 2 + (k + 1/2) L / m        k = 0 .. m - 1,    L = sum of l_i

from the first control point: a yarn whose control points are symmetric about a point stays symmetric. The new spline
passes through the curve at these places (``control_points_through``). The first and the last knot of an open yarn stay
where they are.

Control points keep the stitches that made them. The yarn of a stitch is the yarn that its control points carry; it
equals the generated length up to the yarn between two control points.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.errors import YarnError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.yarn_set import basis
from stitchmesh.yarngen.splines import control_points_through


def sample_evenly(yarns: YarnSet, like: YarnSet | None = None) -> YarnSet:
    """Return the curves of yarns with equal lengths of yarn at rest between their control points.

    Generated yarns have shorter segments in some parts of a stitch than in others. A spline cannot have these rest
    lengths without local stretch, which costs energy and holds the stitches of a free fabric in their generated shape.

    Args:
        yarns: the yarns; the result has their curves, lengths, radii and lattice.
        like: the same yarns with other control points; the result has as many control points, and takes its stitches,
            rows and parts from them. None for the yarns themselves.

    Raises:
        YarnError: the yarns are not the same, or have a natural curvature.
    """
    like = yarns if like is None else like
    if not np.array_equal(yarns.closed, like.closed):
        raise YarnError(f"sampling: got {yarns.yarn_count} yarns and {like.yarn_count} others; expected the same yarns")
    if (yarns.natural_curvature != 0.0).any():
        raise YarnError("sampling: got yarns with a natural curvature; expected straight yarns")
    knots = [_knots(yarns, yarn, int(count)) for yarn, count in enumerate(np.diff(like.start))]
    step = np.zeros((yarns.yarn_count, 3))
    if yarns.lattice is not None and yarns.lattice_step is not None:
        step = yarns.lattice.shift(yarns.lattice_step)
    return replace(
        yarns, points=control_points_through(np.concatenate(knots), like.start, like.closed, step), start=like.start,
        rest_length=even_lengths(like, yarns.rest_length, yarns.segment_start), row=like.row, face=like.face,
        part=like.part, natural_curvature=like.natural_curvature,
    )  # fmt: skip


def even_lengths(like: YarnSet, rest_length: FloatArray, segment_start: IntArray) -> FloatArray:
    """Return equal rest lengths of the segments of each yarn [cm], shape (S,).

    Args:
        like: the yarns that get these segments.
        rest_length: rest lengths of the same yarns, with any segments [cm].
        segment_start: first segment of each yarn among these, shape (Y + 1,).
    """
    counts = np.diff(like.segment_start)
    even: FloatArray = np.repeat(np.add.reduceat(rest_length, segment_start[:-1]) / counts, counts)
    return even


def _knots(yarns: YarnSet, yarn: int, count: int) -> FloatArray:
    """Return the places through which a yarn passes at its ``count`` new control points [cm], shape (count, 3).

    The knot of control point i is the begin of segment i - 1.
    """
    first, last = yarns.segment_start[yarn : yarn + 2]
    numbers = np.arange(first, last)
    if not yarns.closed[yarn]:
        gaps = yarns.rest_length[first:last]
        places = _places(yarns, numbers, gaps, np.linspace(0.0, float(gaps.sum()), count - 2))[0]
        ends = 2.0 * places[[0, -1]] - places[[1, -2]]
        return np.concatenate([ends[:1], places, ends[1:]])
    gaps = np.roll(yarns.rest_length[first:last], 1)
    length = float(gaps.sum())
    along = (np.arange(count) + 0.5) * (length / count) - gaps[-1] / 2.0
    turn = np.floor(along / length)
    places, gap = _places(yarns, np.roll(numbers, 1), gaps, along - turn * length)
    if yarns.lattice is not None and yarns.lattice_step is not None:
        # the segment before the first control point begins in the image where the yarn ends
        places = places + (turn - (gap == 0))[:, None] * yarns.lattice.shift(yarns.lattice_step[yarn])
    return places


def _places(yarns: YarnSet, segments: IntArray, rest: FloatArray, along: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return places on successive segments [cm], shape (n, 3), and the segment of each place, shape (n,).

    Args:
        yarns: the yarns.
        segments: the segments.
        rest: their rest lengths [cm].
        along: lengths of yarn at rest from the begin of the first segment [cm], shape (n,).
    """
    knot = np.concatenate([[0.0], np.cumsum(rest)])
    on = np.clip(np.searchsorted(knot, along, side="right") - 1, 0, len(rest) - 1)
    corners = yarns.points[yarns.segment_points[segments[on]]]
    if yarns.point_shift is not None:
        corners = corners + yarns.point_shift[segments[on]]
    return np.einsum("kj,kjd->kd", basis(np.clip((along - knot[on]) / rest[on], 0.0, 1.0)), corners), on
