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

from stitchmesh.compute.captured import CapturedLaunches, CopyArray
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.thread_block import MOST_THREADS, THREADS
from stitchmesh.yarnrelax.collision.broad_phase import (
    NOTHING_LISTED,
    SPARE_REACH,
    bound_segments,
    grid_launches,
    measure_drift,
    near_launches,
)
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates, list_samples
from stitchmesh.yarnrelax.collision.step_limit import (
    SMALLEST_CLEARANCE,
    budget_launch,
    clearance_launches,
    strain_budget_launches,
)
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.contact_samples import place_contact_samples
from stitchmesh.yarnrelax.model.image_table import SHRINKAGE, SPREAD
from stitchmesh.yarnrelax.model.state import State

ROOM_TO_GROW = 1.1
"""How much longer than now segments may become before the search must be made wider."""
BLOCKS = 128
"""Blocks of threads that collect what is looked at."""
LARGEST_STRAIN = 0.2
"""Largest strain of a cell since its table of images was made, for which its ``SHRINKAGE`` leaves room."""


@kernel
def collect(
    # state in
    near: wp.array[wp.int32],
    listed: wp.array[wp.int32],
    longest: wp.array[Any],
    drift: wp.array[Any],
    periods: wp.array[Any],
    box: wp.array[Any],
    least: wp.array[wp.float64],
    # state out
    facts: wp.array2d[wp.float64],
) -> None:
    """For one look: the largest of each in a row for each block, then rows of periods, of boxes and of the least."""
    block, lane = wp.tid()
    threads = wp.block_dim()
    cells = least.shape[0]
    blocks = facts.shape[0] - 5 * cells
    most = wp.vec4d()
    for k in range(block * threads + lane, near.shape[0], blocks * threads):
        most[0] = wp.max(most[0], wp.float64(near[k]))
        most[2] = wp.max(most[2], wp.float64(longest[k]))
        most[3] = wp.max(most[3], wp.float64(drift[k]))
    for k in range(block * threads + lane, listed.shape[0], blocks * threads):
        most[1] = wp.max(most[1], wp.float64(listed[k]))
    for k in range(4):
        whole = wp.tile_max(wp.tile(most[k]))
        if lane == 0:
            facts[block, k] = whole[0]
    for k in range(block * threads + lane, 2 * cells, blocks * threads):
        for axis in range(3):
            facts[blocks + k, axis] = wp.float64(periods[k][axis])
            facts[blocks + 2 * cells + k, axis] = wp.float64(box[k][axis])
        facts[blocks + 4 * cells + k // 2, 0] = least[k // 2]


@kernel
def smallest_of_cells(
    # model
    start: wp.array[wp.int32],
    # state in
    values: wp.array[Any],
    # state out
    least: wp.array[wp.float64],
) -> None:
    """Smallest value of each cell, not a number where one is not; a block a cell."""
    cell, lane = wp.tid()
    smallest, broken = wp.float64(1.0e300), wp.float64(0.0)
    for k in range(start[cell] + lane, start[cell + 1], wp.block_dim()):
        value = wp.float64(values[k])
        if value == value:
            smallest = wp.min(smallest, value)
        else:
            broken = wp.float64(1.0)
    whole, odd = wp.tile_min(wp.tile(smallest)), wp.tile_max(wp.tile(broken))
    if lane == 0:
        least[cell] = whole[0]
        if odd[0] > wp.float64(0.0):
            least[cell] = wp.float64(wp.nan)


class CapturedSearch:
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
        self.reach = self.margin + SPARE_REACH
        self.longest = float(near.extent.numpy().max()) * ROOM_TO_GROW
        cells, device = model.cell_count, model.device
        self.table = (self._box(), self._periods()) if table is None else table
        self.holds = True
        """Whether the table did when it was last looked at."""
        self.least = wp.zeros(cells, dtype=wp.float64, device=device)
        self.drift = model.empty(model.segment_count)
        self.facts = wp.zeros((BLOCKS + 5 * cells, 4), dtype=wp.float64, device=device)
        self.quick = CapturedLaunches(self._launches([]), device)
        self.whole = CapturedLaunches(self._launches(self._search()), device)
        self.now = self.searched = self._periods()
        self.box, self.clearance = self._box(), np.zeros(cells)
        self.left, self.taken = self.reach, 0.0
        """How far the lists of near segments still reached when it was last looked at, and what the last move took."""

    def _search(self) -> list[Any]:
        """List the segments near each segment anew."""
        near = self.candidates.near
        return [*grid_launches(self.model, near, self.reach, self.longest),
                *near_launches(self.model, near, self.reach, self.longest)]  # fmt: skip

    def _launches(self, search: list[Any]) -> list[Any]:
        """All from the samples to the budgets, with a search or with what the last one found."""
        model, state, candidates = self.model, self.state, self.candidates
        near, launcher = candidates.near, model.prepare
        centres = [near.centre, near.extent]
        launches = [
            place_contact_samples(model, state, launcher),
            CopyArray(state.points, state.listed_points),
            launcher(bound_segments, model.segment_count, [model.constants, state.samples], centres),
            launcher(
                measure_drift, model.segment_count, [*centres, near.listed_centre, near.listed_extent], [self.drift]
            ),
            *search,
        ]
        inputs = [model.constants, model.number(self.margin), model.segment_count, state.samples, near.centre,
                  near.extent, near.count, near.lists]  # fmt: skip
        launches.append(launcher(list_samples, model.sample_count, inputs, [candidates.count, candidates.lists]))
        clearance, of_clearance = clearance_launches(model, state, candidates)
        launches += [
            *of_clearance,
            budget_launch(model, state, candidates, clearance),
            launcher(
                smallest_of_cells, model.cell_count, [model.cell_samples, clearance], [self.least], tile=MOST_THREADS
            ),
            *strain_budget_launches(model, state, candidates, self.least),
        ]
        images = model.constants.images
        looked_at = [near.count, candidates.count, near.extent, self.drift, images.periods, images.box, self.least]
        return [*launches, launcher(collect, BLOCKS, looked_at, [self.facts], tile=THREADS)]

    def fits(self) -> bool:
        """Whether it was made for the margin and for the arrays as they are."""
        return self.margin == self.candidates.margin

    def launch(self) -> bool:
        """Make the lists; whether it went well, or they must be made the careful way."""
        due = self.candidates.near.reach != self.reach or self.left - self.taken < self.margin
        found = self._listed(search=due)
        if self.left < self.margin:
            found = self._listed(search=True)
        near, listed, longest = found[:3]
        near_lists = self.candidates.near.lists
        if near > near_lists.shape[1] or listed > self.candidates.lists.shape[1] or not longest <= self.longest:
            return False
        self.holds = self._table_holds()
        # cells that are too close to go on are named there
        return self.holds and bool((self.clearance >= SMALLEST_CLEARANCE).all())

    def _listed(self, *, search: bool) -> NDArray[np.float64]:
        """Make the lists, with a search if it is due; what was read."""
        before = self.left
        if search:
            self.whole.launch()
            self.candidates.near.reach = self.reach
            found = self._read()
            self.searched, self.left = self.now, self.reach
        else:
            self.quick.launch()
            found = self._read()
            self.left = self._reach_left(found)
            self.taken = before - self.left
        return found

    def _read(self) -> NDArray[np.float64]:
        """Longest lists, longest segment, largest drift; periods, boxes and smallest clearances are kept."""
        facts = self.facts.numpy()
        cells = len(self.clearance)
        of_cells, self.clearance = facts[BLOCKS : BLOCKS + 4 * cells, :3], facts[BLOCKS + 4 * cells :, 0]
        self.now, self.box = of_cells[: 2 * cells].reshape(-1, 2, 3), of_cells[2 * cells :].reshape(-1, 2, 3)
        return np.asarray(facts[:BLOCKS].max(axis=0))

    def _reach_left(self, found: NDArray[np.float64]) -> float:
        """Up to which distance the lists of near segments still hold all: less what segments and cells moved."""
        if self.candidates.near.reach != self.reach:
            return NOTHING_LISTED
        strain = np.linalg.norm(self.now - self.searched, axis=2) / np.linalg.norm(self.searched, axis=2)
        along = float(2.0 * strain.max()) * (self.reach + 2.0 * self.longest)
        return float(self.reach - 2.0 * found[3] - along)

    def _table_holds(self) -> bool:
        """Whether cells have neither grown nor been strained so far that an image may be missing.

        An image is left out if, its periods shrunk, it is clear by 2 * SPREAD radii along one axis and so not farther
        than that and the box along the other. Growth takes some of that, and shear c takes c times the other.
        """
        (box, periods), radius = self.table, float(self.model.radius.max())
        size, now = np.ptp(box, axis=1).max(axis=1), self.now
        growth = (np.ptp(self.box, axis=1) - np.ptp(box, axis=1)).max(axis=1)
        strain = np.linalg.norm(now - periods, axis=2) / np.linalg.norm(periods, axis=2)
        # part of the second period's change that is along the first one
        along = np.einsum("cd,cd->c", now[:, 1] - periods[:, 1], periods[:, 0])
        shear = np.abs(along) / np.linalg.norm(np.cross(periods[:, 0], periods[:, 1]), axis=1)
        taken = growth + shear * (size + (3 + 2 * SPREAD) * radius) / SHRINKAGE
        return bool(((taken <= SPREAD * radius) & (strain.max(axis=1) <= LARGEST_STRAIN)).all())

    def _box(self) -> NDArray[np.float64]:
        """Lower and upper corner of each cell's box [units], shape (C, 2, 3)."""
        return self.model.constants.images.box.numpy().astype(np.float64).reshape(-1, 2, 3)

    def _periods(self) -> NDArray[np.float64]:
        """Periods of each cell [units], shape (C, 2, 3)."""
        return self.model.constants.images.periods.numpy().astype(np.float64).reshape(-1, 2, 3)
