# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The weight of a yarn element from alpha at its nodes (Casafranca et al. 2020, section 4.1).

An element weighs the mean of its nodes, alpha at its centroid. One that has a node of the full-yarn region weighs 1: no
gradient of alpha then acts on these nodes, which have no triangles that could take up its forces.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FULL = 1.0 - 1e-12
"""Alpha from which a node belongs to the full-yarn region; less by rounding."""


def element_weight(
    alpha: NDArray[np.float64], given: NDArray[np.bool_], full: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Weights of elements, shape (E,); 0 for an element without nodes.

    Args:
        alpha: blending field at the nodes of each element, shape (E, K).
        given: whether the element has each of them, shape (E, K).
        full: whether each of them belongs to the full-yarn region, shape (E, K).
    """
    mean = np.where(given, alpha, 0.0).sum(axis=1) / np.maximum(given.sum(axis=1), 1)
    weight: NDArray[np.float64] = np.where((given & full).any(axis=1), 1.0, mean)
    return weight
