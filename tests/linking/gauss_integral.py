# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The linking number of two polygons from solid angles, the reference of the tests."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray


def gauss_integral(first: FloatArray, second: FloatArray) -> float:
    """Linking number as the solid angles of pairs of edges over 4 pi (Banchoff 1976)."""
    total = 0.0
    for a, b in zip(first, np.roll(first, -1, axis=0), strict=True):
        for c, d in zip(second, np.roll(second, -1, axis=0), strict=True):
            sides = np.cross([c - a, d - a, d - b, c - b], [d - a, d - b, c - b, c - a])
            unit = sides / np.linalg.norm(sides, axis=1, keepdims=True)
            angles = np.arcsin(np.clip((unit * np.roll(unit, -1, axis=0)).sum(axis=1), -1.0, 1.0))
            total += float(angles.sum() * np.sign(np.cross(b - a, d - c) @ (a - c)))
    return total / (4.0 * np.pi)
