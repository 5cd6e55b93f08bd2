# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The run of a sweep: the order of operations.

Finished tasks are files, so a sweep that was interrupted continues where it stopped, with any other workers.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING

from stitchmesh.compute.threads import core_count
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.folder_lock import FolderLock
from stitchmesh.io.outputs import claim_folder, guarded_outputs, plan_outputs
from stitchmesh.io.part_folder import remove_stale_parts
from stitchmesh.io.path_kind import whole_path
from stitchmesh.jobs.job_status import JobLog, Listener, StopRequest
from stitchmesh.jobs.run_job import BUSY, end_reported
from stitchmesh.jobs.sweep.result_table import (
    TABLE,
    TASKS,
    TEXT_TABLE,
    import_pyarrow,
    read_rows,
    write_rows,
    write_table,
)
from stitchmesh.jobs.sweep.row import ERROR, Row
from stitchmesh.jobs.sweep.scheduling import Ended, Waiting, work_with
from stitchmesh.jobs.sweep.sweep import Sweep
from stitchmesh.jobs.sweep.task import SweepTask, SweptJob, jobs_of, tasks_of
from stitchmesh.jobs.sweep.work import FAULTS, GARMENTS, PICTURES, YARN_FILES, error_row, work
from stitchmesh.jobs.sweep.workers import TLS, address_of, local_workers, offers_gpu, standing_workers
from stitchmesh.memory_need import BASE_MEMORY, check_memory

if TYPE_CHECKING:
    from distributed.deploy.cluster import Cluster

logger = logging.getLogger(__name__)

STAGE = "sweep"
OPEN = "{address}: takes code from everyone who reaches it; give it certificates (tls://, docs/how-to/sweeps.md)"
"""Warning about a scheduler that needs no certificate."""


@dataclass(frozen=True)
class FinishedSweep:
    """The outcome of a sweep."""

    jobs: int
    """Number of jobs."""
    failed: int
    """Number of jobs whose row holds an error."""
    kept: int
    """Number of jobs that earlier runs had finished."""
    first_error: str | None
    """Error of the first job that failed; None if none has."""

    @property
    def all_failed(self) -> bool:
        """Whether no job has a result."""
        return self.failed == self.jobs


def run_sweep(
    sweep: Sweep, folder: str | PathLike[str], *, workers: int | None = None,
    scheduler: str | Cluster | None = None, stop: StopRequest | None = None, listener: Listener = lambda _: None,
    overwrite: bool = False,
) -> FinishedSweep:  # fmt: skip
    """Do all jobs of a sweep, and write their table.

    The folder gets ``rows.parquet`` and ``rows.csv``, with a row for each job (``read_table``), ``status.json`` while
    the sweep runs, and the files that the sweep keeps of each job. Jobs that an earlier run has done are not done
    again.

    Args:
        sweep: the sweep (``read_sweep``).
        folder: folder of the sweep, which only one run may use at a time and all workers share.
        workers: number of processes on this machine; 0 works in this process, and None takes one for each GPU, or one
            for each core of a machine without a GPU.
        scheduler: a standing scheduler of Dask, whose workers do the jobs: its address, or the object of Dask that
            started it, which knows its certificates.
        stop: the request to stop, which a signal handler or another thread may make.
        listener: called with each report of the progress.
        overwrite: whether the sweep may replace files in the folder that StitchMesh did not write, or that were changed
            later.

    Raises:
        FileError: another run works in the folder, a job of the sweep cannot be read, the scheduler does not answer, or
            files cannot be written or may not be replaced.
        ParameterError: the number of workers is not possible, or a package is missing.
        JobStopped: the sweep was stopped; the same call continues it.
    """
    if workers is not None and (workers < 0 or scheduler is not None):
        expected = "0 or more" if scheduler is None else "no number with a scheduler, which has workers of its own"
        raise ParameterError(f"workers: got {workers}; expected {expected}")
    import_pyarrow()
    target = whole_path(folder)
    with guarded_outputs(overwrite=overwrite), _doing(target, workers, scheduler, sweep) as (device, do):
        jobs = jobs_of(sweep, device)  # This comes before the folder is made, so that a refused sweep leaves nothing.
        plan_outputs([target / TABLE, target / TEXT_TABLE], folder=target)
        claim_folder(target, (TASKS, PICTURES, YARN_FILES, GARMENTS, FAULTS))
        lock = FolderLock(target, BUSY)
        try:
            remove_stale_parts(target)
            log = JobLog(target, lock, listener)
            with end_reported(log):
                return _run(jobs, sweep, target, log, stop or StopRequest(), do)
        finally:
            lock.release()


