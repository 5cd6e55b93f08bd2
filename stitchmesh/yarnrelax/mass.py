# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mass of control points (L, appendix B).

A yarn has the mass m per length of rest. Over a segment the four basis functions have the integrals
(1, 11, 11, 1) / 24, which are the row sums of its mass matrix over m l, so a control point has

    m_j = sum over its segments of  m l (1, 11, 11, 1)_slot / 24        [g]

and one between segments of length l has m l.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.yarnrelax.model import Model

SHARES = np.array([1.0, 11.0, 11.0, 1.0]) / 24.0
"""Integrals of the four basis functions over a segment."""


def point_masses(model: Model) -> NDArray[np.float64]:
    """Mass of each control point [g], shape (N,)."""
    mass = model.material.mass_per_length * model.rest_length[:, None] * SHARES
    corners = model.yarns.segment_points.ravel()
    return np.bincount(corners, weights=mass.ravel(), minlength=model.point_count).astype(np.float64)
