# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation of yarns to a state of rest: the order of operations."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from stitchmesh.compute.device import alone, device_named
from stitchmesh.errors import FileError, ParameterError, check_kind
from stitchmesh.io.contents import FilePath
from stitchmesh.io.history import HistoryEntry
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.progress import shown_progress
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.run_control import RunControl, RunStopped
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.checkpoint import Checkpoints, input_fingerprint, read_state
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.convergence import LARGEST_ENERGY_FALL, rest_text
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.energies.term import ConstraintChoice, TermChoice, refuse_in_free_cells
from stitchmesh.yarnrelax.linking.certificate import changed_pairs, doubled_linking, refuse_changed_linking
from stitchmesh.yarnrelax.model.material import REFERENCE_RADIUS, YarnMaterial
from stitchmesh.yarnrelax.observer import Observer, Progress, report_entries
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Relaxation:
    """Relaxed yarns, with a report and a history of the relaxation."""

    yarns: YarnSet
    """The yarns at rest."""
    report: dict[str, Any]
    """seconds, iterations, converged, stopped (by the user), residual, remaining_change (spacing, energy, both
    relative, and rms_radii: the estimated change that is left; None where unknown), energy [erg], energies [erg],
    max_strain, min_distance_over_radius (2 where no yarns touch), pull_throughs, certificate, solver, device."""
    history: list[HistoryEntry]
    """The result of each assessment."""

    def __repr__(self) -> str:
        """Return one line: whether the yarns are at rest, and the yarns."""
        return f"Relaxation({rest_text(self.report)}, {self.yarns})"


@alone()
def relax_yarns(
    yarns: YarnSet,
    *,
    start: YarnSet | None = None,
    material: YarnMaterial | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None,
    keep_shape: StitchMesh | None = None,
    terms: Sequence[TermChoice] = (),
    constraints: Sequence[ConstraintChoice] = (),
    cell: RelaxCell | None = None,
    progress: Progress | Literal[False] | None = None,
    on_state: Callable[[YarnSet], None] | None = None,
    checkpoint: Checkpoints | None = None,
    resume: FilePath | None = None,
    control: RunControl[YarnSet] | None = None,
) -> Relaxation:
    """Relax yarns to a state of rest; no yarn passes through another.

    A relaxation that stops at ``Quality.max_iterations`` logs a warning, and its report is not converged. A resumed
    relaxation ends with the same bits as one that was never stopped, and counts iterations and seconds from the start.

    Args:
        yarns: the yarns, on a lattice or not; no two of them overlap by more than half their thickness. Shape and
            borders are kept as they are in these yarns.
        start: the same yarns, linked in the same way, at other positions to start from, for example as they were
            relaxed before an edit.
        material: stiffnesses; the material ``stitchmesh`` scaled to the radius of the yarns where not given.
        quality: a preset or a ``Quality``.
        device: "cpu", "cuda:0" ...; the first GPU, else the CPU, where not given.
        keep_shape: the fabric from which the yarns were generated, whose borders and shape are to be kept.
        terms: further energies, such as gravity; a term that is not given costs nothing.
        constraints: constraints on control points.
        cell: which changes the periods of the lattice are free to make; they are kept where not given. It excludes
            constraints, and terms that do not act on a cell that deforms (``TermChoice.in_free_cells``).
        progress: called about every half second; by default a line shows the progress on a terminal or in a notebook,
            and False shows nothing.
        on_state: called every few seconds, and when the relaxation ends early, with the last accepted state.
        checkpoint: where and how often to write what is needed to resume; also written at the start and at any end.
        resume: a checkpoint to continue from; all other arguments must be the same as when it was written.
        control: watches, pauses, steps and stops the relaxation from another thread. A step is an assessment interval
            of 20 iterations. A pause writes a checkpoint. A stopped relaxation returns its last accepted state.

    Raises:
        FileError: a checkpoint cannot be written, or the one to resume is missing or damaged.
        ParameterError: an unknown device or quality, or a fabric, a start, a term or a constraint that does not fit the
            yarns, or a checkpoint of another relaxation.
        SolverError: the relaxation cannot go on, or a yarn passed through another; it names yarn and stitch face.
    """
    check_kind("relax_yarns", yarns, YarnSet)
    began = time.perf_counter()
    quality = quality_named(quality)
    if material is None:
        material = YarnMaterial.named().scaled(float(yarns.radius.mean()) / REFERENCE_RADIUS)
    check_kind("relax_yarns, material", material, YarnMaterial)
    if keep_shape is not None:
        check_kind("relax_yarns, keep_shape", keep_shape, StitchMesh)
        terms, constraints = [*terms, KeepShape(keep_shape)], [*constraints, KeepBorders(keep_shape)]
    points = None if start is None else _points_of(start, yarns)
    if cell is not None:
        refuse_in_free_cells(terms, constraints)
    simulation = YarnSimulation.start(yarns, material, quality, device_named(device), terms, constraints, points, cell)
    linking = doubled_linking(yarns, device=device)
    inputs: dict[str, str] = {}
    if checkpoint is not None or resume is not None:
        kind = simulation.model.device
        inputs = input_fingerprint(yarns, material, quality, kind, terms, constraints, cell, simulation.arrays())
    loop = RelaxationLoop(simulation, quality.tolerance, quality.largest_change)
    with shown_progress(progress, lambda shown: report_entries(quality, shown)) as report_entry:
        observer = Observer(loop, report_entry, on_state, checkpoint, inputs, began, control)
        if resume is not None:
            observer.resume(read_state(resume, inputs))
        try:
            _run_to_rest(loop, quality, observer.note)
        except RunStopped:
            logger.info("stopped after %d iterations", loop.iteration)
        except FileError:  # Checkpoints cannot be written.
            raise
        except BaseException:
            observer.hand_over()
            raise
        observer.write_checkpoint()
    stopped = bool(control is not None and control.stopped and not loop.at_rest[0])
    if not (loop.at_rest[0] or stopped):
        _warn(loop)
    relaxed = simulation.good_yarns()
    refuse_changed_linking(yarns, changed_pairs(linking, doubled_linking(relaxed, device=device)))
    return Relaxation(relaxed, _report(loop, quality, relaxed, observer.seconds(), stopped), observer.history)


