# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The rest shape of the rods along seams, between that of the two panels that meet there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mixed.cloth.cloth import Cloth


def rest_lengths(cloth: Cloth) -> NDArray[np.float64]:
    """Rest length of each edge of a seam [cm], the mean of those of both panels; shape (S,)."""
    edges = np.diff(cloth.side_rest, axis=1)[:, 0][cloth.seam_sides]
    lengths: NDArray[np.float64] = np.linalg.norm(edges, axis=2).mean(axis=1)
    return lengths


def following_edges(cloth: Cloth) -> NDArray[np.int64]:
    """The edge that follows each edge on its seam, the first one at the end of a closed seam, -1 for none; (S,)."""
    following = np.arange(1, len(cloth.seam_edges) + 1)
    first, last = cloth.seam_start[:-1], cloth.seam_start[1:] - 1
    closed = cloth.seam_edges[last, 1] == cloth.seam_edges[first, 0]
    following[last] = np.where(closed & (last > first), first, -1)
    return following


def rest_angles(cloth: Cloth, following: NDArray[np.int64]) -> NDArray[np.float64]:
    """Rest angle between each edge and the one that follows it [rad], shape (S,).

    It is the mean of the angles in the planes of both panels, and 0 where both edges lie in different panels.
    """
    edges = np.diff(cloth.side_rest, axis=1)[:, 0][cloth.seam_sides]
    one, other = edges, edges[following]
    turning = np.abs(np.arctan2(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0], (one * other).sum(axis=2)))
    panel = cloth.panel[cloth.seam_sides // 3]
    same = (panel == panel[following]).all(axis=1) & (following >= 0)
    return np.where(same, turning.mean(axis=1), 0.0)
