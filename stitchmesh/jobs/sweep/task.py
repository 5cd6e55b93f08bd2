# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tasks of a sweep: one worker does one task at a time.

A task is one garment, or some swatches, which are relaxed together on a GPU. The sweep alone decides which swatches
share a task, so that results depend neither on the workers nor on interruptions. Keys are checksums of everything that
decides a result; a task with the key of a finished task is not computed again.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from stitchmesh import __version__
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.contents import read_bytes
from stitchmesh.io.path_kind import whole_path
from stitchmesh.jobs.job import Job
from stitchmesh.jobs.job_file import check_job_paths, job_of_table
from stitchmesh.jobs.sweep.sweep import Kept, Sweep
from stitchmesh.yarnrelax.fingerprint import checksum

SWATCHES_ON_GPU, SWATCHES_ON_CPU = 1000, 8
"""Swatches of a task. On a GPU a thousand swatches take two minutes together, and a quarter of them takes one minute.
On a CPU each swatch is relaxed by itself, and the number is small, because a worker that dies loses its whole task."""


@dataclass(frozen=True)
class SweptJob:
    """One job of a sweep."""

    key: str
    """Checksum of everything that decides its result."""
    job: Job
    """The job, with absolute paths."""


@dataclass(frozen=True)
class SweepTask:
    """Jobs that one worker does together."""

    jobs: tuple[SweptJob, ...]
    """The jobs."""
    kept: Kept
    """What is kept of each job besides its row."""

    @property
    def key(self) -> str:
        """Checksum of everything that decides the results."""
        return checksum("task", [one.key for one in self.jobs])

    @property
    def needs_gpu(self) -> bool:
        """Whether the jobs run on a GPU."""
        return self.jobs[0].job.device != "cpu"

    def alone(self) -> list[SweepTask]:
        """Return a task for each of the jobs."""
        return [SweepTask((one,), self.kept) for one in self.jobs]


def jobs_of(sweep: Sweep, device: str) -> list[SweptJob]:
    """Return the jobs of a sweep, in their order.

    Args:
        sweep: the sweep.
        device: device of jobs that name none.

    Raises:
        FileError: a job has a key or a value that no job has, or a file that a job reads is missing; the message says
            which job it is.
    """
    checksum_of = cache(_file_checksum)  # The cache lasts for one call: a file may change before the next call.
    return [_swept_job(sweep, number, device, checksum_of) for number in range(sweep.job_count)]


def tasks_of(jobs: list[SweptJob], sweep: Sweep) -> list[SweepTask]:
    """Return the tasks for jobs; a job that occurs twice is done once."""
    different = {one.key: one for one in jobs}.values()
    together = [one for one in different if is_small(one.job)]
    alone = [one for one in different if not is_small(one.job)]
    groups: list[tuple[SweptJob, ...]] = [(one,) for one in alone]
    for usual, on_cpu in ((SWATCHES_ON_GPU, False), (SWATCHES_ON_CPU, True)):  # No task may need two kinds of workers.
        count = sweep.swatches_per_task or usual
        of_device = [one for one in together if (one.job.device == "cpu") == on_cpu]
        groups += [tuple(of_device[k : k + count]) for k in range(0, len(of_device), count)]
    return [SweepTask(tuple(group), sweep.kept) for group in groups]


def is_small(job: Job) -> bool:
    """Whether a job is a swatch without a limit on time or error, which can be relaxed together with others."""
    return job.swatch is not None and job.budget is None


def _swept_job(sweep: Sweep, number: int, device: str, checksum_of: Callable[[str], str]) -> SweptJob:
    path = whole_path(sweep.name)
    try:
        table = sweep.table(number)
        job = job_of_table(copy.deepcopy({"device": device} | table), str(path))
        files = [checksum_of(found) for found in check_job_paths(job, path, sweep.allow_paths)]
    except (FileError, ParameterError) as error:
        changes = ", ".join(f"{'.'.join(keys)} = {value!r}" for keys, value in sweep.changes(number))
        what = str(error).removeprefix(f"{path}: ")
        raise FileError(f"{sweep.name}: job {number}{f' ({changes})' if changes else ''}: {what}") from error
    kind = "cpu" if job.device == "cpu" else "cuda"
    key = checksum("job", (__version__, table, files, kind, sweep.kept))
    return SweptJob(key, job)


def _file_checksum(path: str) -> str:
    return checksum("file", read_bytes(path).hex())
