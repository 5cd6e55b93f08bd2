# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Many cells relaxed together: the launches of one serve all, and each comes to rest by itself.

Cells know nothing of one another: each has its lattice, its material, its memory and its own steps, and is left alone
once it is at rest. What one cannot do, such as part yarns that start too close, ends that cell alone.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.compute.device import alone, device_named
from stitchmesh.errors import ParameterError
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarn import YarnSet, segment_lengths
from stitchmesh.yarnrelax.model.material import REFERENCE_RADIUS, YarnMaterial
from stitchmesh.yarnrelax.relaxation_loop import ASSESSMENT_INTERVAL, RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell
from stitchmesh.yarnrelax.solvers.lbfgs import LBFGS

FEW = 0.25
"""Part of all contact samples below which the cells that are not at rest go on by themselves."""


@dataclass(frozen=True, eq=False)
class RelaxedCell:
    """One of the cells."""

    yarns: YarnSet
    """Its yarns at rest, or in their last good state."""
    report: dict[str, Any]
    """iterations, tenth_iterations (those to a tenth of the first gradient, None where there was more throughout),
    gradient (the last over the first), converged, residual, energy [erg], energies [erg], max_strain,
    min_distance_over_radius, and error, None or why it could not go on."""


@dataclass(frozen=True, eq=False)
class RelaxedCells:
    """Cells that were relaxed together."""

    cells: list[RelaxedCell]
    """They, in the order in which they were given."""
    report: dict[str, Any]
    """seconds, launched (iterations of the longest), converged (how many cells), device."""


