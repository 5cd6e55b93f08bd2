# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The run of a job: the order of operations, its pictures, and the removal of stages that the last run has not used.

Pictures are kept like the results of stages.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

from stitchmesh.budget.budget import FILES, NO_TIME_FOR_PICTURE, START_OF_RENDERER, Budget
from stitchmesh.budget.plan import limit_of
from stitchmesh.errors import DisplayError, FileError, StitchMeshError, is_interrupt
from stitchmesh.io.atomic import write_bytes, write_json
from stitchmesh.io.contents import read_bytes
from stitchmesh.io.folder_lock import FolderLock
from stitchmesh.io.history import HistoryEntry, write_history
from stitchmesh.io.outputs import guarded_outputs, plan_outputs
from stitchmesh.io.part_folder import remove_stale_parts
from stitchmesh.io.yarns import write_yarns
from stitchmesh.jobs.garment_stages import make_garment
from stitchmesh.jobs.job import Job
from stitchmesh.jobs.job_status import JobLog, JobStopped, Listener, State, StopRequest, read_status
from stitchmesh.jobs.kept_stages import KeptStage, KeptStages, stage_folder, stage_key
from stitchmesh.jobs.sections import RenderTable
from stitchmesh.jobs.stage_files import PICTURE
from stitchmesh.jobs.stage_run import JobRun
from stitchmesh.jobs.swatch_stages import relax_swatch
from stitchmesh.mesh import StitchMesh
from stitchmesh.periodic.swatch import Swatch
from stitchmesh.pipeline.garment import Made
from stitchmesh.quality import quality_named
from stitchmesh.render import render
from stitchmesh.render.plots.convergence_plot import plot_convergence
from stitchmesh.run import CHECKPOINT
from stitchmesh.time_limit import limited_to
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.relaxation_result import Relaxation

REPORT, HISTORY = "report.json", "convergence.csv"
BUSY = "another run works in this folder; wait for its end (`stitchmesh status`), or choose another folder"
"""Message for a folder whose lock another program holds."""
logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class FinishedJob:
    """The results of a job."""

    yarns: YarnSet
    """The relaxed yarns."""
    fabric: StitchMesh | None
    """The stitches; None for a weave."""
    report: dict[str, Any]
    """Figures of all stages, as in ``report.json``."""
    drawn: bool
    """Whether pictures were drawn."""

    def __repr__(self) -> str:
        """Return one line: the stages that were computed, and the yarns."""
        computed = sum(not stage["kept"] for stage in self.report["job"]["stages"])
        return f"FinishedJob({computed} of {len(self.report['job']['stages'])} stages computed, {self.yarns})"


def run_job(
    job: Job, folder: str | PathLike[str], *, resume: bool = False, stop: StopRequest | None = None,
    listener: Listener = lambda _: None, began: float | None = None, load: float = 1.0, overwrite: bool = False,
) -> FinishedJob:  # fmt: skip
    """Run a job in its folder; stages that an earlier run has finished are not computed again.

    The function writes the files of the job, ``report.json``, ``convergence.csv`` and ``convergence.png``, and keeps
    ``status.json`` up to date while it runs. Finished stages are kept in ``stages`` (``kept_stages``).

    Args:
        job: the job (``read_job``).
        folder: folder of the job, which only one run may use at a time; it is made if it is missing.
        resume: whether a relaxation of yarns continues from its checkpoint; the result has the bits of a run that was
            never stopped.
        stop: the request to stop, which a signal handler or another thread may make.
        listener: called with each report of the progress.
        began: reading of ``time.perf_counter`` from which the time of the budget counts [s]; by default the present
            reading.
        load: factor by which the machine is slower at present than without other work; the budget multiplies the time
            that it keeps for files and pictures by it.
        overwrite: whether the job may replace files in the folder that StitchMesh did not write, or that were changed
            later; a file that the job reads is never replaced.

    Raises:
        FileError: another run works in the folder, or a file cannot be read or written, or may not be replaced.
        ParameterError: an option is not possible, the job does not fit into the memory, its time is over, or there is a
            checkpoint and ``resume`` is false.
        JobStopped: the job was stopped; ``resume`` continues it.
        StitchMeshError: as for the functions of the stages.
    """
    target, started = Path(folder), time.perf_counter() if began is None else began
    with guarded_outputs(overwrite=overwrite):
        plan_outputs([target / name for name in _outputs(job)], folder=target)
        stages, lock = KeptStages(target), FolderLock(target, BUSY)
        try:
            remove_stale_parts(target)
            stages.tidy(CHECKPOINT)
            stages.say_what_stays()
            log, budget = JobLog(target, lock, listener), _budget(job, started, load)
            run = JobRun(job, target, resume, stop or StopRequest(), log, stages, budget)
            with end_reported(log), limited_to(limit_of(budget)):
                return _run(run)
        finally:
            lock.release()


def _outputs(job: Job) -> list[str]:
    """Return the names of the files that a job writes for the user."""
    pictures = [picture.path for picture in job.render]
    return [*job.write_stitches, *job.write_yarns, *pictures, REPORT, HISTORY, PLOT]


