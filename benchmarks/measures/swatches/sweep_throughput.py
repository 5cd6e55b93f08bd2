# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Throughput of a sweep of small free swatches, beside one call that makes all of them in this process.

The swatches are those of ``swatch_throughput.py``, without pictures. A sweep starts its workers, which load the
compiled kernels; its time until the first task has ended is given apart.
"""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import stitchmesh as sm
from benchmarks.measures.swatches.swatch_throughput import (
    DIAMETER,
    LOOPS,
    MATERIALS,
    PATTERNS,
    WARM,
    evenly,
    together,
    variants,
)
from benchmarks.table import Rows
from stitchmesh.jobs.job_status import JobStatus
from stitchmesh.jobs.sweep.run_sweep import run_sweep
from stitchmesh.jobs.sweep.sweep import Kept

HEAD = ("workers", "swatches a task", "jobs", "failed", "s", "s until the first task", "swatches a second")


@dataclass(frozen=True)
class Options:
    """What is measured."""

    device: str = "cpu"
    """device"""
    jobs: int = 100
    """swatches"""
    quality: str = "draft"
    """preset"""
    workers: tuple[int, ...] = (1,)
    """numbers of processes"""
    together: tuple[int, ...] = (64,)
    """numbers of swatches of a task"""
    no_call: bool = False
    """leave out the one call in this process"""


def sweep_throughput(given: Options) -> Rows:
    """Yield a row for each sweep."""
    yield HEAD
    if not given.no_call:
        together(variants(WARM, given.quality), given.device)  # compiles the kernels
        made, seconds = together(variants(given.jobs, given.quality), given.device)
        failed = sum(not isinstance(one, sm.Swatch) for one in made)
        yield _row("one call", len(made), len(made), failed, seconds, None)
    for workers in given.workers:
        for count in given.together:
            yield _row(str(workers), count, *_swept(given.device, given.quality, given.jobs, workers, count))


def sweep_of(device: str, quality: str, jobs: int, together: int) -> sm.Sweep:
    """Return the sweep over the variants of ``swatch_throughput.py``."""
    grid = [(pattern, loop, material) for pattern in PATTERNS for loop in LOOPS.tolist() for material in MATERIALS]
    rows = [
        {"swatch": {"pattern": pattern, "loop_length": loop * DIAMETER, "material": material, "relax_cell": True,
                   "relaxation": "frictionless"}}
        for pattern, loop, material in (grid[number] for number in evenly(len(grid), jobs))
    ]
    job = {"device": device, "quality": quality}
    return sm.Sweep(job=job, rows=tuple(rows), swatches_per_task=together, kept=Kept(picture=None))


def _swept(device: str, quality: str, jobs: int, workers: int, together: int) -> tuple[int, int, float, float]:
    """Run a sweep; returns its jobs, those that failed, its seconds and those until the first task has ended."""
    began, first = time.perf_counter(), list[float]()

    def note(status: JobStatus) -> None:
        if status.done > 0.0 and not first:
            first.append(time.perf_counter() - began)

    with tempfile.TemporaryDirectory() as folder:
        ended = run_sweep(sweep_of(device, quality, jobs, together), Path(folder), workers=workers, listener=note)
    return ended.jobs, ended.failed, time.perf_counter() - began, first[0]


def _row(
    workers: str, together: int, jobs: int, failed: int, seconds: float, first: float | None
) -> tuple[object, ...]:
    start = "" if first is None else f"{first:.1f}"
    return workers, together, f"{jobs:,}", failed, f"{seconds:.1f}", start, f"{jobs / seconds:.2f}"
