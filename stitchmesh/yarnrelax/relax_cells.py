# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Many cells relaxed together: each launch serves all cells, and each cell comes to rest by itself.

Cells are independent: each has its own lattice, material, solver memory and steps, and stays still once it is at rest.
A problem of one cell, such as yarns that start too close to each other, ends that cell only.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.device import alone, device_named
from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.progress import Progress, shown_progress
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.time_limit import OutOfTime
from stitchmesh.yarn import YarnSet, segment_lengths
from stitchmesh.yarnrelax.convergence import rest_text
from stitchmesh.yarnrelax.energies.confinement import CellConfinements, Confinement, height_of_middle
from stitchmesh.yarnrelax.model.cells import PeriodicCell
from stitchmesh.yarnrelax.model.material import REFERENCE_RADIUS, YarnMaterial
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell
from stitchmesh.yarnrelax.solvers.lbfgs import LBFGS

CellProgress = Callable[[int, int], None]
"""Called with the number of cells at rest and the number of iterations."""
SMALL_PART = 0.25
"""Part of all contact samples below which the cells that are not at rest continue without the others."""
ENOUGH, LONGEST_WAIT = 0.5, 4
"""Part of the cells that are not at rest that is enough for a Newton step, and the most assessment intervals for which
cells wait until there are so many."""


@dataclass(frozen=True, eq=False)
class RelaxedCell:
    """One of the cells."""

    yarns: YarnSet
    """The yarns at rest, or in their last accepted state."""
    report: dict[str, Any]
    """iterations, tenth_iterations (iterations to a tenth of the first gradient, None where it was never reached),
    gradient (the last gradient over the first), converged, residual, remaining_change (as in ``Relaxation.report``),
    energy [erg], energies [erg], max_strain, min_distance_over_radius, and error, None or why the cell could not go
    on."""

    def __repr__(self) -> str:
        """Return one line: whether the yarns are at rest, and the yarns."""
        return f"RelaxedCell({rest_text(self.report)}, {self.yarns})"


@dataclass(frozen=True, eq=False)
class RelaxedCells:
    """Cells that were relaxed together."""

    cells: list[RelaxedCell]
    """The cells, in the order in which they were given."""
    report: dict[str, Any]
    """seconds, launched (iterations of the cell that did most), converged (how many cells), device."""

    def __repr__(self) -> str:
        """Return one line: the number of cells, and the number of cells at rest."""
        return f"RelaxedCells({len(self.cells)} cells, {self.report['converged']} at rest)"


@alone()
def relax_cells(
    cells: Sequence[YarnSet],
    *,
    materials: Sequence[YarnMaterial] | None = None,
    free: Sequence[RelaxCell] | None = None,
    planes: Sequence[Confinement | None] | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None,
    progress: CellProgress | Literal[False] | None = None,
) -> RelaxedCells:
    """Relax many periodic cells at once, in launches that all cells share; no yarn passes through another.

    On a GPU a launch costs more than the work of a small cell, so hundreds of swatches take little longer than one.
    Each cell ends with the state that ``relax_yarns`` would find within the tolerance. A cell that fails does not
    raise: the reason is in its report, and its yarns are those of its last accepted state.

    Args:
        cells: yarns [cm], each on a lattice of its own; no two yarns overlap by more than half their thickness.
        materials: stiffnesses of each cell, C of them; the material ``stitchmesh`` scaled to the mean yarn radius of
            each cell where not given.
        free: which changes the periods of each cell are free to make, and which loads act on them [dyn], C of them;
            the periods are kept where not given.
        planes: two planes between which each cell lies, or None for a cell without them, C of them; no planes where
            not given. A swatch whose size relaxes lies between planes by default; how far apart they are follows from
            its stitches, which yarns alone do not show, so that the caller gives them here
            (``stitchmesh.periodic.relaxation.support.planes``).
        quality: a preset or a ``Quality`` for all cells; its solver must be the quasistatic one.
        device: "cpu", "cuda:0" ...; the first GPU, else the CPU, where not given.
        progress: called after each assessment with the number of cells at rest and the number of iterations; by default
            a line shows the progress on a terminal or in a notebook, and False shows nothing.

    Returns:
        The relaxed cells in the same order, each with a report, and a report of all.

    Raises:
        ParameterError: there is no cell, a cell has no lattice, there is not one material, one choice or one pair of
            planes for each cell, the device or the quality is unknown, or the solver is not the quasistatic one.
        SolverError: the candidate lists of all cells together do not fit the memory.
    """
    began = time.perf_counter()
    quality = quality_named(quality)
    _check(cells, {"materials": materials, "free": free, "planes": planes}, quality)
    if materials is None:
        named = YarnMaterial.named()
        materials = [named.scaled(float(yarns.radius.mean()) / REFERENCE_RADIUS) for yarns in cells]
    batch = _Batch(list(zip(cells, materials, strict=True)), free, planes, quality, device_named(device))
    with shown_progress(progress, partial(_report_cells, len(cells))) as report_cells:
        found, launched = _relax_all(batch, report_cells)
    report = {"seconds": time.perf_counter() - began, "launched": launched,
              "converged": sum(cell.report["converged"] for cell in found.values()),
              "device": str(device_named(device))}  # fmt: skip
    return RelaxedCells([found[number] for number in range(len(cells))], report)


