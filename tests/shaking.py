# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Arrays perturbed by one unit in the last place; discrete decisions about them must not change."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray

SHAKES = 1_000
"""Number of changed copies of an array in a test."""


def shaken(values: FloatArray, seed: int) -> FloatArray:
    """Move each number up or down by one unit in its last place, or, for odd seeds, in that of the largest number.

    For odd seeds the unit is that of the largest number: the rounding error of a number, such as zero, that is the
    difference of larger ones.
    """
    up = np.random.default_rng(seed).random(np.shape(values)) < 0.5
    if seed % 2:
        return values + np.where(up, 1.0, -1.0) * np.spacing(np.abs(values).max())
    return np.nextafter(values, np.where(up, np.inf, -np.inf))


def shaken_many(values: FloatArray, count: int = SHAKES) -> FloatArray:
    """Return ``count`` perturbed copies of an array, shape (count, *shape)."""
    return np.stack([shaken(values, seed) for seed in range(count)])
