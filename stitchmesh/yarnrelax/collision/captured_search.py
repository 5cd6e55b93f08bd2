# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A search for contacts as captured launches: samples, broad phase, narrow phase and step limit.

On a GPU a search is one graph, or two with the hash grid of a broad phase between them (``GridBuild``), because the
host reads no intermediate results. The launches make four assumptions: the lists have enough capacity, no segment is
longer than the search expects, the near lists of the broad phase are still complete, and the table of images contains
every image that can touch. The last launch collects the values that show whether the assumptions hold, and the host
reads them once. If an assumption fails, the host enlarges the arrays or makes new lists and tables, and repeats the
launches.

A search serves some cells of a batch, or all. The lists, budgets and places of the other cells stay as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches, Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3
from stitchmesh.compute.reduction import maximum
from stitchmesh.compute.thread_block import MOST_THREADS, THREADS, largest_over_block, smallest_over_block
from stitchmesh.simulation.captures import Captures
from stitchmesh.simulation.pair_lists import allocate_lists
from stitchmesh.yarnrelax.collision.broad_phase import (
    NOTHING_LISTED,
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
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.image_table import SHRINKAGE, SPREAD, has_images, has_room, renew_images
from stitchmesh.yarnrelax.model.lattice_images import cell_of, rests
from stitchmesh.yarnrelax.model.spline import place_contact_samples
from stitchmesh.yarnrelax.model.state import State

ROOM_TO_GROW = 1.1
"""Segments may grow by this factor before the search is widened."""
BLOCKS = 128
"""Thread blocks that collect the results of a search."""
SAMPLES_PER_PART = {"cpu": 4096, "cuda": 32_768}
"""Contact samples in a part of a cell, whose smallest clearance one core or one block of threads finds."""
LARGEST_STRAIN = 0.2
"""Largest strain of a cell since its table of images was made; ``SHRINKAGE`` leaves room for it."""


@wp.func
def part_of(first: int, last: int, block: int, blocks: int) -> wp.vec2i:
    """Where the part of a block in a range begins and ends."""
    size = (last - first + blocks - 1) // blocks
    return wp.vec2i(wp.min(first + block * size, last), wp.min(first + (block + 1) * size, last))


@kernel(tile=THREADS)
def collect_results(
    # model
    cell_segments: wp.array[wp.int32],
    cell_samples: wp.array[wp.int32],
    parts: int,
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
    """A row for each part of a cell with the four maxima, then rows of periods, of boxes and of least clearances."""
    block, lane = wp.tid()
    threads = wp.block_dim()
    cells = least.shape[0]
    blocks = parts * cells
    cell = block // parts
    part = block - cell * parts
    most = wp.vec4d()
    segments = part_of(cell_segments[cell], cell_segments[cell + 1], part, parts)
    samples = part_of(cell_samples[cell], cell_samples[cell + 1], part, parts)
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


@kernel
def keep_places(
    # model
    model: YarnConstants,
    point_count: int,
    # state in
    points: wp.array[Vec3],
    # state out
    listed_points: wp.array[Vec3],
) -> None:
    """The places of control points and strains at a search."""
    i = wp.tid()
    cell = i - point_count
    if i < point_count:
        cell = cell_of(model.images, wp.max(model.point_segments[i]))
    if not rests(model.images, cell):
        listed_points[i] = points[i]


@kernel
def keep_periods(
    # model
    model: YarnConstants,
    # state in
    periods: wp.array[Vec3],
    # state out
    searched: wp.array[Vec3],
) -> None:
    """The periods of cells at a search."""
    k = wp.tid()
    if not rests(model.images, k // 2):
        searched[k] = periods[k]


@dataclass(frozen=True, eq=False)
class SearchResults:
    """Results of a search that the host reads; the results of a cell that took no part are those of its last one."""

    near: NDArray[np.float64]
    """Length of the longest list of near segments in each cell, shape (C,)."""
    listed: NDArray[np.float64]
    """Length of the longest candidate list in each cell, shape (C,)."""
    longest: NDArray[np.float64]
    """Largest extent of a segment in each cell [units], shape (C,)."""
    drift: NDArray[np.float64]
    """Largest distance by which a segment of each cell may have approached others since its broad phase [units], shape
    (C,); it means nothing for a cell that took no part."""
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
        parts = max(model.largest_cell // SAMPLES_PER_PART["cuda" if model.device.is_cuda else "cpu"], 1)
        self.parts = wp.zeros((model.cell_count, parts), dtype=wp.float64, device=model.device)
        self.least = self.parts[:, 0] if parts == 1 else wp.zeros(model.cell_count, wp.float64, device=model.device)
        self.collecting = max(BLOCKS // model.cell_count, 1)
        """Number of blocks that collect the results of a cell."""
        rows = (self.collecting + 5) * model.cell_count
        self.collected = wp.zeros((rows, 4), dtype=wp.float64, device=model.device)
        self.no_extremes = np.zeros(self.collected.shape)
        """The extremes of no search."""
        self.no_extremes[self.collecting * model.cell_count :] = np.inf
        self.extremes = wp.array(self.no_extremes, dtype=wp.float64, device=model.device)
        """Extremes of the results of several searches (``unread_launches``), in the shape of ``collected``."""
        self.results: SearchResults | None = None
        self._longest = 0.0
        self._captures = Captures(self, ContactSearch.generations)
        self._table: SearchResults | None = None
        self._listed_periods = np.ones((model.cell_count, 2, 3))
        """Periods of each cell at its last broad phase [units], shape (C, 2, 3)."""
        self._last_loss = np.zeros(model.cell_count)
        """Loss of ``NearSegments.complete_within`` at the last search of each cell [units], shape (C,)."""
        if model.on_lattice and not has_images(model, state.points):
            renew_images(model, state.points)
        self.points = wp.clone(state.points) if state.cell_relaxes else state.listed_points
        """Control points at the last search; unlike the listed points, they do not follow the strains of a cell."""
        self.periods = wp.clone(model.constants.images.periods) if state.cell_relaxes else None
        """Periods at the last search, of cells that relax."""

    def run(self, cells: NDArray[np.bool_] | None = None) -> None:
        """Make lists and budgets for the current state, in some cells, shape (C,), or in all.

        Raises:
            SolverError: yarns lie so dense that the lists would have more than ``MOST_ENTRIES``; the message names the
                place.
        """
        near = self.candidates.near
        left = np.ones(self.model.cell_count, dtype=bool) if cells is None else cells
        while left.any():
            found = self._search(left, left & (near.complete_within - self._last_loss < self.candidates.margins))
            incomplete = left & (near.complete_within < self.candidates.margins)
            if incomplete.any():
                found = self._search(incomplete, incomplete)
            left = left & (self._outgrow_lists(found, left) | self._outgrow_images(found, left))

    def run_again(
        self, points: NDArray[Any], periods: NDArray[Any] | None, cells: NDArray[np.bool_] | None = None
    ) -> None:
        """Make the lists and budgets of an earlier search again, from its points and periods [units].

        The next search starts with the broad phase, because the near lists do not follow the cell to its present state.

        Args:
            points: the control points and strains at the search.
            periods: the periods at the search; None if no cell relaxes.
            cells: the cells whose lists are made, shape (C,); all by default.
        """
        self.state.points.assign(points)
        if periods is not None:
            self.model.constants.images.periods.assign(periods)
            self.candidates.near.invalidate(cells)
        self.run(cells)
        if periods is not None:
            self.candidates.near.invalidate(cells)

    def unread_launches(self, *, broad: bool) -> list[Any]:
        """Return the launches of a search whose results the host does not read before ``extremes_hold``.

        They are for yarns without a lattice. They depend on ``generations``. The launches before the first such search
        set ``extremes`` to ``no_extremes``.
        """
        wanted = self.candidates.margins + SPARE_REACH
        self.candidates.near.wanted.assign(wanted)
        inputs = [self.collecting * self.model.cell_count, int(broad), self.collected]
        kept = self.model.prepare(keep_extremes, len(self.collected), inputs, [self.extremes])
        return [*self._prepared(float(wanted.max()) if broad else None), kept]

    def extremes_hold(self, extremes: NDArray[np.float64]) -> bool:
        """Return whether all lists were complete in some searches with unread results, the first with the broad phase.

        If they were not, the lists are out of date. What was too small is enlarged; the yarns must return to the places
        before these searches, and be searched with the broad phase each time if the near lists did not last.

        Args:
            extremes: ``extremes`` after the searches.
        """
        candidates, cells = self.candidates, self.model.cell_count
        assert self.results is not None
        near, listed, longest, drift = extremes[: self.collecting * cells].reshape(cells, -1, 4).max(axis=1).T
        found = replace(self.results, near=near, listed=listed, longest=longest, drift=drift)
        candidates.near.reach = candidates.margins + SPARE_REACH
        candidates.near.complete_within = self._reach_left(found)
        outgrown = self._outgrow_lists(found, np.ones(cells, dtype=bool)).any()
        if not outgrown and (candidates.near.complete_within >= candidates.margins).all():
            return True
        candidates.near.invalidate()
        return False

    def too_close(self, cells: NDArray[np.bool_] | None = None) -> dict[int, str]:
        """Return a message for each cell, of some or all, in which the clearance of an arc is used up.

        The message names yarn and stitch face.
        """
        assert self.results is not None
        found = ~(self.results.least >= SMALLEST_CLEARANCE)
        if cells is not None:
            found &= cells
        if not found.any():
            return {}
        return too_close_cells(self.model, self.state, self.candidates, self.clearance, found)

    def _search(self, cells: NDArray[np.bool_], broadly: NDArray[np.bool_]) -> SearchResults:
        """Launch a search in some cells: for some with the broad phase, for the others with their last near lists.

        Both arguments have the shape (C,).
        """
        near, broad = self.candidates.near, bool(broadly.any())
        with self.model.only_in(cells):
            if broad:
                if self._longest == 0.0:
                    self._longest = self._longest_extent() * ROOM_TO_GROW
                wanted = self.candidates.margins + SPARE_REACH
                near.wanted.assign(np.where(broadly, wanted, NOTHING_LISTED))
                name = "broad", float(wanted.max())
                self._captures.get(name, lambda: self._captured(float(wanted.max()))).launch()
                near.reach = np.where(broadly, wanted, near.reach)
            else:
                self._captures.get("narrow", lambda: self._captured(None)).launch()
        found = self.results = self._read()
        if broad:
            near.complete_within = np.where(broadly, near.reach, near.complete_within)
            self._listed_periods = np.where(broadly[:, None, None], found.periods, self._listed_periods)
            self._table = self._table or found
        narrowly = cells & ~broadly
        if narrowly.any():
            before, now = near.complete_within, self._reach_left(found)
            near.complete_within = np.where(narrowly, now, before)
            self._last_loss = np.where(narrowly, before - now, self._last_loss)
        return found

    def generations(self) -> tuple[float, ...]:
        """Return what the captured launches of a search depend on: arrays and the largest extent."""
        return self.generation, self.candidates.near.lists.shape[1], self._longest

    def _captured(self, reach: float | None) -> CapturedLaunches:
        """Return the captured launches of a search, with a broad phase of this largest reach [units] or without."""
        return CapturedLaunches(self._prepared(reach), self.model.device)

    def _prepared(self, reach: float | None) -> list[Any]:
        """Return the launches of a search, from the samples to the budgets."""
        model, state, candidates, launcher = self.model, self.state, self.candidates, self.model.prepare
        near = candidates.near
        listed = [near.centre, near.extent, near.listed_centre, near.listed_extent]
        launches = [
            place_contact_samples(model, state, launcher),
            self._keep_launch(state.listed_points),
            *self._place_launches(),
            self._bound_launch(launcher),
            launcher(measure_drift, model.segment_count, listed, [self.drift]),
        ]
        if reach is not None:
            launches += grid_launches(model, near, reach, self._longest)
            launches += near_launches(model, near, reach, self._longest)
        clear = [model.cell_samples, self.clearance]
        images = model.constants.images
        lattice = [images.periods, images.box] if model.on_lattice else [model.empty(0, 3), model.empty(0, 3)]
        inputs = [model.cell_segments, model.cell_samples, self.collecting, near.count, candidates.count, near.extent,
                  self.drift, *lattice, self.least]  # fmt: skip
        return [
            *launches,
            narrow_launch(model, state.samples, candidates, launcher),
            *clearance_launches(model, state, candidates, self.clearance),
            budget_launch(model, state, candidates, self.clearance),
            launcher(smallest_of_cells, self.parts.size, clear, [self.parts]),
            *self._least_launches(),
            *strain_budget_launches(model, state, candidates, self.least),
            launcher(collect_results, self.collecting * model.cell_count, inputs, [self.collected]),
        ]

    def _keep_launch(self, places: wp.array[Any]) -> Any:
        """Return the launch that stores the control points and strains of the cells that are searched."""
        model, points = self.model, self.state.points
        return model.prepare(keep_places, len(points), [model.constants, model.point_count, points], [places])

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
        model, images = self.model, self.model.constants.images
        keep = model.prepare(keep_periods, len(self.periods), [model.constants, images.periods], [self.periods])
        return [self._keep_launch(self.points), keep]

    def _least_launches(self) -> list[Any]:
        """Return the launch that finds the smallest clearance of each cell from the clearances of its parts."""
        if self.parts.shape[1] == 1:  # one array
            return []
        return [self.model.prepare(smallest_of_parts, self.model.cell_count, [self.parts], [self.least])]

    def _read(self) -> SearchResults:
        # On a CPU the array is the memory of the device, which the next search overwrites.
        collected, cells = self.collected.numpy().copy(), self.model.cell_count
        parts = self.collecting * cells
        near, listed, longest, drift = collected[:parts].reshape(cells, -1, 4).max(axis=1).T
        periods, box = collected[parts : parts + 4 * cells, :3].reshape(2, cells, 2, 3)
        least = collected[parts + 4 * cells :, 0]
        return SearchResults(near, listed, longest, drift, periods, box, least)

    def _reach_left(self, found: SearchResults) -> NDArray[np.float64]:
        """Return the distances within which the near lists are still complete after the motion of cells, shape (C,)."""
        near = self.candidates.near
        left = near.reach - 2.0 * found.drift
        if self.model.on_lattice:
            strain = _relative_change(found.periods, self._listed_periods).max(axis=1)
            left -= 2.0 * strain * (near.reach + 2.0 * self._longest)
        return np.asarray(left)

    def _outgrow_lists(self, found: SearchResults, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which of some cells need longer lists or have too long segments, shape (C,); enlarge the arrays."""
        model, candidates, near = self.model, self.candidates, self.candidates.near
        crowded = cells & (found.near > near.lists.shape[1])
        unlisted = cells & (found.listed > candidates.lists.shape[1])
        long = cells & (found.longest > self._longest)
        if long.any():
            self._longest = float(found.longest[long].max()) * ROOM_TO_GROW
            near.invalidate(long)
        if unlisted.any():
            candidates.enlarge(checked_length(model, candidates.count, int(found.listed[unlisted].max())))
            self.generation += 1
        if crowded.any():
            needed = checked_length(model, near.count, int(found.near[crowded].max()))
            near.lists = allocate_lists(model.segment_count, needed, model.device)
            near.invalidate()
        return crowded | unlisted | long

    def _outgrow_images(self, found: SearchResults, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which of some cells have outgrown the table of images, shape (C,); then make it again.

        In a batch of many cells some cells often outgrow the table, but other cells already needed the images that they
        then need. In this case nothing changes. A new table of a batch holds the images of the former one too, because
        the candidate lists of other cells name them.
        """
        nothing = np.zeros_like(cells)
        if not self.model.on_lattice:
            return nothing
        outgrown = cells & self._outgrown(found)
        if not outgrown.any():
            return nothing
        if self.model.cell_count > 1 and has_room(self.model, self.state.points, outgrown):
            assert self._table is not None
            periods = np.where(outgrown[:, None, None], found.periods, self._table.periods)
            box = np.where(outgrown[:, None, None], found.box, self._table.box)
            self._table = replace(self._table, periods=periods, box=box)
            return nothing
        self.candidates.renumber(renew_images(self.model, self.state.points))
        self._table = None
        self.candidates.near.invalidate()
        self.generation += 1
        return outgrown

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
