# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation of yarns, to a state of rest or for some iterations only: the order of operations."""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence

from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.shared_work import shared
from stitchmesh.errors import check_kind
from stitchmesh.linking.certificate import doubled_linking, refuse_changed_linking
from stitchmesh.mesh import StitchMesh
from stitchmesh.quality import DEFAULT_QUALITY, Quality
from stitchmesh.run import SHOWN, Run
from stitchmesh.run_control import RunStopped
from stitchmesh.time_limit import OutOfTime, done_twice, without_limit
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.checkpoint import read_state
from stitchmesh.yarnrelax.energies.term import Choice, YarnChoice
from stitchmesh.yarnrelax.load_position import AT_ONCE
from stitchmesh.yarnrelax.loading import Loading, LoadPath
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.observer import Observer
from stitchmesh.yarnrelax.relaxation_inputs import checked_inputs
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.relaxation_result import Relaxation, relaxation_report, unrest_text
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell

logger = logging.getLogger(__name__)


@shared
@alone()
def relax_yarns(
    yarns: YarnSet,
    *,
    material: YarnMaterial | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None,
    keep_shape: StitchMesh | None = None,
    terms: Sequence[Choice] = (),
    cell: RelaxCell | None = None,
    run: Run[YarnSet] = SHOWN,
) -> Relaxation:
    """Relax yarns to a state of rest; no yarn passes through another.

    The yarns are at rest when the residual is below ``Quality.tolerance`` and the remaining change of the spacing, if
    it is known, is below ``Quality.largest_change`` (``yarnrelax.convergence``). If a relaxation ends earlier, at
    ``Quality.max_iterations`` or at a limit on the time, it logs a warning and its report is not converged. A
    relaxation that was resumed, or that a limit on the time ended, has the bits of one that never stopped.

    Args:
        yarns: the yarns, on a lattice or not; no two of them overlap by more than half their thickness.
        material: stiffnesses; None for the material ``stitchmesh``, scaled to the radius of the yarns.
        quality: a preset or a ``Quality``.
        device: "cpu", "cuda:0" ...; None for the first GPU, or the CPU if there is no GPU.
        keep_shape: the fabric from which the yarns were generated; its borders and its shape stay as they are in
            ``yarns``.
        terms: further energies, such as ``Gravity``, and constraints, such as ``Pins``.
        cell: the changes that the periods of the lattice are free to make; None keeps the periods. It excludes
            constraints, and terms that do not act on a cell that deforms.
        run: where to start, progress, states, checkpoints and control. A step of the control is an assessment interval
            of 20 iterations, or near rest a Newton step.

    Raises:
        FileError: a checkpoint cannot be written, or the checkpoint to resume is missing or damaged.
        ParameterError: the device or quality is unknown; a fabric, a start, a term or a constraint does not fit the
            yarns; or the checkpoint belongs to another relaxation.
        SolverError: the relaxation cannot continue, or a yarn passed through another; the message names yarn and face.
    """
    check_kind("relax_yarns", yarns, YarnSet)
    began = time.perf_counter()
    inputs = checked_inputs(yarns, material, quality, device, keep_shape, terms, cell, run.start)
    keeps = run.checkpoints is not None or run.resume is not None
    written = inputs.fingerprint() if keeps else {}
    saved = None if run.resume is None else read_state(run.resume, written)
    loading = Loading(LoadPath(inputs), AT_ONCE if saved is None else saved.position, in_steps=run.load_steps)
    with done_twice():
        linking = doubled_linking(yarns, device=device)
    out_of_time = False
    goal, most_iterations = inputs.quality.resting_residual, inputs.quality.max_iterations
    with run.assessments_shown("yarnrelax", goal, most_iterations) as report_assessment:
        observer = Observer(loading, run, report_assessment, written, began)
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


@shared
@alone()
def relax_partly(
    yarns: YarnSet, *, material: YarnMaterial, quality: Quality, iterations: int, device: str | None = None,
    cell: RelaxCell | None = None, terms: Sequence[YarnChoice] = (),
) -> YarnSet:  # fmt: skip
    """Relax yarns for some iterations only, for changes in small steps; the arguments are as in ``relax_yarns``.

    The solver does all iterations; Newton's method does not end this relaxation.

    Raises:
        SolverError: the relaxation cannot continue.
    """
    simulation = YarnSimulation.start(yarns, material, quality, device_named(device), terms, cell=cell)
    with without_limit():  # the next change of size needs all of these iterations
        RelaxationLoop(simulation, quality.tolerance, quality.largest_change, by_newton=False).run(iterations)
    return simulation.good_yarns()
