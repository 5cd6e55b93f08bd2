# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers of segments carried over to the control points between them, for colours of yarns."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.yarn.yarn_set import YarnSet


def control_point_means(yarns: YarnSet, of_segments: FloatArray) -> FloatArray:
    """Return the mean of the two segments that meet near each control point, shape (N,).

    At the ends of an open yarn only one segment lies beside a control point, and beside the first and the last control
    point there is none: they have the number of their neighbour.

    Args:
        yarns: the yarns.
        of_segments: a number for each segment, shape (S,).
    """
    beside = yarns.segment_points[:, 1:3]
    total = np.bincount(beside.ravel(), weights=np.repeat(of_segments, 2), minlength=len(yarns.points))
    count = np.bincount(beside.ravel(), minlength=len(yarns.points))
    mean = total / np.maximum(count, 1)
    first, last = yarns.start[:-1][~yarns.closed], yarns.start[1:][~yarns.closed] - 1
    mean[first], mean[last] = mean[first + 1], mean[last - 1]
    return mean