@alone()
def relax_cells(
    cells: Sequence[YarnSet],
    *,
    materials: Sequence[YarnMaterial] | None = None,
    free: Sequence[RelaxCell] | None = None,
    quality: str | Quality = "standard",
    device: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> RelaxedCells:
    """Relax many cells in the launches of one.

    Args:
        cells: yarns on a lattice each.
        materials: of each cell; the material ``stitchmesh`` scaled to its radius where not given.
        free: what the periods of each cell are free to do; they are kept where not given.
        quality: of all.
        device: "cpu", "cuda:0" ...; the first GPU, else the CPU, where not given.
        progress: called with the cells at rest and the iterations so far.

    Raises:
        ParameterError: there is no cell, one repeats on no lattice, there is not one material or one choice for
            each, or the solver is not the quasistatic one.
    """
    began = time.perf_counter()
    quality = quality_named(quality)
    _check(cells, materials, free, quality)
    if materials is None:
        named = YarnMaterial.named("stitchmesh")
        materials = [named.scaled(float(yarns.radius.mean()) / REFERENCE_RADIUS) for yarns in cells]
    simulation = YarnSimulation.start_cells(
        list(zip(cells, materials, strict=True)), quality, device_named(device), cells=free
    )
    found: dict[int, RelaxedCell] = {}
    numbers, launched = np.arange(len(cells)), 0
    while len(numbers):
        run = _Run(simulation, quality, launched)
        while run.active.any() and run.launched < quality.max_iterations and not run.is_mostly_done:
            run.advance()
            if progress is not None:
                progress(len(found) + int((~run.active).sum()), run.launched)
        launched = run.launched
        go_on = run.active if launched < quality.max_iterations else np.zeros(len(numbers), dtype=bool)
        yarns = simulation.good_cells()
        found |= {int(numbers[k]): cell for k, cell in run.relaxed(yarns, np.flatnonzero(~go_on)).items()}
        numbers = numbers[go_on]
        if len(numbers):
            rest = [(yarns[k], materials[numbers[n]]) for n, k in enumerate(np.flatnonzero(go_on).tolist())]
            own = None if free is None else [free[number] for number in numbers.tolist()]
            before, simulation = (
                simulation,
                YarnSimulation.start_cells(rest, quality, simulation.model.device, cells=own),
            )
            assert isinstance(simulation.solver, LBFGS) and isinstance(before.solver, LBFGS)
            simulation.solver.go_on_from(before.solver, go_on)
    report = {"seconds": time.perf_counter() - began, "launched": launched,
              "converged": sum(cell.report["converged"] for cell in found.values()),
              "device": str(simulation.model.device)}  # fmt: skip
    return RelaxedCells([found[number] for number in range(len(cells))], report)


def _check(
    cells: Sequence[YarnSet], materials: Sequence[Any] | None, free: Sequence[Any] | None, quality: Quality
) -> None:
    if not cells:
        raise ParameterError("cells: got none; expected at least one")
    for name, each in (("materials", materials), ("free", free)):
        if each is not None and len(each) != len(cells):
            raise ParameterError(f"{name}: got {len(each)} for {len(cells)} cells; expected one for each")
    for number, yarns in enumerate(cells):
        if yarns.lattice is None:
            raise ParameterError(f"cell {number}: repeats on no lattice; give it one, or relax it by itself")
    if quality.solver != "quasistatic":
        raise ParameterError(f"cells: got the solver {quality.solver!r}; only the quasistatic one relaxes several")


class _Run:
    """Cells on their way to rest."""

    def __init__(self, simulation: YarnSimulation, quality: Quality, launched: int) -> None:
        """Assess the cells as they were given; ``launched`` counts the iterations that they have done before."""
        self.simulation, self.launched = simulation, launched
        self.descent = RelaxationLoop.start(simulation, quality.tolerance)
        self.iterations = np.full(simulation.model.cell_count, launched)
        self.active = ~self.descent.failed

    def advance(self) -> None:
        """Iterate the cells that are not at rest, and judge them."""
        self.descent.advance(self.active)
        self.launched += ASSESSMENT_INTERVAL
        self.iterations[self.active] += ASSESSMENT_INTERVAL
        self.active &= ~self.descent.at_rest & ~self.descent.failed

    @property
    def is_mostly_done(self) -> bool:
        """Whether those that go on are so few that they are better off without the others."""
        samples = np.diff(self.simulation.model.sample_start[self.simulation.model.segment_start])
        return bool(samples[self.active].sum() < FEW * samples.sum())

    def relaxed(self, yarns: Sequence[YarnSet], cells: NDArray[np.int64]) -> dict[int, RelaxedCell]:
        """Some of the cells, whose yarns are given, and their reports."""
        solver = self.simulation.solver
        assert isinstance(solver, LBFGS)
        tenth, gradient = solver.gradients()
        last, at_rest = self.descent.last, self.descent.at_rest
        distance, strain = self.simulation.smallest_distances(), self._largest_strains()
        return {
            cell: RelaxedCell(yarns[cell], {
                "iterations": int(self.iterations[cell]),
                "tenth_iterations": tenth[cell],
                "gradient": gradient[cell],
                "converged": bool(at_rest[cell]),
                "residual": last[cell].residual,
                "energy": last[cell].energy,
                "energies": last[cell].energies,
                "max_strain": float(strain[cell]),
                "min_distance_over_radius": float(distance[cell]),
                "error": self.simulation.failed.get(cell),
            })
            for cell in cells.tolist()
        }  # fmt: skip

    def _largest_strains(self) -> NDArray[np.float64]:
        """Largest strain of each cell's segments in its last good state, of all cells at once, shape (C,)."""
        model, points = self.simulation.model, self.simulation.model.from_device(self.simulation.good_points)
        assert self.simulation.good_periods is not None
        periods = self.simulation.good_periods.numpy().astype(np.float64).reshape(-1, 2, 3) * model.units[:, None, None]
        segment, slot, image = model.wrapped
        cell = np.searchsorted(model.segment_start, segment, side="right") - 1
        shift = np.zeros((model.segment_count, 4, 3))
        shift[segment, slot] = np.einsum("ea,ead->ed", image, periods[cell])
        length = segment_lengths(points, model.yarns.segment_points, shift)
        strain = np.abs(length / model.yarns.rest_length - 1.0)
        return np.maximum.reduceat(strain, model.segment_start[:-1])