def _run_to_rest(loop: RelaxationLoop, quality: Quality, note: Callable[[], None]) -> None:
    """Iterate until the yarns are at rest, and stay at rest after the lagged quantities of terms were renewed."""
    loop.run(quality.max_iterations, note)
    while loop.at_rest[0] and loop.renew_terms() and loop.last[0].residual >= quality.tolerance:
        loop.run(quality.max_iterations, note)


def _points_of(start: YarnSet, yarns: YarnSet) -> FloatArray:
    """Control points to start from [cm]."""
    if not (np.array_equal(start.start, yarns.start) and np.array_equal(start.closed, yarns.closed)):
        found = f"{start.yarn_count} yarns of {len(start.points)} control points"
        expected = f"{yarns.yarn_count} of {len(yarns.points)}, closed where they are"
        raise ParameterError(f"start: got {found}; expected the same yarns, {expected}")
    return start.points


def _report(loop: RelaxationLoop, quality: Quality, relaxed: YarnSet, seconds: float, stopped: bool) -> dict[str, Any]:
    left = loop.remaining[0]
    return {
        "seconds": seconds,
        "iterations": loop.iteration,
        "converged": bool(loop.at_rest[0]),
        "stopped": stopped,
        "residual": loop.last[0].residual,
        "remaining_change": None if left is None else asdict(left),
        "energy": loop.last[0].energy,
        "energies": loop.last[0].energies,
        "max_strain": float(np.abs(relaxed.strain).max()),
        "min_distance_over_radius": float(loop.simulation.smallest_distances()[0]),
        "pull_throughs": 0,
        "certificate": "unchanged",
        "solver": quality.solver,
        "device": str(loop.simulation.model.device),
    }


def _warn(loop: RelaxationLoop) -> None:
    """Log that the iterations were not sufficient, and what would help."""
    last, fall = loop.last[0], float(loop.energy_fall[0])
    found = f"residual {last.residual:.2g} (expected {loop.tolerance:g})"
    falling = f"falling by {fall:.2g} of itself" if np.isfinite(fall) else "not level"
    slope = f"energy {falling} (expected {LARGEST_ENERGY_FALL * loop.tolerance:g})"
    where = f"{found}, {slope} after {loop.iteration} iterations"
    logger.warning("yarns are not at rest: %s; %s", where, last.remedy)