def _run(run: JobRun) -> FinishedJob:
    """Run the stages and write the results."""
    job, folder = run.job, run.folder
    fabric: StitchMesh | None
    relaxed: Relaxation | Swatch
    if job.swatch is None:
        garment = make_garment(run)
        fabric, relaxed, report = garment.fabric, garment.relaxed, dict(garment.report)
    else:
        made = relax_swatch(run, job.swatch)
        fabric, relaxed, report = made.value.fabric, made.value, dict(made.report)
    for name in job.write_yarns:
        write_yarns(folder / name, relaxed.yarns)
    draw_convergence(run, relaxed.history, _tolerance(report))
    refused = _drawn_in_time(run, fabric, relaxed.yarns) if job.render else None
    if refused is not None:
        report["no_picture"] = refused
    report["job"] = {"seconds": round(run.log.seconds, 2), "stages": [asdict(stage) for stage in run.log.stages]}
    write_json(folder / REPORT, report)
    write_history(folder / HISTORY, relaxed.history)  # A page that follows the folder takes this file as the end.
    return FinishedJob(relaxed.yarns, fabric, report, drawn=bool(job.render) and refused is None)


def _tolerance(report: dict[str, Any]) -> float:
    """Return the residual at which the relaxation of a report ends."""
    quality = report["quality"]
    return float(quality["tolerance"] if isinstance(quality, dict) else quality_named(quality).tolerance)


def _budget(job: Job, began: float, load: float) -> Budget | None:
    """Return the budget, which keeps time for the files, and for pictures if at least half of the time is left."""
    given = job.budget
    if given is None:
        return None
    after = load * (FILES + START_OF_RENDERER * bool(job.render))
    draws = given.within is None or given.within >= 2.0 * after
    return replace(given, began=began, after=after if draws else load * FILES, chooses=job.quality is None)


def _drawn_in_time(run: JobRun, fabric: StitchMesh | None, yarns: YarnSet) -> str | None:
    """Draw the pictures if the renderer can start within the budget; return why there are none, or None."""
    budget = run.budget
    if budget is not None and budget.within is not None:
        if budget.began + budget.within - time.perf_counter() < START_OF_RENDERER:
            logger.warning(NO_TIME_FOR_PICTURE)
            return "the time leaves none for it"
    return draw_yarns(run, fabric, yarns)


@contextmanager
def end_reported(log: JobLog) -> Iterator[None]:
    """Report how the block ends, whatever ends it; only a killed process cannot report."""
    try:
        yield
    except BaseException as error:
        stopped = isinstance(error, JobStopped) or is_interrupt(error)
        note = str(error) if isinstance(error, StitchMeshError) else f"{type(error).__name__}: {error}"
        with suppress(FileError):  # A full disk refuses the status too, and so does a removed folder.
            _close(log, "stopped", "") if stopped else _close(log, "failed", note)
        raise
    _close(log, "finished", "")


def _close(log: JobLog, state: State, note: str) -> None:
    """Report the end; after a second interrupt during this report, the file does not say that the job is running."""
    try:
        log.close(state, note)
    except KeyboardInterrupt:
        log.close(state, note)
        raise


PLOT = "convergence.png"
"""Name of the plot of the convergence in the folder of the job."""


def draw_convergence(run: JobRun, history: Sequence[HistoryEntry], tolerance: float) -> None:
    """Draw residual and energies of the relaxation against its iterations."""
    entries = [dict(entry) for entry in history]
    _draw(
        run, "plot_convergence", PLOT, lambda path: plot_convergence(history, path, tolerance=tolerance),
        entries, tolerance,
    )  # fmt: skip


def draw_yarns(run: JobRun, fabric: StitchMesh | None, yarns: YarnSet) -> str | None:
    """Draw the pictures that the job asks for; return why there are none, or None if they are drawn."""
    try:
        for table in run.job.render:
            _draw_one(run, table, fabric, yarns)
    except DisplayError as error:
        logger.warning("no picture: %s", error)
        return str(error)
    return None


def _draw_one(run: JobRun, table: RenderTable, fabric: StitchMesh | None, yarns: YarnSet) -> None:
    tiles = None if yarns.lattice is None else table.tiles
    options, inputs = table.options() | {"fabric": fabric}, (fabric, yarns, asdict(table))
    _draw(run, "render", table.path, lambda path: render(yarns, path, tiles=tiles, **options), *inputs)


def _draw(run: JobRun, name: str, output: str, draw: Callable[[Path], None], *inputs: Any) -> None:
    """Draw a picture in the folder of its stage, unless it exists there, and write it into the folder of the job."""
    stage = KeptStage(name, stage_key(name, *inputs), bytes)

    def make() -> Made[bytes]:
        path = run.kept.folder_of(stage) / PICTURE
        draw(path)
        return Made(read_bytes(path), {})

    write_bytes(run.folder / output, run.keep(stage, make).value)


@dataclass(frozen=True)
class CleanedJob:
    """What was removed from the folder of a job."""

    removed: tuple[str, ...]
    """Names of the folders of the removed stages."""
    kept: int
    """Number of stages that are left."""
    freed: int
    """Size of the removed files [bytes]."""


def clean_job(folder: str | PathLike[str]) -> CleanedJob:
    """Remove stages and checkpoints from the folder of a job if they belong to other options than the last run.

    Raises:
        FileError: the folder has no job, its last run has not finished, a run is going on in it, or a file cannot be
            removed.
    """
    target = Path(folder)
    read_status(target)  # A folder without a job gets no lock.
    lock = FolderLock(target, BUSY)
    try:
        status = read_status(target)
        if status.state != "finished":
            found = f"the last run in it was {status.state}"
            raise FileError(f"{target}: {found}, so that its stages may still be needed; run the job to its end first")
        stages = KeptStages(target)
        stages.say_what_stays()
        removed, freed = stages.remove_others({stage_folder(stage.name, stage.key) for stage in status.stages})
        return CleanedJob(removed, len(stages.folders()), freed)
    finally:
        lock.release()
