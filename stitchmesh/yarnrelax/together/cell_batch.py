# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A batch of cells on its way to rest: which cells take part in the next launches, and when a part goes on alone.

Cells at rest stand still, but launches still pass over them. When the cells that are not at rest are only a small part
of all (``SMALL_PART``), they continue as a batch of their own. A launch of few cells takes hardly less time than a
launch of many, so that the last cells of a batch cost most. If other cells may follow, the rest of the cells
(``LAST_PART``) is therefore left, to continue together with these. The swatches of the cells at rest go on meanwhile,
so that the first of many are ready early. A cell continues with the same bits (``carried_cells``). Its result therefore
depends on no other cell, and on no batch in which it takes part.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.errors import OverloadError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.quality import Quality
from stitchmesh.time_limit import OutOfTime, without_limit
from stitchmesh.yarn import YarnSet, segment_lengths
from stitchmesh.yarnrelax.assessment import Assessments
from stitchmesh.yarnrelax.convergence import hidden_by_rounding, rest_text
from stitchmesh.yarnrelax.energies.confinement import CellConfinements, Confinement
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell
from stitchmesh.yarnrelax.solvers.lbfgs import LBFGS
from stitchmesh.yarnrelax.together.carried_cells import CarriedCell, put_into, taken_out

CellProgress = Callable[[int, int], None]
"""Called with the number of cells at rest and the number of iterations."""
SMALL_PART = {"cpu": 0.25, "cuda": 0.5}
"""The cells that are not at rest continue without the others if they have less than this part of all contact samples.
On a GPU few cells take nearly as long as many."""
LAST_PART, LAST_PART_OF_MANY, MANY = 0.1, 0.5, 128
"""Largest part of the cells that a batch may leave for the next one: in general, and in a batch of at least ``MANY``
cells. A batch of few cells takes nearly as long to begin as one of many, so that it should begin rarely."""


@dataclass(frozen=True, eq=False)
class RelaxedCell:
    """A cell after its relaxation in a batch."""

    yarns: YarnSet
    """The yarns at rest, or in their last accepted state."""
    report: dict[str, Any]
    """iterations, tenth_iterations (iterations to a tenth of the first gradient, None if it was never reached),
    gradient (the last gradient over the first), converged, residual, hidden_by_rounding and remaining_change (as in
    ``Relaxation.report``), energy [erg], energies [erg], max_strain, min_distance_over_radius, and error (why the cell
    could not continue, or None)."""
    history: list[HistoryEntry]
    """The figures of each assessment in which the cell took part."""

    def __repr__(self) -> str:
        """Return one line: whether the yarns are at rest, and the yarns."""
        return f"RelaxedCell({rest_text(self.report)}, {self.yarns})"


@dataclass(frozen=True, eq=False)
class CellHistory:
    """The figures of the assessments of a cell, as a table: a batch assesses thousands of cells in each interval."""

    terms: tuple[str, ...]
    """Names of the energies."""
    table: NDArray[np.float64]
    """A row for each assessment: iteration, seconds, residual, and the energy of each term [erg]."""

    def entries(self) -> list[HistoryEntry]:
        """Return the entry of each assessment."""
        return [
            HistoryEntry(iteration=int(iteration), seconds=seconds, residual=residual,
                         energies=dict(zip(self.terms, energies, strict=True)))
            for iteration, seconds, residual, *energies in self.table.tolist()
        ]  # fmt: skip


class CellHistories:
    """The histories of the cells of a batch."""

    def __init__(self, before: Sequence[CellHistory | None]) -> None:
        """Begin with what was noted in other batches."""
        self._before = before
        self._terms: tuple[str, ...] = ()
        self._cells: list[NDArray[np.int64]] = []
        self._tables: list[NDArray[np.float64]] = []

    def note(
        self, cells: NDArray[np.bool_], iterations: NDArray[np.int64], seconds: NDArray[np.float64], last: Assessments
    ) -> None:  # fmt: skip
        """Add the last assessments of some cells; all arguments have a row for each cell of the batch."""
        self._terms = tuple(last.energies)
        columns = iterations, seconds, last.residual, *last.energies.values()
        self._cells.append(np.flatnonzero(cells))
        self._tables.append(np.column_stack([column[cells] for column in columns]))

    def of(self, cells: NDArray[np.bool_]) -> list[CellHistory]:
        """Return the histories of some cells, shape (C,)."""
        of_row = np.concatenate(self._cells)
        order = np.argsort(of_row, kind="stable")
        table, start = np.concatenate(self._tables)[order], np.searchsorted(of_row[order], np.arange(len(cells) + 1))
        found = list[CellHistory]()
        for cell in np.flatnonzero(cells).tolist():
            before, own = self._before[cell], table[start[cell] : start[cell + 1]]
            whole = own if before is None else np.concatenate([before.table, own])
            found.append(CellHistory(self._terms, whole))
        return found


