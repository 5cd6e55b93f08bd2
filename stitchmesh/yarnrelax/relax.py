# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation of yarns to a state of rest: the order of operations."""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence

import numpy as np

from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.shared_work import shared
from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.memory_need import check_relaxation_memory
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.run import SHOWN, Run
from stitchmesh.run_control import RunStopped
from stitchmesh.time_limit import OutOfTime, done_twice
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.checkpoint import input_fingerprint, read_state
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.energies.term import ConstraintChoice, TermChoice, refuse_in_free_cells
from stitchmesh.yarnrelax.linking.certificate import doubled_linking, refuse_changed_linking
from stitchmesh.yarnrelax.load_path import LoadPath, StepInputs
from stitchmesh.yarnrelax.load_position import AT_ONCE
from stitchmesh.yarnrelax.loading import Loading
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.observer import Observer
from stitchmesh.yarnrelax.relaxation_result import Relaxation, relaxation_report, unrest_text
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell

logger = logging.getLogger(__name__)


@shared
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
    load_steps: bool = True,
    run: Run[YarnSet] = SHOWN,
) -> Relaxation:
    """Relax yarns to a state of rest; no yarn passes through another.

    The yarns are at rest when the residual is below ``Quality.tolerance`` and the change of the spacing that is left is
    estimated below ``Quality.largest_change``; with ``Dynamics``, and with friction off a lattice, that change is not
    known, and the energy must have stopped falling instead (``yarnrelax.convergence``). A relaxation that stops at
    ``Quality.max_iterations``, or where no step lowers the energy any more, logs a warning, and its report is not
    converged. One that a limit on the time ends (``time_limit``) has the bits of one with ``max_iterations`` as many as
    its report counts. A resumed one has those of one that never stopped, and counts iterations and seconds of both.

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
        load_steps: whether rest lengths, stiffnesses, the radius or loads that press yarns through one another at once
            are applied in steps (``load_path``); the report then says how. Terms begin anew in each step.
        run: progress, states, checkpoints and control. A step of its control is an assessment interval of 20
            iterations, or near rest a Newton step, which counts as 15 (50 on a GPU).

    Raises:
        FileError: a checkpoint cannot be written, or the one to resume is missing or damaged.
        ParameterError: an unknown device or quality, or a fabric, a start, a term or a constraint that does not fit the
            yarns, or a checkpoint of another relaxation.
        SolverError: the relaxation cannot go on, or a yarn passed through another; it names yarn and stitch face.
    """
    check_kind("relax_yarns", yarns, YarnSet)
    began = time.perf_counter()
    quality, kind = quality_named(quality), device_named(device)
    check_relaxation_memory(f"a relaxation of {len(yarns.points):,} control points", len(yarns.points), quality, device)
    if material is None:
        material = YarnMaterial.named().of_radius(float(yarns.radius.mean()))
    check_kind("relax_yarns, material", material, YarnMaterial)
    if keep_shape is not None:
        check_kind("relax_yarns, keep_shape", keep_shape, StitchMesh)
        terms, constraints = [*terms, KeepShape(keep_shape)], [*constraints, KeepBorders(keep_shape)]
    points = None if start is None else _start_points(start, yarns)
    if cell is not None:
        refuse_in_free_cells(terms, constraints)
    keeps = run.checkpoints is not None or run.resume is not None
    inputs = input_fingerprint(yarns, material, quality, kind, terms, constraints, cell) if keeps else {}
    saved = None if run.resume is None else read_state(run.resume, inputs)
    path = LoadPath(StepInputs(yarns, material, quality, kind, terms, constraints, points, cell))
    loading = Loading(path, AT_ONCE if saved is None else saved.position, in_steps=load_steps)
    with done_twice():
        linking = doubled_linking(yarns, device=device)
    out_of_time = False
    with run.assessments_shown("yarnrelax", quality.resting_residual, quality.max_iterations) as report_assessment:
        observer = Observer(loading, run, report_assessment, inputs, began)
        if saved is not None:
            observer.resume(saved)
        with observer.last_state_kept():
            try:
                loading.run(observer.note)
            except RunStopped as end:
                out_of_time = isinstance(end, OutOfTime) and not loading.at_rest
                logger.info("stopped after %d iterations", loading.loop.iteration)
    stopped = bool(run.control is not None and run.control.stopped and not loading.at_rest)
    if not (loading.at_rest or stopped):
        logger.warning("yarns are not at rest: %s", unrest_text(loading, out_of_time=out_of_time))
    relaxed = loading.good_yarns()
    refuse_changed_linking(yarns, relaxed, linking, device)
    report = relaxation_report(loading, relaxed, observer.seconds(), stopped=stopped, out_of_time=out_of_time)
    return Relaxation(relaxed, report, observer.history)


def _start_points(start: YarnSet, yarns: YarnSet) -> FloatArray:
    """Return control points of the same yarns to start from [cm], shape (N, 3).

    Raises:
        ParameterError: they are not those of the same yarns.
    """
    if not (np.array_equal(start.start, yarns.start) and np.array_equal(start.closed, yarns.closed)):
        found = f"{start.yarn_count} yarns of {len(start.points)} control points"
        expected = f"{yarns.yarn_count} of {len(yarns.points)}, closed where they are"
        raise ParameterError(f"start: got {found}; expected the same yarns, {expected}")
    return start.points
