# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Arrays changed by one unit in the last place, for tests that such a change does not change a decision."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray

SHAKES = 10_000
"""Number of changed copies of an array in a test."""


def shaken(values: FloatArray, seed: int) -> FloatArray:
    """Each number moved up or down by one unit in its last place.

    For odd seeds the unit is that of the largest number: the rounding error of a number, such as zero, that is the
    difference of larger ones.
    """
    up = np.random.default_rng(seed).random(np.shape(values)) < 0.5
    if seed % 2:
        return values + np.where(up, 1.0, -1.0) * np.spacing(np.abs(values).max())
    return np.nextafter(values, np.where(up, np.inf, -np.inf))


def shaken_many(values: FloatArray, count: int = SHAKES) -> FloatArray:
    """Copies of an array, each changed by a seed of its own, shape (count, *shape)."""
    return np.stack([shaken(values, seed) for seed in range(count)])
