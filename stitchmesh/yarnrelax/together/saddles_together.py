# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Unstable balances of many cells (``saddle``): the blocks of their Hessians are found in the same launches.

The factors of each cell are found on the processors of the host.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.assembled_hessian import assembled_hessian
from stitchmesh.yarnrelax.saddle import free_coordinates, moved_down
from stitchmesh.yarnrelax.together.cell_batch import CellBatch


def leave_saddles(batch: CellBatch) -> list[YarnSet | None]:
    """The yarns of each cell of a batch after a move down from an unstable balance; None if they are stable."""
    simulation = batch.simulation()
    model, whole = simulation.model, assembled_hessian(simulation)
    budget = simulation.state.budget.numpy().astype(np.float64)

    def examine(number: int) -> YarnSet | None:
        entries = np.arange(model.point_start[number], model.point_start[number + 1])
        if simulation.strain is not None:
            entries = np.append(entries, model.point_count + number)
        rows = (3 * entries[:, None] + np.arange(3)).ravel()
        yarns = batch.given[number][0]
        free = free_coordinates(yarns, None if batch.free is None else batch.free[number])
        return moved_down(yarns, whole[rows][:, rows], free, budget[entries])

    with ThreadPoolExecutor(os.cpu_count()) as threads:
        return list(threads.map(examine, range(len(batch.given))))
