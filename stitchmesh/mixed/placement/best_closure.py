# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Regions that remove the most error for a price of each node (closures of largest weight; Picard 1976).

Each triangle t is a project with the profit e_t, its error, which needs tools: all triangles s that are simulated if t
is full of yarns. A tool costs the price times its nodes n_s, once for all projects that need it. In the network

    source -> t: e_t,    t -> s: unlimited,    s -> sink: price n_s

the projects on the side of the source of a minimum cut are those with the largest profit less costs. The nodes of this
region fall with the price, so that a bisection finds the largest region of this kind within a budget.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

Integers = NDArray[np.int64]
Numbers = NDArray[np.float64]
PRICES = 24
"""Prices that are tried, each in the middle of the interval that is left."""
UNLIMITED = 2**31 - 1
WHOLE = 2**29
"""Capacities are whole numbers: the sum of all errors is this one."""


def best_closure(reach: csr_array, nodes: Integers, error: Numbers, budget: int) -> Integers:
    """Return the triangles of the largest region within a budget that is the best one for some price, ascending.

    Args:
        reach: which triangles are simulated if one is full of yarns, shape (T, T).
        nodes: nodes of each triangle, shape (T,).
        error: error of each triangle, shape (T,); zero where no yarns are wanted.
        budget: largest number of nodes.
    """
    total = float(error.sum())
    best = np.zeros(0, dtype=np.int64)
    if total <= 0.0 or budget <= 0:
        return best
    low, high = -12.0, 0.0  # powers of ten of the price of a node, over the error of all triangles
    for _ in range(PRICES):
        price = 0.5 * (low + high)
        chosen = _closure(reach, nodes, error / total, 10.0**price)
        if _needed(reach, nodes, chosen) <= budget:
            best, high = chosen, price
        else:
            low = price
    return best


def _needed(reach: csr_array, nodes: Integers, chosen: Integers) -> int:
    """Number of nodes that a region simulates."""
    mask = np.zeros(len(nodes), dtype=np.int32)
    mask[chosen] = 1
    return int(nodes[np.asarray(reach.astype(bool).astype(np.int32) @ mask) > 0].sum())


def _closure(reach: csr_array, nodes: Integers, error: Numbers, price: float) -> Integers:
    """The triangles with the largest error less price; errors add up to 1."""
    count = len(nodes)
    source, sink = 2 * count, 2 * count + 1
    profit = np.rint(WHOLE * error).astype(np.int64)
    cost = np.minimum(np.rint(WHOLE * price * nodes), UNLIMITED).astype(np.int64)
    wanted = np.flatnonzero(profit)
    rows, columns = csr_array(reach[wanted]).nonzero()
    start = np.concatenate([np.full(len(wanted), source), wanted[rows], count + np.arange(count)])
    end = np.concatenate([wanted, count + columns, np.full(count, sink)])
    most = np.concatenate([profit[wanted], np.full(len(rows), UNLIMITED), cost])
    shape = (2 * count + 2, 2 * count + 2)
    network = csr_array((most.astype(np.int32), (start, end)), shape=shape)
    left = csr_array(network - maximum_flow(network, source, sink).flow)
    left.data[left.data < 0] = 0
    left.eliminate_zeros()
    reached = breadth_first_order(left, source, return_predecessors=False)
    return np.sort(reached[reached < count]).astype(np.int64)
