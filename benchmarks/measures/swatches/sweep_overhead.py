# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a sweep costs besides its jobs: time of each step for each job, memory of the scheduler, and bytes on disk.

The jobs are empty: their tightness is out of bounds, so that each is checked, given to a worker, refused there, and
written as a row with its error. The table is that of docs/scale.md.
"""

from __future__ import annotations

import resource
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from benchmarks.table import Rows
from stitchmesh.jobs.sweep.axis import Axis, Choices
from stitchmesh.jobs.sweep.result_table import TASKS, read_table
from stitchmesh.jobs.sweep.run_sweep import run_sweep
from stitchmesh.jobs.sweep.sweep import Kept, Sweep
from stitchmesh.jobs.sweep.task import jobs_of, tasks_of

HEAD = ("jobs", "tasks", "checks s", "sweep s", "ms a job", "again s", "memory GB", "tasks MB", "table MB")


@dataclass(frozen=True)
class Options:
    """What is measured."""

    jobs: tuple[int, ...] = (1000,)
    """numbers of jobs"""
    workers: int = 2
    """processes"""
    together: int = 64
    """jobs of a task"""


def sweep_overhead(arguments: Options) -> Rows:
    """Yield a row for each number of jobs."""
    yield HEAD
    for jobs in arguments.jobs:
        yield _row(jobs, arguments.workers, arguments.together)


def empty_sweep(jobs: int, together: int) -> Sweep:
    """Return a sweep of jobs that are refused by the worker, because their tightness is out of bounds."""
    impossible = Choices(tuple(20.0 + number for number in range(jobs)))
    return Sweep(
        job={"device": "cpu", "quality": "draft", "swatch": {"pattern": "stockinette"}}, swatches_per_task=together,
        grid=(Axis(("swatch", "gamma"), impossible),), kept=Kept(picture=None),
    )  # fmt: skip


def _row(jobs: int, workers: int, together: int) -> list[str]:
    sweep = empty_sweep(jobs, together)
    with tempfile.TemporaryDirectory() as name:
        folder, began = Path(name), time.perf_counter()
        tasks = tasks_of(jobs_of(sweep, "cpu"), sweep)
        checked = time.perf_counter()
        ended = run_sweep(sweep, folder, workers=workers)
        done = time.perf_counter()
        assert run_sweep(sweep, folder, workers=0).kept == ended.failed == jobs == len(read_table(folder)["job_key"])
        again = time.perf_counter()
        files = sum(path.stat().st_size for path in (folder / TASKS).iterdir())
        table = (folder / "rows.parquet").stat().st_size
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    return [
        f"{jobs:,}", f"{len(tasks):,}", f"{checked - began:.1f}", f"{done - checked:.1f}",
        f"{1000 * (done - checked) / jobs:.2f}", f"{again - done:.1f}", f"{memory / 1e9:.2f}", f"{files / 1e6:.1f}",
        f"{table / 1e6:.2f}",
    ]  # fmt: skip
