# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Arrays: unit vectors, and runs of true values."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def unit_vectors(vectors: NDArray[np.float64], axis: int = -1) -> NDArray[np.float64]:
    """Return the unit vectors along vectors of any shape; a zero vector stays zero.

    Args:
        vectors: the vectors.
        axis: the axis along which each vector lies.
    """
    length = np.linalg.norm(vectors, axis=axis, keepdims=True)
    unit: NDArray[np.float64] = vectors / np.where(length > 0.0, length, 1.0)
    return unit


def runs_of(chosen: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the first place and the place after the last one of each run of true values."""
    change = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(np.int8)))
    return [(first, beyond) for first, beyond in change.reshape(-1, 2).tolist()]
