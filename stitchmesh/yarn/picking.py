# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Picking: the control point of a yarn at which a ray points."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import ParameterError
from stitchmesh.yarn.yarn_set import YarnSet

BESIDE = 1.5
"""Distance by which a ray may miss a control point, in apparent radii. Curves pass near their control points, and a
ray that meets a tube between two of them passes both within this distance."""


def pick_point(yarns: YarnSet, origin: ArrayLike, direction: ArrayLike) -> int | None:
    """Return the first control point that a ray meets, or None if it meets no yarn.

    Args:
        yarns: the yarns, which are picked where their control points are stored.
        origin: start of the ray [cm], shape (3,).
        direction: direction of the ray, of any length, shape (3,).

    Raises:
        ParameterError: the origin or the direction is not finite, or the direction is zero.
    """
    start, along = (np.asarray(part, dtype=np.float64).reshape(-1) for part in (origin, direction))
    if start.shape != (3,) or along.shape != (3,) or not np.isfinite([start, along]).all() or not along.any():
        raise ParameterError(f"ray: got origin {start} and direction {along}; expected 3 finite numbers each")
    along = along / np.linalg.norm(along)
    away = yarns.points - start
    depth = away @ along
    beside2 = np.einsum("ij,ij->i", away, away) - depth * depth
    reach = BESIDE * yarns.drawn_radius[yarns.point_yarn]
    near = np.flatnonzero((depth > 0.0) & (beside2 <= reach * reach))
    if not len(near):
        return None
    # Of the points at about the same depth, the one nearest to the ray is meant.
    first = near[depth[near] <= depth[near].min() + reach[near]]
    return int(first[beside2[first].argmin()])
