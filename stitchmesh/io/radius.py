# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn radius of a file that states none, estimated from how closely its yarns lie."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray
from stitchmesh.yarn import YarnSet

SAMPLES_PER_SEGMENT = 2
QUERIES = 20_000
"""Points whose surroundings are searched; more change the third digit of the estimate only."""
NEIGHBOURS = 32
"""Points looked at around each; yarns in contact are among the nearest."""
DETOUR = 3.0
"""Points of one yarn are neighbours unless the way along it is this much longer than the way across; on half a
circle it is 1.6 times as long."""
CLOSE = 0.1
"""Quantile of the distances that counts as contact: some stray pairs lie closer, and not every point touches."""


def estimated_radius(yarns: YarnSet) -> float:
    """Half the distance [cm] at which yarns typically touch: a low quantile of the distances to other yarns.

    Raises:
        ParameterError: no yarn comes near another or near another part of itself.
    """
    curves = yarns.sampled(SAMPLES_PER_SEGMENT)
    points = np.concatenate(curves)
    owner = np.repeat(np.arange(len(curves)), [len(curve) for curve in curves])
    along, around = _arc_lengths(curves, yarns)
    queries = np.unique(np.linspace(0, len(points) - 1, min(QUERIES, len(points))).astype(np.int64))
    distance, found = cKDTree(points).query(points[queries], k=min(NEIGHBOURS, len(points)))
    way = np.abs(along[found] - along[queries][:, None])
    way = np.minimum(way, around[owner[queries]][:, None] - way)
    apart = (owner[found] != owner[queries][:, None]) | (way > DETOUR * distance)
    apart &= distance > 0.0
    nearest = np.where(apart, distance, np.inf).min(axis=1)
    nearest = nearest[np.isfinite(nearest)]
    if not len(nearest):
        raise ParameterError("radius: the yarns never come close to each other, so it cannot be estimated; give it")
    return float(np.quantile(nearest, CLOSE)) / 2


def _arc_lengths(curves: list[FloatArray], yarns: YarnSet) -> tuple[FloatArray, FloatArray]:
    """Way along its yarn to each point, and the way around each yarn (endless for an open one)."""
    along, around = [], np.full(len(curves), np.inf)
    for index, curve in enumerate(curves):
        steps = np.linalg.norm(np.diff(curve, axis=0), axis=1)
        along.append(np.concatenate([[0.0], np.cumsum(steps)]))
        if yarns.closed[index]:
            around[index] = along[-1][-1] + np.linalg.norm(curve[0] - curve[-1])
    return np.concatenate(along), around
