# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Many cells relaxed together: each launch serves all cells, and each cell comes to rest by itself.

The cells are independent. Each has its own lattice, material, solver memory and steps, and stands still once it is at
rest. A problem of one cell, such as yarns that start too close to each other, ends that cell only.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np

from stitchmesh.compute.device import alone, device_named
from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.progress import Progress, shown_progress
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.energies.confinement import Confinement
from stitchmesh.yarnrelax.model.material import YarnMaterial, material_of
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell
from stitchmesh.yarnrelax.together.cell_batch import CellBatch, CellProgress, RelaxedCell, relax_batch


@dataclass(frozen=True, eq=False)
class RelaxedCells:
    """Cells that were relaxed together."""

    cells: list[RelaxedCell]
    """The cells in the given order."""
    report: dict[str, Any]
    """seconds, launched (iterations of the cell that did the most), converged (number of cells at rest), device."""

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
    Each cell ends with the state that ``relax_yarns`` would find, within the tolerance. A cell that fails raises no
    error: its report has the reason, and its yarns are in their last accepted state.

    Args:
        cells: yarns [cm], each on a lattice of its own; no two yarns overlap by more than half their thickness.
        materials: stiffnesses of each cell, C of them; None for the material ``stitchmesh``, scaled to the mean yarn
            radius of each cell.
        free: the changes that the periods of each cell are free to make, and the loads on them [dyn], C of them; None
            keeps the periods.
        planes: two planes between which each cell lies, or None for a cell without them, C of them; None for no planes
            at all. A swatch whose size relaxes lies between planes by default. The distance between them follows from
            its stitches, which yarns alone do not show, so the caller gives the planes here
            (``stitchmesh.periodic.relaxation.support.planes``).
        quality: a preset or a ``Quality`` for all cells; its solver must be the quasistatic one.
        device: "cpu", "cuda:0" ...; None for the first GPU, or the CPU if there is no GPU.
        progress: called after each assessment with the number of cells at rest and the number of iterations; by default
            a line shows the progress on a terminal or in a notebook, and False shows nothing.

    Returns:
        The relaxed cells in the same order, each with a report, and a report of all cells.

    Raises:
        ParameterError: there is no cell; a cell has no lattice; a list of choices has not one entry for each cell; the
            device or the quality is unknown; or the solver is not the quasistatic one.
        SolverError: the candidate lists of all cells together do not fit the memory.
    """
    began = time.perf_counter()
    quality = quality_named(quality)
    _check(cells, {"materials": materials, "free": free, "planes": planes}, quality)
    if materials is None:
        materials = [material_of(yarns) for yarns in cells]
    given, most = list(zip(cells, materials, strict=True)), np.full(len(cells), quality.max_iterations)
    batch = CellBatch(given, free, planes, quality, device_named(device), most)
    with shown_progress(progress, partial(_report_cells, len(cells))) as report_cells:
        ended, launched = relax_batch(batch, report_cells)
    found = [cell for cell in ended if isinstance(cell, RelaxedCell)]
    report = {"seconds": time.perf_counter() - began, "launched": launched,
              "converged": sum(cell.report["converged"] for cell in found),
              "device": str(device_named(device))}  # fmt: skip
    return RelaxedCells(found, report)


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
