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
class BegunCell:
    """A cell between two batches."""

    carried: CarriedCell
    """Everything that decides how the cell continues."""
    history: Sequence[HistoryEntry]
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
        put_into(self.loop, {number: own.carried for number, own in enumerate(begun) if own is not None})
        self.began = time.perf_counter()
        self.before = [0.0 if own is None else own.seconds for own in begun]
        """Time that each cell has spent in other batches [s]."""
        self.history: list[list[HistoryEntry]] = [[] if own is None else list(own.history) for own in begun]
        self._note(~self.loop.failed & np.array([own is None for own in begun]))
        self.active = ~self.loop.failed & (self.loop.iterations < batch.most)
        self._small = SMALL_PART["cuda" if simulation.model.device.is_cuda else "cpu"]

    def begun(self, cells: NDArray[np.bool_]) -> list[BegunCell]:
        """Return some cells, shape (C,), to continue in another batch."""
        seconds, numbers = time.perf_counter() - self.began, np.flatnonzero(cells).tolist()
        return [BegunCell(own, self.history[cell], self.before[cell] + seconds)
                for cell, own in zip(numbers, taken_out(self.loop, numbers), strict=True)]  # fmt: skip

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
        seconds = time.perf_counter() - self.began
        numbers = np.flatnonzero(cells)
        last = self.loop.last
        names = tuple(last.energies)
        columns = self.loop.iterations, last.residual, *last.energies.values()
        rows = zip(numbers.tolist(), *(column[numbers].tolist() for column in columns), strict=True)
        for cell, count, residual, *energies in rows:
            own = dict(zip(names, energies, strict=True))
            entry = HistoryEntry(iteration=count, seconds=self.before[cell] + seconds, residual=residual, energies=own)
            self.history[cell].append(entry)

    @property
    def is_mostly_done(self) -> bool:
        """Whether the cells that are left are so few that they are faster without the others."""
        samples = np.diff(self.simulation.model.sample_start[self.simulation.model.segment_start])
        return bool(samples[self.active].sum() < self._small * samples.sum())

    def relaxed(self, cells: NDArray[np.bool_]) -> dict[int, RelaxedCell]:
        """Return some of the cells, shape (C,), with their reports, by their numbers."""
        if not cells.any():
            return {}
        numbers: list[Any] = np.flatnonzero(cells).tolist()
        yarns = self.simulation.good_cells()
        solver = self.simulation.solver
        assert isinstance(solver, LBFGS)
        tenth, gradient = solver.gradients()
        last = self.loop.last
        at_rest = self.loop.at_rest
        left = self.loop.remaining
        hidden = hidden_by_rounding(last, at_rest, self.loop.stalled, self.loop.tolerance)
        distance = self.simulation.smallest_distances(cells)
        strain = self._largest_strains()
        return {
            cell: RelaxedCell(yarns[cell], {
                "iterations": int(self.loop.iterations[cell]),
                "tenth_iterations": tenth[cell],
                "gradient": gradient[cell],
                "converged": bool(at_rest[cell]),
                "residual": last[cell].residual,
                "hidden_by_rounding": bool(hidden[cell]),
                "remaining_change": None if left[cell] is None else asdict(left[cell]),
                "energy": last[cell].energy,
                "energies": last[cell].energies,
                "max_strain": float(strain[cell]),
                "min_distance_over_radius": float(distance[cell]),
                "error": self.loop.errors.get(cell),
            }, self.history[cell])
            for cell in numbers
        }  # fmt: skip

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
