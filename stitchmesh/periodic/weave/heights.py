# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Heights of woven yarns at their crossings, as if they were taut strings.

Of all heights at which yarns are far enough apart wherever they cross, those are chosen whose strings store the least
energy, half the sum of (change of height)^2 / distance between neighbouring crossings. Layers part by themselves, and
floats lie straight. Each height stands in one condition alone, so that heights are brought apart in closed form, and
an accelerated projected gradient converges (Beck and Teboulle 2009, FISTA, restarted where it would turn back as by
O'Donoghue and Candes 2015).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray

MOST_ITERATIONS = 2000
TOLERANCE = 1e-4
"""Change of a height in one iteration, as a part of the largest distance, below which heights are taken as final."""


def taut_heights(
    over: NDArray[np.bool_], apart: FloatArray, along_wefts: FloatArray, along_warps: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Heights [cm] of wefts and of warps at their crossings, shape (wefts, warps) each; their middle is 0.

    Args:
        over: whether each weft passes over each warp, shape (wefts, warps).
        apart: distance in height of weft and warp where they cross [cm], shape (wefts, warps).
        along_wefts: distance from each warp to the next, from the last to the first of the next period [cm], (warps,).
        along_warps: distance from each weft to the next, likewise [cm], shape (wefts,).
    """
    shortest = min(along_wefts.min(), along_warps.min())
    tension = (shortest / along_wefts[None, :], shortest / along_warps[:, None])
    sign = np.where(over, 1.0, -1.0)
    heights = ahead = _moved_apart(np.zeros((2, *over.shape)), sign, apart)
    momentum = 1.0
    for _ in range(MOST_ITERATIONS):
        moved = _moved_apart(ahead - _slope(ahead, tension) / 4, sign, apart)  # no curvature of the energy is above 4
        change = moved - heights
        if np.abs(change).max() <= TOLERANCE * apart.max() and momentum > 1.0:
            break
        if ((ahead - moved) * change).sum() > 0.0:
            momentum = 1.0
        following = (1 + np.sqrt(1 + 4 * momentum**2)) / 2
        ahead = moved + (momentum - 1) / following * change
        heights, momentum = moved, following
    heights = heights - (heights.max() + heights.min()) / 2
    return heights[0], heights[1]


def _slope(heights: FloatArray, tension: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Derivative of the energy by each height."""
    slopes = []
    for height, tight, axis in zip(heights, tension, (1, 0), strict=True):
        pull = tight * (np.roll(height, -1, axis) - height)
        slopes.append(np.roll(pull, 1, axis) - pull)
    return np.stack(slopes)


def _moved_apart(heights: FloatArray, sign: FloatArray, apart: FloatArray) -> FloatArray:
    """The nearest heights at which every weft and warp are far enough apart."""
    missing = sign * np.maximum(apart - sign * (heights[0] - heights[1]), 0.0) / 2
    return np.stack([heights[0] + missing, heights[1] - missing])
