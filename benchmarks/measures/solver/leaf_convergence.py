# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The convergence test of Leaf et al. 2018 (L, section 8, eq 5), for comparison with its figures.

Let g_i be the norm, at iteration i, of the gradient of the energy with respect to the control points, without the part
that constraints carry. A relaxation has converged at the first i > 0 where

    g_i / g_0 <= 0.1      and      |g_i / g_(i-1) - 1| <= 1e-5

Damping is not an energy and does not contribute to g. The test measures how much the gradient has decreased, not how
far the yarns are from rest: it also holds where the norm happens to be constant, or where a time step is very short.
``in_a_row`` requires both conditions at several successive iterations. If it is larger than the assessment interval,
iterations without motion, which wait for new candidate lists, cannot satisfy the test. The norms stay on the device in
a ring buffer, so that nothing is read back between assessments.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.reduction import strand_sums, strands_for
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import State
from stitchmesh.yarnrelax.solvers.time_step import FEW_STRANDS

LARGEST_PART = 0.1
"""Largest ratio of the gradient to the first gradient."""
LARGEST_CHANGE = 1e-5
"""Largest relative change of the gradient from one iteration to the next."""


def first_converged(norms: NDArray[np.float64], in_a_row: int = 1) -> int | None:
    """The first iteration at which the test holds.

    Args:
        norms: norm of the gradient at iterations 0, 1, 2 ...
        in_a_row: number of successive iterations, ending with the returned one, that must satisfy the conditions.

    Returns:
        The number of the iteration; None if the test never holds.
    """
    small = norms[1:] <= LARGEST_PART * norms[:1]
    holds = small & (np.abs(np.diff(norms)) <= LARGEST_CHANGE * norms[:-1])
    if len(holds) < in_a_row:
        return None
    last = np.flatnonzero(np.lib.stride_tricks.sliding_window_view(holds, in_a_row).all(axis=1)) + in_a_row
    return int(last[0]) if len(last) else None


@kernel
def square_gradient(
    # state in
    force: wp.array[Any],
    # state out
    square: wp.array[Any],
) -> None:
    """Squared gradient with respect to each control point [erg^2 / unit^2]."""
    i = wp.tid()
    square[i] = wp.dot(force[i], force[i])


@kernel
def append_norm(
    # state in
    sums: wp.array[wp.float64],
    # state out
    count: wp.array[wp.int32],
    ring: wp.array[wp.float64],
) -> None:
    """Write the norm to the next entry of the ring buffer; runs as one thread."""
    total = wp.float64(0.0)
    for k in range(sums.shape[0]):
        total += sums[k]
    ring[count[0] % ring.shape[0]] = wp.sqrt(total)
    count[0] = count[0] + 1


class GradientNorms:
    """Norms of the gradient at successive iterations, on a device."""

    def __init__(self, model: Model, capacity: int) -> None:
        """Allocate a ring buffer for ``capacity`` norms, the most that one call of ``new`` can return."""
        self.count_seen = 0
        self.square = model.empty(model.point_count)
        self.many = wp.zeros(strands_for(model.point_count), dtype=wp.float64, device=model.device)
        self.few = wp.zeros(FEW_STRANDS, dtype=wp.float64, device=model.device)
        self.count = wp.zeros(1, dtype=wp.int32, device=model.device)
        self.ring = wp.zeros(capacity, dtype=wp.float64, device=model.device)

    def launches(self, state: State, launcher: Launcher) -> list[Any]:
        """The launches that record the norm of ``state.force``, filtered by the constraints; once per iteration."""
        return [
            launcher(square_gradient, len(self.square), [state.force], [self.square]),
            launcher(strand_sums, len(self.many), [self.square], [self.many]),
            launcher(strand_sums, len(self.few), [self.many], [self.few]),
            launcher(append_norm, 1, [self.few], [self.count, self.ring]),
        ]

    def new(self) -> NDArray[np.float64]:
        """Norms [erg / unit] since the last call, the oldest first; at most the newest ``capacity`` norms."""
        count, capacity = int(self.count.numpy()[0]), len(self.ring)
        numbers = np.arange(max(self.count_seen, count - capacity), count)
        self.count_seen = count
        return self.ring.numpy()[numbers % capacity]
