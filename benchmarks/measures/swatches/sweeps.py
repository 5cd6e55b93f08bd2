# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What sweeps cost: small free swatches beside one call that makes all of them, and sweeps of empty jobs.

- ``swatches``: the variants of ``swatch_throughput.py`` without pictures. A sweep starts its workers, which load the
  compiled kernels; its time until the first task has ended is given apart.
- ``empty``: what a sweep costs besides its jobs: time of each step for each job, memory of the scheduler, and bytes on
  disk. The tightness of the jobs is out of bounds, so that each is checked, given to a worker, refused there, and
  written as a row with its error.
"""

from __future__ import annotations

import itertools
import resource
import tempfile
import time
from pathlib import Path

import stitchmesh as sm
from benchmarks.measures.swatches.swatch_throughput import WARM, together
from benchmarks.scenes.swatches import DIAMETER, requested, variants
from benchmarks.table import Rows
from stitchmesh.jobs.job_status import JobStatus
from stitchmesh.jobs.sweep.axis import Axis, Choices
from stitchmesh.jobs.sweep.result_table import TASKS, read_table
from stitchmesh.jobs.sweep.run_sweep import run_sweep
from stitchmesh.jobs.sweep.sweep import Kept
from stitchmesh.jobs.sweep.task import jobs_of, tasks_of

NO_PICTURE = Kept(picture=None)


def swatches(
    *,
    device: str = "cpu",
    jobs: int = 100,
    workers: tuple[int, ...] = (1,),
    per_task: tuple[int, ...] = (64,),
    no_call: bool = False,
) -> Rows:
    """Measure the throughput of sweeps.

    Args:
        jobs: swatches
        workers: numbers of processes
        per_task: numbers of swatches of a task
        no_call: leave out the one call in this process
    """
    yield "workers", "swatches a task", "jobs", "failed", "s", "s until the first task", "swatches a second"
    if not no_call:
        for count in (WARM, jobs):  # The first call compiles the kernels.
            made, spent = together([requested(variant, "draft") for variant in variants(count)], device)
        failed = sum(not isinstance(one, sm.Swatch) for one in made)
        rate = len(made) / spent.seconds
        yield "one call", len(made), f"{len(made):,}", failed, f"{spent.seconds:.1f}", "", f"{rate:.2f}"
    rows = tuple(
        {"swatch": {"pattern": pattern, "loop_length": loop * DIAMETER, "material": material, "relax_cell": True,
                    "relaxation": "frictionless"}}
        for pattern, loop, material in variants(jobs)
    )  # fmt: skip
    for count, size in itertools.product(workers, per_task):
        sweep = sm.Sweep(
            job={"device": device, "quality": "draft"}, rows=rows, swatches_per_task=size, kept=NO_PICTURE
        )
        first: list[float] = []
        began = time.perf_counter()

        def listen(status: JobStatus, began: float = began, first: list[float] = first) -> None:
            if status.done > 0.0 and not first:
                first.append(time.perf_counter() - began)

        with tempfile.TemporaryDirectory() as folder:
            ended = run_sweep(sweep, Path(folder), workers=count, listener=listen)
        seconds = time.perf_counter() - began
        times = f"{seconds:.1f}", f"{first[0]:.1f}", f"{ended.jobs / seconds:.2f}"
        yield count, size, f"{ended.jobs:,}", ended.failed, *times


def empty(*, jobs: tuple[int, ...] = (1000,), workers: int = 2, per_task: int = 64) -> Rows:
    """Measure sweeps of empty jobs.

    Args:
        jobs: numbers of jobs
        workers: processes
        per_task: jobs of a task
    """
    yield "jobs", "tasks", "checks s", "sweep s", "ms a job", "again s", "memory GB", "tasks MB", "table MB"
    for count in jobs:
        impossible = Choices(tuple(20.0 + number for number in range(count)))
        sweep = sm.Sweep(
            job={"device": "cpu", "quality": "draft", "swatch": {"pattern": "stockinette"}},
            swatches_per_task=per_task, grid=(Axis(("swatch", "gamma"), impossible),), kept=NO_PICTURE,
        )  # fmt: skip
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            began = time.perf_counter()
            tasks = tasks_of(jobs_of(sweep, "cpu"), sweep)
            checked = time.perf_counter()
            ended = run_sweep(sweep, folder, workers=workers)
            done = time.perf_counter()
            assert run_sweep(sweep, folder, workers=0).kept == ended.failed == count
            assert len(read_table(folder)["job_key"]) == count
            again = time.perf_counter()
            files = sum(path.stat().st_size for path in (folder / TASKS).iterdir())
            table = (folder / "rows.parquet").stat().st_size
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        yield (
            f"{count:,}", f"{len(tasks):,}", f"{checked - began:.1f}", f"{done - checked:.1f}",
            f"{1000 * (done - checked) / count:.2f}", f"{again - done:.1f}", f"{memory / 1e9:.2f}",
            f"{files / 1e6:.1f}", f"{table / 1e6:.2f}",
        )  # fmt: skip


ACTIONS = (swatches, empty)
