# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Unit vectors; the direction of a zero vector is the zero vector."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh.polygon_mesh import FloatArray


def unit_vectors(vectors: FloatArray, axis: int = -1) -> FloatArray:
    """Return the unit vectors along vectors of any shape; a zero vector stays zero.

    Args:
        vectors: the vectors.
        axis: the axis along which each vector lies.
    """
    length = np.linalg.norm(vectors, axis=axis, keepdims=True)
    unit: FloatArray = vectors / np.where(length > 0.0, length, 1.0)
    return unit
