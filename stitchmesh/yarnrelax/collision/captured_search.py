# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A search for contacts as captured launches: samples, broad phase, narrow phase and step limit.

On a GPU a search is one graph, because the host reads no intermediate results. The launches make four assumptions: the
lists have enough capacity, no segment is longer than the search expects, the near lists of the broad phase are still
complete, and the table of images contains every image that can touch. The last launch collects the values that show
whether the assumptions hold, and the host reads them once. If an assumption fails, the host enlarges the arrays or
makes new lists and tables, and repeats the launches.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches, CopyArray, Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3
from stitchmesh.compute.reduction import maximum
from stitchmesh.compute.thread_block import MOST_THREADS, THREADS, largest_over_block, smallest_over_block
from stitchmesh.simulation.captures import Captures
from stitchmesh.simulation.pair_lists import allocate_lists
from stitchmesh.yarnrelax.collision.broad_phase import (
    SPARE_REACH,
    bound_segments,
    checked_length,
    grid_launches,
    measure_drift,
    near_launches,
)
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates, narrow_launch
from stitchmesh.yarnrelax.collision.step_limit import (
    SMALLEST_CLEARANCE,
    budget_launch,
    clearance_launches,
    strain_budget_launches,
    too_close_cells,
)
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.image_table import SHRINKAGE, SPREAD, has_room, renew_images
from stitchmesh.yarnrelax.model.spline import place_contact_samples
from stitchmesh.yarnrelax.model.state import State

ROOM_TO_GROW = 1.1
"""Segments may grow by this factor before the search is widened."""
BLOCKS = 128
"""Thread blocks that collect the results of a search."""
SAMPLES_PER_PART = 4096
"""Contact samples in a part of a cell on a CPU, whose cores share a cell; on a GPU a block takes the whole cell."""
LARGEST_STRAIN = 0.2
"""Largest strain of a cell since its table of images was made; ``SHRINKAGE`` leaves room for it."""


@wp.func
def part_of(first: int, last: int, block: int, blocks: int) -> wp.vec2i:
    """Where the part of a block in a range begins and ends."""
    size = (last - first + blocks - 1) // blocks
    return wp.vec2i(wp.min(first + block * size, last), wp.min(first + (block + 1) * size, last))