@dataclass(frozen=True, eq=False)
class BegunCell:
    """A cell between two batches."""

    carried: CarriedCell
    """Everything that decides how the cell continues."""
    history: CellHistory
    """The figures of each assessment."""
    seconds: float
    """Time that the cell has spent in batches [s]."""


@dataclass(frozen=True, eq=False)
class CellBatch:
    """Cells that are relaxed together, with the choices for each cell."""

    given: Sequence[tuple[YarnSet, YarnMaterial]]
    free: Sequence[RelaxCell] | None
    planes: Sequence[Confinement | None] | None
    quality: Quality
    device: wp.Device
    most: NDArray[np.int64]
    """Largest number of iterations of each cell, shape (C,)."""
    samples: Sequence[int] | None = None
    """Number of contact samples in a segment, for each cell; None for the number of the quality."""
    begun: Sequence[BegunCell | None] | None = None
    """The cells that another batch has begun with the same given yarns; None for cells that begin."""

    def simulation(self) -> YarnSimulation:
        """Return a simulation of the cells on the device."""
        terms = []
        if self.planes is not None:
            terms = [CellConfinements(tuple(self.planes))]
        return YarnSimulation(self.given, self.quality, self.device, terms, cells=self.free, samples=self.samples)

    def part(self, cells: NDArray[np.bool_]) -> CellBatch:
        """Return a batch of some of the given cells."""
        return replace(self, given=_some(self.given, cells), free=_some(self.free, cells), most=self.most[cells],
                       planes=_some(self.planes, cells), samples=_some(self.samples, cells),
                       begun=_some(self.begun, cells))  # fmt: skip

    def continued(self, cells: NDArray[np.bool_], begun: Sequence[BegunCell]) -> CellBatch:
        """Return a batch of some of the cells in their present state, which ``begun`` holds."""
        return replace(self.part(cells), begun=begun)


def _some(each: Sequence[Any] | None, cells: NDArray[np.bool_]) -> Any:
    """Return the entries of some of the cells; None if there are no entries."""
    return None if each is None else [own for own, chosen in zip(each, cells.tolist(), strict=True) if chosen]


def relax_batch(
    batch: CellBatch, progress: CellProgress | None, *, others_follow: bool = False
) -> tuple[list[RelaxedCell | BegunCell], int]:  # fmt: skip
    """Relax the cells of a batch.

    Args:
        batch: the cells.
        progress: called after each assessment.
        others_follow: whether the last cells may be left, to continue in a batch with others.

    Returns:
        The cells in their order, and the iterations of the cell that did the most.
    """
    found: dict[int, RelaxedCell | BegunCell] = {}
    numbers = np.arange(len(batch.given))
    launched = 0
    part = LAST_PART_OF_MANY if len(numbers) >= MANY else LAST_PART
    few = part * len(numbers) if others_follow else 0.0
    while True:
        run = _Run(batch.simulation(), batch)
        while run.active.sum() > few and not run.is_mostly_done:
            try:
                run.advance()
            except OutOfTime:
                run.active[:] = False  # all cells end with their last accepted states
            if progress is not None:
                progress(len(found) + int((~run.active).sum()), run.loop.iteration)
        launched = max(launched, run.loop.iteration)
        remaining = run.active
        begun = run.begun(remaining)
        found |= {int(numbers[k]): cell for k, cell in run.relaxed(~remaining).items()}
        numbers = numbers[remaining]
        if not len(numbers):
            break
        if len(numbers) <= few:
            found |= zip(numbers.tolist(), begun, strict=True)
            break
        batch = batch.continued(remaining, begun)
    return [found[number] for number in sorted(found)], launched


def relax_batch_partly(batch: CellBatch, iterations: int) -> list[YarnSet | str]:
    """Return the yarns of each cell after some iterations (``relax_partly``), or why the cell cannot continue."""
    simulation = batch.simulation()
    loop = RelaxationLoop(simulation, batch.quality.tolerance, batch.quality.largest_change, by_newton=False)
    loop.start()
    active = ~loop.failed
    with without_limit():
        while active.any():
            loop.advance(active)
            active &= ~(loop.at_rest | loop.failed) & (loop.iterations < iterations)
    return [loop.errors.get(cell, yarns) for cell, yarns in enumerate(simulation.good_cells())]


