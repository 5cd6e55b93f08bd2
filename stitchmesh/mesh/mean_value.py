# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mean value coordinates: a smooth map from a flat template polygon to any polygon (Floater 2003).

    w_i = (tan(a_(i-1)/2) + tan(a_i/2)) / |p_i - q|,   weights w_i / sum w

where a_i is the angle at the point q between the corners p_i and p_(i+1). The weights reproduce linear functions. If
the polygon is an affine image of the template, the map is therefore affine. Consecutive corners may be collinear.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh.polygon_mesh import FloatArray

ON_SIDE = 1e-9
"""Distance from a side, in units of the template, below which a point is treated as a point on the side."""


def mean_value_weights(polygon: FloatArray, points: FloatArray) -> FloatArray:
    """Compute the weights of the corners of a polygon at points in it or on its sides, shape (n, corners).

    Args:
        polygon: corners of a convex polygon, counter-clockwise, shape (corners, 2).
        points: points at which the weights are evaluated, shape (n, 2).
    """
    spoke = polygon[None, :, :] - points[:, None, :]
    distance = np.linalg.norm(spoke, axis=2)
    following = np.roll(spoke, -1, axis=1)
    cross = spoke[..., 0] * following[..., 1] - spoke[..., 1] * following[..., 0]
    dot = (spoke * following).sum(axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        half_tangent = (distance * np.roll(distance, -1, axis=1) - dot) / cross
        weights = (np.roll(half_tangent, 1, axis=1) + half_tangent) / distance
        weights = weights / weights.sum(axis=1, keepdims=True)
    length = np.linalg.norm(np.roll(polygon, -1, axis=0) - polygon, axis=1)
    on_side = (np.abs(cross) <= ON_SIDE * length) & (dot <= ON_SIDE)
    for point, side in zip(*np.nonzero(on_side), strict=True):
        weights[point] = _side_weights(polygon, int(side), points[point])
    return weights


def _side_weights(polygon: FloatArray, side: int, point: FloatArray) -> FloatArray:
    """Linear weights on a side, the limit of mean value coordinates there, shape (corners,)."""
    end = (side + 1) % len(polygon)
    span = polygon[end] - polygon[side]
    share = float((point - polygon[side]) @ span / (span @ span))
    weights = np.zeros(len(polygon))
    weights[side], weights[end] = 1.0 - share, share
    return weights