@kernel(tile=THREADS)
def collect_results(
    # state in
    near: wp.array[wp.int32],
    listed: wp.array[wp.int32],
    longest: wp.array[Scalar],
    drift: wp.array[Scalar],
    periods: wp.array[Vec3],
    box: wp.array[Vec3],
    least: wp.array[wp.float64],
    # state out
    results: wp.array2d[wp.float64],
) -> None:
    """One row for each block with the four maxima, then rows of periods, of boxes and of the least clearances."""
    block, lane = wp.tid()
    threads = wp.block_dim()
    cells = least.shape[0]
    blocks = results.shape[0] - 5 * cells
    most = wp.vec4d()
    segments, samples = part_of(0, near.shape[0], block, blocks), part_of(0, listed.shape[0], block, blocks)
    for k in range(segments[0] + lane, segments[1], threads):
        most[0] = wp.max(most[0], wp.float64(near[k]))
        most[2] = wp.max(most[2], wp.float64(longest[k]))
        most[3] = wp.max(most[3], wp.float64(drift[k]))
    for k in range(samples[0] + lane, samples[1], threads):
        most[1] = wp.max(most[1], wp.float64(listed[k]))
    for k in range(4):
        whole = largest_over_block(most[k])
        if lane == 0:
            results[block, k] = whole
    for k in range(block * threads + lane, 2 * cells, blocks * threads):
        if k < periods.shape[0]:  # yarns without a lattice have no periods
            for axis in range(3):
                results[blocks + k, axis] = wp.float64(periods[k][axis])
                results[blocks + 2 * cells + k, axis] = wp.float64(box[k][axis])
        results[blocks + 4 * cells + k // 2, 0] = least[k // 2]


@kernel(tile=MOST_THREADS)
def smallest_of_cells(
    # model
    start: wp.array[wp.int32],
    # state in
    values: wp.array[Scalar],
    # state out
    parts: wp.array2d[wp.float64],
) -> None:
    """Smallest value of each part of a cell, not a number where one value is not a number; one block for each part."""
    number, lane = wp.tid()
    cell = number // parts.shape[1]
    block = number - cell * parts.shape[1]
    part = part_of(start[cell], start[cell + 1], block, parts.shape[1])
    smallest, broken = wp.float64(1.0e300), wp.float64(0.0)
    for k in range(part[0] + lane, part[1], wp.block_dim()):
        value = wp.float64(values[k])
        if value == value:
            smallest = wp.min(smallest, value)
        else:
            broken = wp.float64(1.0)
    whole, odd = smallest_over_block(smallest), largest_over_block(broken)
    if lane == 0:
        parts[cell, block] = wp.where(odd > wp.float64(0.0), wp.float64(wp.nan), whole)


@kernel
def smallest_of_parts(
    # state in
    parts: wp.array2d[wp.float64],
    # state out
    least: wp.array[wp.float64],
) -> None:
    """Smallest value of each cell, not a number where one value is not a number."""
    cell = wp.tid()
    smallest = parts[cell, 0]
    for block in range(1, parts.shape[1]):
        if smallest == smallest and not (parts[cell, block] >= smallest):
            smallest = parts[cell, block]
    least[cell] = smallest


@kernel
def keep_extremes(
    # model
    blocks: int,
    broad: int,
    # state in
    results: wp.array2d[wp.float64],
    # state out
    extremes: wp.array2d[wp.float64],
) -> None:
    """Keep the largest maxima of several searches, and the least of their smallest clearances.

    A search with the broad phase makes new near lists, for which the drift before it does not count.
    """
    row = wp.tid()
    if row >= blocks:
        extremes[row, 0] = wp.min(extremes[row, 0], results[row, 0])
        return
    for column in range(3):
        extremes[row, column] = wp.max(extremes[row, column], results[row, column])
    if broad == 0:
        extremes[row, 3] = wp.max(extremes[row, 3], results[row, 3])


@dataclass(frozen=True, eq=False)
class SearchResults:
    """Results of a search that the host reads."""

    near: int
    """Length of the longest list of near segments."""
    listed: int
    """Length of the longest candidate list."""
    longest: float
    """Largest extent of a segment [units]."""
    drift: float
    """Largest distance by which a segment may have approached others since the broad phase [units]."""
    periods: NDArray[np.float64]
    """Periods of each cell [units], shape (C, 2, 3)."""
    box: NDArray[np.float64]
    """Lower and upper corner of the box around each cell at the last broad phase [units], shape (C, 2, 3)."""
    least: NDArray[np.float64]
    """Smallest clearance of each cell [units], shape (C,)."""


class ContactSearch:
    """A repeatable search that makes candidate lists and budgets for a state."""

    def __init__(self, model: Model, state: State, candidates: Candidates) -> None:
        """Allocate the arrays that a search needs in addition to the lists.

        Args:
            model: constants of the yarns.
            state: the state whose contacts the search finds.
            candidates: the lists to fill.
        """
        self.model, self.state, self.candidates = model, state, candidates
        self.generation = 0
        """A number that changes when the candidate lists or the table of images are replaced."""
        self.drift = model.empty(model.segment_count)
        self.clearance = model.empty(model.sample_count)
        parts = 1 if model.device.is_cuda else max(model.largest_cell // SAMPLES_PER_PART, 1)
        self.parts = wp.zeros((model.cell_count, parts), dtype=wp.float64, device=model.device)
        self.least = self.parts[:, 0] if parts == 1 else wp.zeros(model.cell_count, wp.float64, device=model.device)
        self.collected = wp.zeros((BLOCKS + 5 * model.cell_count, 4), dtype=wp.float64, device=model.device)
        self.no_extremes = np.zeros(self.collected.shape)
        """The extremes of no search."""
        self.no_extremes[BLOCKS:] = np.inf
        self.extremes = wp.array(self.no_extremes, dtype=wp.float64, device=model.device)
        """Extremes of the results of several searches (``unread_launches``), in the shape of ``collected``."""
        self.results: SearchResults | None = None
        self._margin = candidates.margin
        self._longest = 0.0
        self._captures = Captures(self, ContactSearch.generations)
        self._table: SearchResults | None = None
        self._searched: SearchResults | None = None
        self._last_loss = 0.0
        if model.on_lattice:
            renew_images(model, state.points)
        self.points = wp.clone(state.points) if state.cell_relaxes else state.listed_points
        """Control points at the last search; unlike the listed points, they do not follow the strains of a cell."""
        self.periods = wp.clone(model.constants.images.periods) if state.cell_relaxes else None
        """Periods at the last search, of cells that relax."""

    def run(self) -> None:
        """Make lists and budgets for the current state.

        Raises:
            SolverError: yarns lie so dense that the lists would have more than ``MOST_ENTRIES``; the message names the
                place.
        """
        self._margin = self.candidates.margin
        complete = False
        while not complete:
            margin, near = self._margin, self.candidates.near
            found = self._search(broad=near.complete_within - self._last_loss < margin)
            if near.complete_within < margin:
                found = self._search(broad=True)
            complete = self._has_capacity(found) and self._has_images(found)

    def run_again(self, points: NDArray[Any], periods: NDArray[Any] | None) -> None:
        """Make the lists and budgets of an earlier search again, from its points and periods [units].

        The next search starts with the broad phase, because the near lists do not follow the cell to its present state.
        """
        self.state.points.assign(points)
        if periods is not None:
            self.model.constants.images.periods.assign(periods)
            self.candidates.near.invalidate()
        self.run()
        if periods is not None:
            self.candidates.near.invalidate()

    def unread_launches(self, *, broad: bool) -> list[Any]:
        """Return the launches of a search whose results the host does not read before ``extremes_hold``.

        They are for yarns without a lattice. They depend on ``generations``. The launches before the first such search
        set ``extremes`` to ``no_extremes``.
        """
        inputs = [BLOCKS, int(broad), self.collected]
        kept = self.model.prepare(keep_extremes, len(self.collected), inputs, [self.extremes])
        return [*self._prepared(broad=broad), kept]

    def extremes_hold(self, extremes: NDArray[np.float64]) -> bool:
        """Return whether all lists were complete in some searches with unread results, the first with the broad phase.

        If they were not, the lists are out of date. What was too small is enlarged; the yarns must return to the places
        before these searches, and be searched with the broad phase each time if the near lists did not last.

        Args:
            extremes: ``extremes`` after the searches.
        """
        near, (most, listed, longest, drift) = self.candidates.near, extremes[:BLOCKS].max(axis=0).tolist()
        assert self.results is not None
        found = replace(self.results, near=int(most), listed=int(listed), longest=longest, drift=drift)
        near.reach = self._margin + SPARE_REACH
        near.complete_within = near.reach - 2.0 * drift
        if self._has_capacity(found) and near.complete_within >= self._margin:
            return True
        near.invalidate()
        return False

    def too_close(self) -> dict[int, str]:
        """Return a message for each cell in which the clearance of an arc is used up; it names yarn and stitch face."""
        assert self.results is not None
        if (self.results.least >= SMALLEST_CLEARANCE).all():
            return {}
        return too_close_cells(self.model, self.state, self.candidates, self.clearance, self.results.least)

    def _search(self, *, broad: bool) -> SearchResults:
        """Launch a search, with the broad phase or with the last near lists."""
        near = self.candidates.near
        if broad and self._longest == 0.0:
            self._longest = self._longest_extent() * ROOM_TO_GROW
        self._captures.get(broad, lambda: CapturedLaunches(self._prepared(broad=broad), self.model.device)).launch()
        found = self.results = self._read()
        if broad:
            near.reach = near.complete_within = self._margin + SPARE_REACH
            self._searched = found
            self._table = self._table or found
        else:
            before, near.complete_within = near.complete_within, self._reach_left(found)
            self._last_loss = before - near.complete_within
        return found

    def generations(self) -> tuple[float, ...]:
        """Return what the captured launches of a search depend on: arrays, the margin and the largest extent."""
        return self.generation, self.candidates.near.lists.shape[1], self._margin, self._longest

    def _prepared(self, *, broad: bool) -> list[Any]:
        """Return the launches of a search, from the samples to the budgets."""
        model, state, candidates, launcher = self.model, self.state, self.candidates, self.model.prepare
        near = candidates.near
        listed = [near.centre, near.extent, near.listed_centre, near.listed_extent]
        launches = [
            place_contact_samples(model, state, launcher),
            CopyArray(state.points, state.listed_points),
            *self._place_launches(),
            self._bound_launch(launcher),
            launcher(measure_drift, model.segment_count, listed, [self.drift]),
        ]
        if broad:
            reach = self._margin + SPARE_REACH
            launches += grid_launches(model, near, reach, self._longest)
            launches += near_launches(model, near, reach, self._longest)
        clear = [model.cell_samples, self.clearance]
        images = model.constants.images
        lattice = [images.periods, images.box] if model.on_lattice else [model.empty(0, 3), model.empty(0, 3)]
        collected = [near.count, candidates.count, near.extent, self.drift, *lattice, self.least]
        return [
            *launches,
            narrow_launch(model, state.samples, candidates, launcher),
            *clearance_launches(model, state, candidates, self.clearance),
            budget_launch(model, state, candidates, self.clearance),
            launcher(smallest_of_cells, self.parts.size, clear, [self.parts]),
            *self._least_launches(),
            *strain_budget_launches(model, state, candidates, self.least),
            launcher(collect_results, BLOCKS, collected, [self.collected]),
        ]

    def _bound_launch(self, launcher: Launcher) -> Any:
        """Return the launch that finds the ball around each segment."""
        model, near = self.model, self.candidates.near
        inputs = [model.constants, self.state.samples]
        return launcher(bound_segments, model.segment_count, inputs, [near.centre, near.extent])

    def _longest_extent(self) -> float:
        """Return the largest extent of a segment in the current state [units]."""
        place_contact_samples(self.model, self.state, self.model.launch)
        self._bound_launch(self.model.launch)
        return maximum(self.candidates.near.extent)

    def _place_launches(self) -> list[Any]:
        """Return the launches that store the place of a search, if the state does not keep it."""
        if self.periods is None:
            return []
        images = self.model.constants.images
        return [CopyArray(self.state.points, self.points), CopyArray(images.periods, self.periods)]

    def _least_launches(self) -> list[Any]:
        """Return the launch that finds the smallest clearance of each cell from the clearances of its parts."""
        if self.parts.shape[1] == 1:  # one array
            return []
        return [self.model.prepare(smallest_of_parts, self.model.cell_count, [self.parts], [self.least])]

    def _read(self) -> SearchResults:
        collected, cells = self.collected.numpy(), self.model.cell_count
        near, listed, longest, drift = collected[:BLOCKS].max(axis=0).tolist()
        periods, box = collected[BLOCKS : BLOCKS + 4 * cells, :3].reshape(2, cells, 2, 3)
        return SearchResults(int(near), int(listed), longest, drift, periods, box, collected[BLOCKS + 4 * cells :, 0])

    def _reach_left(self, found: SearchResults) -> float:
        """Return the distance within which the near lists are still complete after the motion of segments and cells."""
        near, along = self.candidates.near, 0.0
        if self.model.on_lattice:
            assert self._searched is not None
            strain = _relative_change(found.periods, self._searched.periods)
            along = float(2.0 * strain.max()) * (near.reach + 2.0 * self._longest)
        return near.reach - 2.0 * found.drift - along

    def _has_capacity(self, found: SearchResults) -> bool:
        """Return whether the lists had enough capacity and no segment is too long; otherwise enlarge the arrays."""
        model, candidates, near = self.model, self.candidates, self.candidates.near
        if found.near > near.lists.shape[1]:
            near.lists = allocate_lists(
                model.segment_count, checked_length(model, near.count, found.near), model.device
            )
        elif found.listed > candidates.lists.shape[1]:
            needed = checked_length(model, candidates.count, found.listed)
            candidates.lists = allocate_lists(model.sample_count, needed, model.device)
            self.generation += 1
            return False
        elif found.longest > self._longest:
            self._longest = found.longest * ROOM_TO_GROW
        else:
            return True
        near.invalidate()
        return False

    def _has_images(self, found: SearchResults) -> bool:
        """Return whether the table of images is still complete; otherwise make it again.

        In a batch of many cells some cells often outgrow the table, but other cells already needed the images that they
        then need. In this case nothing changes.
        """
        if not self.model.on_lattice:
            return True
        outgrown = self._outgrown(found)
        if not outgrown.any():
            return True
        if self.model.cell_count > 1 and has_room(self.model, self.state.points, outgrown):
            assert self._table is not None
            periods = np.where(outgrown[:, None, None], found.periods, self._table.periods)
            box = np.where(outgrown[:, None, None], found.box, self._table.box)
            self._table = replace(self._table, periods=periods, box=box)
            return True
        renew_images(self.model, self.state.points, anyway=True)
        self._table = None
        self.candidates.near.invalidate()
        self.generation += 1
        return False

    def _outgrown(self, found: SearchResults) -> NDArray[np.bool_]:
        """Return whether each cell has grown or been strained so far that an image may be missing, shape (C,).

        The table omits an image if, with shrunk periods, its distance along one axis exceeds the contact range by
        2 * SPREAD radii. Growth of the cells reduces this distance. A shear c reduces it by c times the extent along
        the other axis; this extent is at most the extent of the box plus the same range. No table suits a cell whose
        points are not finite; ``too_close`` refuses such a cell.
        """
        assert self._table is not None
        box, periods, radius = self._table.box, self._table.periods, float(self.model.radius.max())
        extent, now = box[:, 1] - box[:, 0], found.periods
        size = extent.max(axis=1)
        growth = (found.box[:, 1] - found.box[:, 0] - extent).max(axis=1)
        strain = _relative_change(now, periods)
        # the part of the change of the second period that is along the first period
        along = np.einsum("cd,cd->c", now[:, 1] - periods[:, 1], periods[:, 0])
        shear = np.abs(along) / np.linalg.norm(np.cross(periods[:, 0], periods[:, 1]), axis=1)
        taken = growth + shear * (size + (3 + 2 * SPREAD) * radius) / SHRINKAGE
        taken, strain = np.where(np.isfinite(taken), taken, 0.0), strain.max(axis=1)
        return (taken > SPREAD * radius) | (strain > LARGEST_STRAIN)


def _relative_change(periods: NDArray[np.float64], before: NDArray[np.float64]) -> NDArray[np.float64]:
    """Change of each period over its length, shape (C, 2)."""
    return np.asarray(np.linalg.norm(periods - before, axis=2) / np.linalg.norm(before, axis=2))