Do = Callable[[list[SweepTask], StopRequest], Iterator[Ended | Waiting]]
"""Function that gives tasks to workers; it yields each task that has ended, and the reason while all tasks wait."""


@contextmanager
def _doing(
    folder: Path, workers: int | None, scheduler: str | Cluster | None, sweep: Sweep
) -> Iterator[tuple[str, Do]]:
    """Provide the device of jobs that name none, and a function that gives tasks to workers."""
    from stitchmesh.compute.device import CPU, FIRST_GPU, device_named, device_names

    if scheduler is not None:
        if not (address := address_of(scheduler)).startswith(TLS):
            logger.warning(OPEN.format(address=address))
        with standing_workers(scheduler) as client:
            device = FIRST_GPU if offers_gpu(client) else CPU
        yield device, lambda tasks, stop: work_with(lambda: standing_workers(scheduler), tasks, folder, stop)
        return
    device = str(device_named(sweep.job.get("device")))
    if workers == 0:
        yield device, lambda tasks, stop: _work_here(tasks, folder, stop)
        return
    devices = 0 if device == CPU else sum(name.startswith("cuda") for name in device_names())
    gpus = min(devices, workers or devices)
    count = workers or core_count()
    check_memory(f"a sweep with {count:,} workers", BASE_MEMORY * count, "fewer workers")
    yield device, lambda tasks, stop: work_with(lambda: local_workers(count, gpus), tasks, folder, stop)


def _work_here(tasks: list[SweepTask], folder: Path, stop: StopRequest) -> Iterator[Ended]:
    """Do tasks one after another in this process."""
    for task in tasks:
        stop.check()
        work(task, fspath(folder))
        yield Ended(task)


def _run(jobs: list[SweptJob], sweep: Sweep, folder: Path, log: JobLog, stop: StopRequest, do: Do) -> FinishedSweep:
    """Do the tasks that are not finished, and write the table."""
    tasks = tasks_of(jobs, sweep)
    found = {task.key: read_rows(folder, task) for task in tasks}
    rows = {key: row for own in found.values() if own is not None for key, row in own.items()}
    kept, written = sum(one.key in rows for one in jobs), time.monotonic()
    missing = [task for task in tasks if found[task.key] is None]
    different = sum(len(task.jobs) for task in tasks)
    log.begin(STAGE)
    try:
        for ended in do(missing, stop):
            reason = f"; {ended.reason}" if isinstance(ended, Waiting) else ""
            rows |= {} if isinstance(ended, Waiting) else _rows_of(ended, folder)
            log.progress(STAGE, len(rows) / different, _note(rows, different) + reason)
            if time.monotonic() - written > 60.0:  # The table of a large sweep takes seconds to write.
                write_table(folder, jobs, rows)
                written = time.monotonic()
        for task in missing:  # A divided task gets a file too, so that the next run finds it finished.
            if read_rows(folder, task) is None:
                write_rows(folder, task, {one.key: rows[one.key] for one in task.jobs})
    finally:
        write_table(folder, jobs, rows)
    errors = [rows[one.key][ERROR] for one in jobs if rows[one.key][ERROR] is not None]
    return FinishedSweep(len(jobs), len(errors), kept, next(iter(errors), None))


def _rows_of(ended: Ended, folder: Path) -> dict[str, Row]:
    """Return the rows of a task; a job that made its workers die has an error."""
    if ended.died:
        (one,) = ended.task.jobs
        died = "the processes that worked on it died; it may need more memory than a worker has"
        rows = {one.key: error_row(one, died)}
        write_rows(folder, ended.task, rows)
        return rows
    found = read_rows(folder, ended.task)
    if found is None:
        raise FileError(f"{folder}: the rows of a finished task are missing; all workers need the same folder")
    return found


def _note(rows: Mapping[str, Row], jobs: int) -> str:
    failed = sum(row[ERROR] is not None for row in rows.values())
    return f"{len(rows)} of {jobs} jobs" + (f", {failed} failed" if failed else "")
