# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Heights of woven yarns at their crossings, computed as if the yarns were taut strings.

The heights minimise the energy of the strings, half the sum of (change of height)^2 / distance over neighbouring
crossings. The condition is that at each crossing the two yarns have the distance that their radii need. Layers separate
as a result, and floats are straight. Each height occurs in one condition only, so the projection onto the conditions
has a closed form, and an accelerated projected gradient method converges (FISTA, Beck and Teboulle 2009, restarted as
by O'Donoghue and Candes 2015 when the momentum points against the descent).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray


def taut_heights(
    over: NDArray[np.bool_], apart: FloatArray, along_wefts: FloatArray, along_warps: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the heights [cm] of wefts and of warps at their crossings, shape (wefts, warps) each; their mean is 0.

    Args:
        over: whether each weft passes over each warp, shape (wefts, warps).
        apart: smallest height difference of the weft and the warp at each crossing [cm], shape (wefts, warps).
        along_wefts: distance from each warp to the next warp [cm], shape (warps,); the last entry is the distance to
            the first warp of the next period.
        along_warps: distance from each weft to the next weft [cm], shape (wefts,), with the same last entry.
    """
    shortest = min(along_wefts.min(), along_warps.min())
    tension = (shortest / along_wefts[None, :], shortest / along_warps[:, None])
    sign = np.where(over, 1.0, -1.0)
    heights = ahead = _separate(np.zeros((2, *over.shape)), sign, apart)
    momentum = 1.0
    for _ in range(2000):
        moved = _separate(ahead - _gradient(ahead, tension) / 4, sign, apart)  # 4 bounds the curvature of the energy
        change = moved - heights
        # Largest change of a height in the last iteration, relative to the largest distance between crossing yarns
        if np.abs(change).max() <= 1e-4 * apart.max() and momentum > 1.0:
            break
        if ((ahead - moved) * change).sum() > 0.0:
            momentum = 1.0
        following = (1 + np.sqrt(1 + 4 * momentum**2)) / 2
        ahead = moved + (momentum - 1) / following * change
        heights, momentum = moved, following
    heights = heights - (heights.max() + heights.min()) / 2
    return heights[0], heights[1]


def _gradient(heights: FloatArray, tension: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Return the derivative of the energy by each height, shape (2, wefts, warps)."""
    slopes = []
    for height, tight, axis in zip(heights, tension, (1, 0), strict=True):
        pull = tight * (np.roll(height, -1, axis) - height)
        slopes.append(np.roll(pull, 1, axis) - pull)
    return np.stack(slopes)


def _separate(heights: FloatArray, sign: FloatArray, apart: FloatArray) -> FloatArray:
    """Return the nearest heights that satisfy the condition at every crossing, shape (2, wefts, warps)."""
    missing = sign * np.maximum(apart - sign * (heights[0] - heights[1]), 0.0) / 2
    return np.stack([heights[0] + missing, heights[1] - missing])