@dataclass(frozen=True, eq=False)
class _Batch:
    """Cells that are relaxed together, with what was chosen for each."""

    given: Sequence[tuple[YarnSet, YarnMaterial]]
    free: Sequence[RelaxCell] | None
    planes: Sequence[Confinement | None] | None
    quality: Quality
    device: wp.Device
    heights: Sequence[float | None] | None = None
    """Heights of the middle planes [cm]; None for those of the yarns as given."""

    def simulation(self) -> YarnSimulation:
        """The cells on the device."""
        terms = []
        if self.planes is not None:
            terms = [CellConfinements(tuple(self.planes), tuple(self.heights or [None] * len(self.given)))]
        return YarnSimulation(self.given, self.quality, self.device, terms, cells=self.free)

    def part(self, cells: NDArray[np.bool_], yarns: Sequence[YarnSet]) -> _Batch:
        """Some of the cells, with their yarns in their present state; ``yarns`` are those of all cells."""
        given = [(now, material) for now, (_, material) in zip(yarns, self.given, strict=True)]
        heights = self.heights or [height_of_middle(PeriodicCell(*each)) for each in self.given]
        return replace(self, given=_some(given, cells), free=_some(self.free, cells),
                       planes=_some(self.planes, cells), heights=_some(heights, cells))  # fmt: skip


def _some(each: Sequence[Any] | None, cells: NDArray[np.bool_]) -> Any:
    """What belongs to some of the cells; None where nothing was chosen."""
    return None if each is None else [own for own, chosen in zip(each, cells.tolist(), strict=True) if chosen]


def _relax_all(batch: _Batch, progress: CellProgress | None) -> tuple[dict[int, RelaxedCell], int]:
    """Relax all cells of a batch; return the cells by number, and the iterations of the cell that did most."""
    found: dict[int, RelaxedCell] = {}
    numbers, launched = np.arange(len(batch.given)), 0
    before: tuple[_Run, NDArray[np.bool_]] | None = None
    while len(numbers):
        run = _Run(batch.simulation(), batch.quality, before)
        while run.active.any() and not run.is_mostly_done:
            try:
                run.advance()
            except OutOfTime:
                run.active[:] = False  # all cells end with their last accepted states
            if progress is not None:
                progress(len(found) + int((~run.active).sum()), run.loop.iteration)
        launched, remaining = max(launched, run.loop.iteration), run.active
        yarns = run.simulation.good_cells()
        found |= {int(numbers[k]): cell for k, cell in run.relaxed(yarns, np.flatnonzero(~remaining)).items()}
        numbers, batch, before = numbers[remaining], batch.part(remaining, yarns), (run, remaining)
    return found, launched


def _report_cells(count: int, progress: Progress) -> CellProgress:
    """Return a function that reports the number of cells at rest, of ``count`` cells, as the progress of a stage."""
    return lambda rest, done: progress("yarnrelax", rest / count, f"{rest} of {count} cells, iteration {done}")


def _check(cells: Sequence[YarnSet], choices: Mapping[str, Sequence[Any] | None], quality: Quality) -> None:
    if not cells:
        raise ParameterError("cells: got none; expected at least one")
    for name, each in choices.items():
        if each is not None and len(each) != len(cells):
            raise ParameterError(f"{name}: got {len(each)} for {len(cells)} cells; expected one for each")
    for number, yarns in enumerate(cells):
        check_kind(f"relax_cells, cell {number}", yarns, YarnSet)
        if yarns.lattice is None:
            raise ParameterError(f"cell {number}: repeats on no lattice; give it one, or relax it by itself")
    if quality.solver != "quasistatic":
        raise ParameterError(f"cells: got the solver {quality.solver!r}; only quasistatic relaxes several cells")


