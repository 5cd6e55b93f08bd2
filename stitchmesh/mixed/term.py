# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The terms of the mixed system: membrane, bending, yarns, contact, weight.

A term is an energy of the positions v of the triangle vertices, the world positions p of the yarn nodes and their
Eulerian coordinates s. It does not know how p follows from the unknowns of the enriched region (``enrichment``). When a
term is made, each of its elements gets a blending weight, alpha for yarns and 1 - alpha for triangles
(Casafranca et al. 2020, section 4.1).

The weight of a yarn element is the mean of alpha at its nodes, alpha at its centroid. An element with a node of the
full-yarn region has the weight 1. No gradient of alpha then acts on such nodes, which have no triangles that could take
up its forces.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.simulation.term import Term, check_arrays

FULL = 1.0 - 1e-12
"""Alpha from which on a node belongs to the full-yarn region; slightly below 1 because of rounding."""


def element_weight(
    alpha: NDArray[np.float64], given: NDArray[np.bool_], full: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Weights of elements, shape (E,); 0 for an element without nodes.

    Args:
        alpha: blending field at the nodes of each element, shape (E, K).
        given: whether the element has each of these nodes, shape (E, K).
        full: whether each of these nodes belongs to the full-yarn region, shape (E, K).
    """
    mean = np.where(given, alpha, 0.0).sum(axis=1) / np.maximum(given.sum(axis=1), 1)
    weight: NDArray[np.float64] = np.where((given & full).any(axis=1), 1.0, mean)
    return weight


MixedTerm = Term[MixedVector, MixedVector]
"""A term of the mixed system."""


def term_arrays(terms: Sequence[MixedTerm]) -> dict[str, NDArray[Any]]:
    """Return all arrays of terms that last from step to step, by the number of the term and the name."""
    return {
        f"term {number} {name}": array.numpy()
        for number, term in enumerate(terms)
        for name, array in term.arrays().items()
    }


def resume_terms(terms: Sequence[MixedTerm], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Restore the contents of ``term_arrays``, which ``arrays`` holds among others.

    Raises:
        ParameterError: an array is missing or has another shape.
    """
    check_arrays({name: array.shape for name, array in term_arrays(terms).items()}, arrays)
    for number, term in enumerate(terms):
        term.resume({name: arrays[f"term {number} {name}"] for name in term.arrays()})


@kernel
def keep_share(
    # state in
    exact: Scalar,
    # state out
    share: wp.array[Scalar],
) -> None:
    """Keep the share of the exact Hessian."""
    share[wp.tid()] = exact
