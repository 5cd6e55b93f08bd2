# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How many contact samples a segment needs (L section 3.1: spheres along a yarn leave no gap).

The arc that a sample stands for lies within its *reach* of the sample, half the longest leg between control points over
the number of samples. The spheres touch while that is one radius; ``LARGEST_REACH`` leaves room for a yarn that
stretches.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.yarn import YarnSet

LARGEST_REACH = 0.85
"""Largest reach of a contact sample over the yarn radius at the start."""


def sample_counts(yarns: YarnSet, contact_samples: int) -> NDArray[np.int64]:
    """Contact samples of each segment, at least ``contact_samples``, shape (S,)."""
    corners = yarns.points[yarns.segment_points]
    if yarns.point_shift is not None:
        corners = corners + yarns.point_shift
    leg = np.linalg.norm(np.diff(corners, axis=1), axis=2).max(axis=1)
    reach = np.maximum(leg, yarns.rest_length) / (2 * yarns.radius[yarns.segment_yarn])
    return np.maximum(contact_samples, np.ceil(reach / LARGEST_REACH)).astype(np.int64)