class _Run:
    """Cells on their way to rest, until only a small part of them is left."""

    def __init__(self, simulation: YarnSimulation, batch: CellBatch) -> None:
        """Assess the given cells."""
        self.simulation = simulation
        self.batch = batch
        quality = batch.quality
        self.loop = RelaxationLoop(simulation, quality.tolerance, quality.largest_change, most=batch.most)
        self.loop.start()
        begun = batch.begun or [None] * len(batch.given)
        goes_on = np.array([own is not None for own in begun])
        put_into(self.loop, goes_on, [own.carried for own in begun if own is not None])
        self.began = time.perf_counter()
        self.before = np.array([0.0 if own is None else own.seconds for own in begun])
        """Time that each cell has spent in other batches [s], shape (C,)."""
        self.history = CellHistories([None if own is None else own.history for own in begun])
        self._note(~self.loop.failed & ~goes_on)
        self.active = ~self.loop.failed & (self.loop.iterations < batch.most)
        self._small = SMALL_PART["cuda" if simulation.model.device.is_cuda else "cpu"]

    def begun(self, cells: NDArray[np.bool_]) -> list[BegunCell]:
        """Return some cells, shape (C,), to continue in another batch."""
        seconds = (self.before + (time.perf_counter() - self.began))[cells].tolist()
        each = zip(taken_out(self.loop, cells), self.history.of(cells), seconds, strict=True)
        return [BegunCell(carried, history, spent) for carried, history, spent in each]

    def advance(self) -> None:
        """Iterate and assess cells that are not at rest."""
        loop = self.loop
        before = loop.iterations.copy()
        with suppress(OverloadError):  # of the only cell, whose error the loop keeps
            loop.advance(self.active)
        self._note((loop.iterations > before) & ~loop.failed)  # others stand still
        self.active = self.active & ~(loop.at_rest | loop.failed | loop.stalled) & (loop.iterations < self.batch.most)

    def _note(self, cells: NDArray[np.bool_]) -> None:
        """Add the last assessments of some cells to their histories."""
        seconds = self.before + (time.perf_counter() - self.began)
        self.history.note(cells, self.loop.iterations, seconds, self.loop.last)

    @property
    def is_mostly_done(self) -> bool:
        """Whether the cells that are left are so few that they are faster without the others."""
        samples = np.diff(self.simulation.model.sample_start[self.simulation.model.segment_start])
        return bool(samples[self.active].sum() < self._small * samples.sum())

    def relaxed(self, cells: NDArray[np.bool_]) -> dict[int, RelaxedCell]:
        """Return some of the cells, shape (C,), with their reports, by their numbers."""
        if not cells.any():
            return {}
        loop, last, solver = self.loop, self.loop.last, self.simulation.solver
        assert isinstance(solver, LBFGS)
        tenth, gradient = solver.gradients()
        at_rest = loop.at_rest
        hidden = hidden_by_rounding(last, at_rest, loop.stalled, loop.tolerance)
        distance = self.simulation.smallest_distances(cells)
        strain = self._largest_strains()
        found = dict[int, RelaxedCell]()
        numbers: list[int] = np.flatnonzero(cells).tolist()
        for cell, yarns, history in zip(
            numbers, self.simulation.good_cells(cells), self.history.of(cells), strict=True
        ):  # fmt: skip
            own, left = last[cell], loop.remaining[cell]
            found[cell] = RelaxedCell(yarns, {
                "iterations": int(loop.iterations[cell]),
                "tenth_iterations": tenth[cell],
                "gradient": gradient[cell],
                "converged": bool(at_rest[cell]),
                "residual": own.residual,
                "hidden_by_rounding": bool(hidden[cell]),
                "remaining_change": None if left is None else asdict(left),
                "energy": own.energy,
                "energies": own.energies,
                "max_strain": float(strain[cell]),
                "min_distance_over_radius": float(distance[cell]),
                "error": loop.errors.get(cell),
            }, history.entries())  # fmt: skip
        return found

    def _largest_strains(self) -> NDArray[np.float64]:
        """Return the largest strain of the segments of each cell in its last accepted state, shape (C,)."""
        model = self.simulation.model
        points = model.from_device(self.simulation.good_points)
        assert self.simulation.good_periods is not None
        periods = self.simulation.good_periods.numpy().astype(np.float64).reshape(-1, 2, 3)
        segment, slot, image = model.wrapped
        cell = np.searchsorted(model.segment_start, segment, side="right") - 1
        shift = np.zeros((model.segment_count, 4, 3))
        shift[segment, slot] = np.einsum("ea,ead->ed", image, (periods * model.units[:, None, None])[cell])
        length = segment_lengths(points, model.yarns.segment_points, shift)
        strain = np.abs(length / model.yarns.rest_length - 1.0)
        return np.maximum.reduceat(strain, model.segment_start[:-1])