class _Run:
    """Cells on their way to rest, until only a small part of them is not at rest."""

    def __init__(
        self, simulation: YarnSimulation, quality: Quality, before: tuple[_Run, NDArray[np.bool_]] | None = None
    ) -> None:
        """Assess the cells as they were given; ``before`` is a run of more cells, and which of them these are."""
        self.simulation, self.quality = simulation, quality
        self.loop = RelaxationLoop(simulation, quality.tolerance, quality.largest_change)
        self.loop.start()
        if before is not None:
            self._continue_from(*before)
        self.active = ~self.loop.failed
        self._intervals = 0
        """Intervals for which cells have waited to take a Newton step together."""

    def _continue_from(self, before: _Run, cells: NDArray[np.bool_]) -> None:
        """Count the iterations of the cells on, and end the relaxation of those that Newton's method was ending."""
        own, earlier = self.simulation, before.simulation
        assert isinstance(own.solver, LBFGS) and isinstance(earlier.solver, LBFGS)
        own.solver.continue_gradients(earlier.solver, cells)
        assert own.newton is not None and earlier.newton is not None
        own.newton.continue_from(earlier.newton, cells)
        self.loop.iterations, self.loop.ending = before.loop.iterations[cells], before.loop.ending[cells]
        self.loop.alternation.continue_from(before.loop.alternation, cells)

    def advance(self) -> None:
        """Iterate and assess cells that are not at rest; those that take a Newton step next may wait for others.

        A Newton step of all cells takes hardly longer than that of one cell, and cells take it at different times.
        """
        loop = self.loop
        stepping = self.active & loop.takes_newton_step
        few = stepping.sum() < ENOUGH * self.active.sum() and self._intervals < LONGEST_WAIT
        self._intervals = self._intervals + 1 if few and stepping.any() else 0
        loop.advance(self.active & ~stepping if few else self.active)
        self.active &= ~(loop.at_rest | loop.failed | loop.stalled) & (loop.iterations < self.quality.max_iterations)

    @property
    def is_mostly_done(self) -> bool:
        """Whether the remaining cells are so small a part that they are faster without the others."""
        samples = np.diff(self.simulation.model.sample_start[self.simulation.model.segment_start])
        return bool(samples[self.active].sum() < SMALL_PART * samples.sum())

    def relaxed(self, yarns: Sequence[YarnSet], cells: NDArray[np.int64]) -> dict[int, RelaxedCell]:
        """Some of the cells with their reports; ``yarns`` are those of all cells."""
        solver = self.simulation.solver
        assert isinstance(solver, LBFGS)
        tenth, gradient = solver.gradients()
        last, at_rest, left = self.loop.last, self.loop.at_rest, self.loop.remaining
        distance, strain = self.simulation.smallest_distances(), self._largest_strains()
        return {
            cell: RelaxedCell(yarns[cell], {
                "iterations": int(self.loop.iterations[cell]),
                "tenth_iterations": tenth[cell],
                "gradient": gradient[cell],
                "converged": bool(at_rest[cell]),
                "residual": last[cell].residual,
                "remaining_change": None if left[cell] is None else asdict(left[cell]),
                "energy": last[cell].energy,
                "energies": last[cell].energies,
                "max_strain": float(strain[cell]),
                "min_distance_over_radius": float(distance[cell]),
                "error": self.loop.errors.get(cell),
            })
            for cell in cells.tolist()
        }  # fmt: skip

    def _largest_strains(self) -> NDArray[np.float64]:
        """Largest strain of the segments of each cell in its last accepted state, shape (C,)."""
        model, points = self.simulation.model, self.simulation.model.from_device(self.simulation.good_points)
        assert self.simulation.good_periods is not None
        periods = self.simulation.good_periods.numpy().astype(np.float64).reshape(-1, 2, 3)
        segment, slot, image = model.wrapped
        cell = np.searchsorted(model.segment_start, segment, side="right") - 1
        shift = np.zeros((model.segment_count, 4, 3))
        shift[segment, slot] = np.einsum("ea,ead->ed", image, (periods * model.units[:, None, None])[cell])
        length = segment_lengths(points, model.yarns.segment_points, shift)
        strain = np.abs(length / model.yarns.rest_length - 1.0)
        return np.maximum.reduceat(strain, model.segment_start[:-1])
