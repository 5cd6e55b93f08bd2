# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""New candidate lists and budgets for cells, prepared once: one graph on a GPU and one look at how it went.

What ``find_candidates`` and ``limit_steps`` do with a look at every turn is done here without one, on trust: that the
lists have room, that no segment has outgrown the search, and that the table of images still holds all that can touch.
Whoever launches it reads afterwards whether that was so, and else makes the lists the careful way.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.yarnrelax import forces
from stitchmesh.yarnrelax.candidates import Candidates, list_samples
from stitchmesh.yarnrelax.image_table import SPREAD
from stitchmesh.yarnrelax.model import Model
from stitchmesh.yarnrelax.near_segments import SPARE, bound_segments, grid_launches, near_launches
from stitchmesh.yarnrelax.recording import Copying, Recording
from stitchmesh.yarnrelax.reduction import range_minima, strand_maxima, strands_for
from stitchmesh.yarnrelax.state import State
from stitchmesh.yarnrelax.step_limit import (
    SMALLEST_CLEARANCE,
    budget_launch,
    clearance_launches,
    strain_budget_launches,
)

wp.set_module_options({"enable_backward": False})

ROOM_TO_GROW = 1.1
"""How much longer than now segments may become before the search must be made wider."""
LARGEST_STRAIN = 0.05
"""Largest strain of a cell since its table of images was made."""


@wp.kernel(module="unique")
def join_minima(
    # model
    strands: int,
    # state in
    partial: wp.array[wp.float64],
    # state out
    least: wp.array[wp.float64],
) -> None:
    """Smallest of so many values for each cell; not a number where one is not."""
    cell = wp.tid()
    smallest = wp.float64(1.0e300)
    for k in range(strands):
        value = partial[cell * strands + k]
        if smallest == smallest and not (value >= smallest):  # once it is not a number it stays so
            smallest = value
    least[cell] = smallest


class Listing:
    """Candidate lists of cells, as often as wanted with the same margin and the same arrays."""

    def __init__(
        self, model: Model, state: State, candidates: Candidates, table: tuple[Any, Any] | None = None
    ) -> None:
        """Prepare it; lists have been made the careful way for the state as it is.

        ``table`` are box and periods when the table of images was made; as they are if it was made for this state.
        """
        self.model, self.state, self.candidates = model, state, candidates
        self.margin = candidates.margin
        near = candidates.near
        self.reach = self.margin + SPARE
        self.longest = float(near.extent.numpy().max()) * ROOM_TO_GROW
        cells, device = model.cell_count, model.device
        self.table = (self._box(), self._periods()) if table is None else table
        self.holds = True
        """Whether the table did when it was last looked at."""
        self.strands = strands_for(model.largest_cell)
        self.partial = wp.zeros(cells * self.strands, dtype=wp.float64, device=device)
        self.least = wp.zeros(cells, dtype=wp.float64, device=device)
        self.maxima = [wp.zeros(strands_for(len(each)), dtype=wp.float64, device=device)
                       for each in (near.count, candidates.count, near.extent)]  # fmt: skip
        self.recording = Recording(self._launches(), device)

    def _launches(self) -> list[Any]:
        model, state, candidates = self.model, self.state, self.candidates
        near, run = candidates.near, model.record
        bound = run(bound_segments, model.segment_count, [model.constants, state.samples], [near.centre, near.extent])
        launches = [forces.sample_launch(model, state, run), Copying(state.points, state.listed_points), bound]
        launches += grid_launches(model, near, self.reach, self.longest)
        launches += near_launches(model, near, self.reach, self.longest)
        inputs = [model.constants, model.number(self.margin), model.segment_count, state.samples, near.centre,
                  near.extent, near.count, near.lists]  # fmt: skip
        launches.append(run(list_samples, model.sample_count, inputs, [candidates.count, candidates.lists]))
        clearance, of_clearance = clearance_launches(model, state, candidates)
        minima = [self.strands, model.cell_samples, clearance]
        launches += [
            *of_clearance,
            budget_launch(model, state, candidates, clearance),
            run(range_minima, len(self.partial), minima, [self.partial]),
            run(join_minima, model.cell_count, [self.strands, self.partial], [self.least]),
            *strain_budget_launches(model, state, candidates, self.least),
        ]
        counted = (near.count, candidates.count, near.extent)
        for values, maxima in zip(counted, self.maxima, strict=True):
            launches.append(run(strand_maxima, len(maxima), [wp.float64(1.0), values], [maxima]))
        return launches

    def fits(self) -> bool:
        """Whether it was made for the margin and for the arrays as they are."""
        return self.margin == self.candidates.margin

    def launch(self) -> bool:
        """Make the lists; whether it went well, or they must be made the careful way."""
        self.recording.launch()
        self.candidates.near.reach = self.reach
        near, listed, longest = (float(maxima.numpy().max()) for maxima in self.maxima)
        near_lists = self.candidates.near.lists
        if near > near_lists.shape[1] or listed > self.candidates.lists.shape[1] or not longest <= self.longest:
            return False
        self.holds = self._table_holds()
        # cells that are too close to go on are named there
        return self.holds and bool((self.least.numpy() >= SMALLEST_CLEARANCE).all())

    def _table_holds(self) -> bool:
        """Whether cells have neither grown nor been strained so far that an image may be missing.

        An image is left out of the table if it is clear by 2 * SPREAD radii along one axis. Growth takes some of that,
        and a strain e takes e times the shift, which is at most the box and that distance, along either axis.
        """
        (box, periods), radius = self.table, float(self.model.radius.max())
        size = np.ptp(box, axis=1).max(axis=1)
        growth = (np.ptp(self._box(), axis=1) - np.ptp(box, axis=1)).max(axis=1)
        strain = np.linalg.norm(self._periods() - periods, axis=(1, 2)) / np.linalg.norm(periods, axis=2).min(axis=1)
        taken = growth + 1.5 * strain * (size + (3 + 2 * SPREAD) * radius)
        return bool(((taken <= SPREAD * radius) & (strain <= LARGEST_STRAIN)).all())

    def _box(self) -> NDArray[np.float64]:
        """Lower and upper corner of each cell's box [units], shape (C, 2, 3)."""
        return self.model.constants.images.box.numpy().astype(np.float64).reshape(-1, 2, 3)

    def _periods(self) -> NDArray[np.float64]:
        """Periods of each cell [units], shape (C, 2, 3)."""
        return self.model.constants.images.periods.numpy().astype(np.float64).reshape(-1, 2, 3)
