# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Curves from which the garments are modelled: oval rings and smooth columns."""

import numpy as np

Vector = tuple[float, float, float]


def oval(
    count: int, half_width: float, half_depth: float, height: float, start: float = -90.0
) -> np.ndarray:
    """Return a horizontal oval ring of points, counter-clockwise as seen from above.

    `start` is the angle of the first point in degrees; 0 is the front (+z), 90 the side +x.
    """
    angles = np.radians(start + 360.0 * np.arange(count) / count)
    x, z = half_width * np.sin(angles), half_depth * np.cos(angles)
    return np.column_stack([x, np.full(count, height), z])


def hermite(
    start: np.ndarray, end: np.ndarray, leave: np.ndarray, arrive: np.ndarray, t: np.ndarray | float
) -> np.ndarray:
    """Evaluate cubic Hermite curves, one for each row of the arrays, at parameter t in 0..1."""
    t = np.asarray(t, dtype=float)
    if t.ndim == 1:
        t = t[:, None]
    t2, t3 = t**2, t**3
    ends = (2 * t3 - 3 * t2 + 1) * start + (3 * t2 - 2 * t3) * end
    return ends + (t3 - 2 * t2 + t) * leave + (t3 - t2) * arrive


def smooth_step(t: np.ndarray | float) -> np.ndarray | float:
    """Return a cubic step from 0 to 1 for t in 0..1, with zero slope at both ends; clamp outside."""
    t = np.clip(t, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def unit(vector: np.ndarray | Vector) -> np.ndarray:
    """Return the vectors scaled to length one."""
    vector = np.asarray(vector, dtype=float)
    return vector / np.linalg.norm(vector, axis=-1, keepdims=True)
