# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Unstable balances of many cells (``saddle``): the columns of their Hessians are products that all cells share.

A cell has as many columns as it has free coordinates. The k-th column of each cell is found in the same launches, so
that the launches are as many as the largest cell has columns. Cells are taken in the order of their sizes, and as many
together as ``ROOM`` holds columns of. The eigenvalues of each cell are found on the processors of the host.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.compute.kernel import kernel
from stitchmesh.mesh import FloatArray
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.hessian.hessian_product import Hessian
from stitchmesh.yarnrelax.saddle import LARGEST_CELL, moved_down
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.together.cell_batch import CellBatch

ROOM = 2**28
"""Coordinates of all columns that are found together."""


@kernel
def set_coordinates(
    # model
    column: int,
    value: Any,
    strains: int,
    point_start: wp.array[wp.int32],
    # state out
    motion: wp.array[Any],
) -> None:
    """Set the coordinate of each cell that belongs to a column; its strains, if any, follow its control points."""
    cell = wp.tid()
    beyond = point_start[cell] + column // 3 - point_start[cell + 1]
    if beyond < 0 or (beyond == 0 and strains > 0):
        row = wp.where(beyond < 0, point_start[cell] + column // 3, point_start[point_start.shape[0] - 1] + cell)
        place = motion[row]
        place[column % 3] = value
        motion[row] = place


def leave_saddles(batch: CellBatch) -> list[YarnSet | None]:
    """The yarns of each cell of a batch after a move down from an unstable balance; None if they are stable.

    Cells that ``leave_saddle`` does not examine count as stable.
    """
    sizes = np.array([len(yarns.points) for yarns, _material in batch.given])
    order = np.argsort(sizes, kind="stable")
    order = order[sizes[order] <= LARGEST_CELL]
    moved: list[YarnSet | None] = [None] * len(sizes)
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        for some in _parts(order, sizes):
            chosen = np.isin(np.arange(len(sizes)), some)
            part = batch.part(chosen)
            found = threads.map(_moved_down, part.given, _balances(part), _free(part))
            for number, yarns in zip(np.flatnonzero(chosen).tolist(), found, strict=True):
                moved[number] = yarns
    return moved


def _parts(order: NDArray[np.int64], sizes: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Cells in ascending order of their sizes, in parts whose columns have room."""
    parts, first = [], 0
    for last in range(1, len(order) + 1):
        following = order[first : last + 1]
        if last == len(order) or 9 * (sizes[following[-1]] + 1) * (sizes[following] + 1).sum() > ROOM:
            parts.append(order[first:last])
            first = last
    return parts


def _moved_down(
    given: tuple[YarnSet, Any], balance: tuple[FloatArray, FloatArray], free: NDArray[np.bool_]
) -> YarnSet | None:  # fmt: skip
    return moved_down(given[0], balance[0], free, balance[1])


def _free(batch: CellBatch) -> list[NDArray[np.bool_]]:
    """Which coordinates of each cell are free, those of the control points and then the strains, shape (N + 1, 3)."""
    result = []
    for number, (yarns, _material) in enumerate(batch.given):
        free = np.ones((len(yarns.points) + 1, 3), dtype=bool)
        free[-1] = False if batch.free is None else batch.free[number].free
        result.append(free)
    return result


def _balances(batch: CellBatch) -> Iterator[tuple[FloatArray, FloatArray]]:
    """For each cell the Hessian of its free coordinates, as ``saddle.hessian_matrix``, and how far it may move."""
    simulation = batch.simulation()
    model, point_start = simulation.model, simulation.model.point_start
    strains = 0 if simulation.strain is None else model.cell_count
    budget = simulation.state.budget.numpy().astype(np.float64)
    columns = _columns(simulation, 3 * int(np.diff(point_start).max() + (strains > 0)), strains)
    for cell, free in enumerate(_free(batch)):
        own = [columns[:, point_start[cell] : point_start[cell + 1]]]
        own += [columns[:, model.point_count + cell : model.point_count + cell + 1]] if strains else []
        count = 3 * sum(part.shape[1] for part in own)
        chosen = np.flatnonzero(free.ravel()[:count])
        whole = np.concatenate([part[:count] for part in own], axis=1).reshape(count, count)
        matrix = whole[np.ix_(chosen, chosen)].astype(np.float64)
        entries = np.arange(point_start[cell], point_start[cell + 1])
        if strains:
            entries = np.append(entries, model.point_count + cell)
        yield (matrix + matrix.T) / 2.0, budget[entries]


def _columns(simulation: YarnSimulation, count: int, strains: int) -> NDArray[Any]:
    """The product of the exact Hessian of all cells with the motion of each column, shape (count, N + strains, 3)."""
    model, launcher = simulation.model, simulation.model.prepare
    hessian = Hessian(model, simulation.state, simulation.candidates, simulation.strain, simulation.terms)
    hessian.exact.fill_(1.0)
    CapturedLaunches([*simulation.balance_launches(), *hessian.find_launches(launcher)], model.device).launch()
    rows = model.point_count + strains
    motion, product, columns = model.empty(rows, 3), model.empty(rows, 3), model.empty((count, rows), 3)
    products = CapturedLaunches(hessian.product_launches(motion, product, launcher), model.device)
    for column in range(count):
        for value in (1.0, 0.0):
            inputs = [column, model.number(value), strains, model.cell_points]
            model.launch(set_coordinates, model.cell_count, inputs, [motion])
            if value:
                products.launch()
                wp.copy(columns[column], product)
    return columns.numpy()
