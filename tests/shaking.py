# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Arrays shaken by one unit in the last place: what is decided from them must stay as it is."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray

SHAKES = 10_000


def shaken(values: FloatArray, seed: int) -> FloatArray:
    """Each number moved up or down by one unit in its last place; for odd seeds, in that of the largest of all.

    The latter is what rounding leaves of a number that is the difference of larger ones, as of zero.
    """
    up = np.random.default_rng(seed).random(np.shape(values)) < 0.5
    if seed % 2:
        return values + np.where(up, 1.0, -1.0) * np.spacing(np.abs(values).max())
    return np.nextafter(values, np.where(up, np.inf, -np.inf))


def shaken_many(values: FloatArray, count: int = SHAKES) -> FloatArray:
    """An array shaken again and again, shape (count, *shape)."""
    return np.stack([shaken(values, seed) for seed in range(count)])
