# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The gauge of a fabric as it was made, and as its yarns lie."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.yarn.yarn_presets import Gauge
from stitchmesh.yarn.yarn_set import YarnSet


def fabric_gauge(fabric: StitchMesh) -> Gauge:
    """Return the gauge of the median stitch of a fabric.

    The wale spacing is the median length of the course sides, and the course spacing that of the wale sides.
    """
    width, height = (float(np.median(fabric.side_length[sides])) for sides in (~fabric.is_wale, fabric.is_wale))
    return Gauge.of_stitch(width, height)


def yarn_gauge(yarns: YarnSet, fabric: StitchMesh) -> Gauge | None:
    """Return the gauge that yarns have reached: that of the median distances between neighbouring stitches.

    A stitch is where the middle of its control points is. Neighbours in a row share a wale side, neighbours in a wale a
    course side.

    Args:
        yarns: the yarns, for example after their relaxation.
        fabric: the stitches of which they were made.

    Returns:
        The gauge; None if no two neighbours of a row or of a wale have yarn, as in a fabric of one row.
    """
    made = yarns.face >= 0
    count = np.bincount(yarns.face[made], minlength=fabric.face_count)
    sums = [np.bincount(yarns.face[made], yarns.points[made, axis], fabric.face_count) for axis in range(3)]
    middle = np.stack(sums, axis=1) / np.maximum(count, 1)[:, None]
    side = np.flatnonzero(fabric.twin != BORDER)
    first, second = fabric.side_face[side], fabric.side_face[fabric.twin[side]]
    known = (count[first] > 0) & (count[second] > 0)
    distance = np.linalg.norm(middle[first] - middle[second], axis=1)
    in_row, in_wale = (distance[known & (fabric.is_wale[side] == wale)] for wale in (True, False))
    if not len(in_row) or not len(in_wale):
        return None
    return Gauge.of_stitch(float(np.median(in_row)), float(np.median(in_wale)))
