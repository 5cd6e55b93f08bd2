# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The work of a worker on a task. The function runs in a process of its own, on this machine or on another one.

Workers share the folder of the sweep. The names of pictures, yarns and folders of garments are the keys of their jobs,
and the rows of the task are written last. If a worker dies, another worker does its task again: swatches get the same
bits, and a garment continues from its checkpoint.
"""

from __future__ import annotations

import errno
import os
import socket
import time
import traceback
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from stitchmesh.compute.work_together import done_together
from stitchmesh.errors import DisplayError, FileError, StitchMeshError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.folder_lock import is_locked
from stitchmesh.io.yarns import write_yarns
from stitchmesh.jobs.job import Job
from stitchmesh.jobs.sweep.result_table import read_rows, write_rows
from stitchmesh.jobs.sweep.row import ERROR, PICTURE, SECONDS, WORKER, YARNS, Row, inputs_of, measures_of
from stitchmesh.jobs.sweep.sweep import Kept, StretchMeasure
from stitchmesh.jobs.sweep.task import SweepTask, SweptJob, is_small
from stitchmesh.mesh import StitchMesh
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.run import QUIET
from stitchmesh.yarn import YarnSet

if TYPE_CHECKING:
    from stitchmesh.periodic.swatch import Swatch, SwatchRequest

PICTURES, YARN_FILES, GARMENTS, FAULTS = "pictures", "yarns", "jobs", "faults"
"""Folders in the folder of a sweep: pictures, yarns, the folders of garments, and tracebacks of unexpected errors."""
OF_THE_MACHINE = {errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO, errno.ESTALE, errno.EMFILE, errno.ENFILE}
"""Errors of the operating system that are no fault of a job, such as a full disk."""
NOT_STRETCHED = ("period", "blocked", "relax_cell", "relaxation", "friction")
"""Options of a swatch that a stretch test does not use, because it begins at the free cell without friction."""


def work(task: SweepTask, folder: str) -> int:
    """Do the jobs of a task, and write their rows; nothing is done if the task is finished.

    Args:
        task: the task.
        folder: folder of the sweep, which all workers share.

    Returns:
        The number of jobs that failed. Their rows hold the error.

    Raises:
        FileError: the disk is full, or the folder cannot be written.
    """
    target = Path(folder)
    rows = read_rows(target, task)
    if rows is None:
        rows = _swatches(task, target) if is_small(task.jobs[0].job) else _garment(task, target)
        write_rows(target, task, rows)
    return sum(row[ERROR] is not None for row in rows.values())


def error_row(one: SweptJob, error: str, seconds: float = 0.0) -> Row:
    """Return the row of a job that failed."""
    return inputs_of(one.job) | {ERROR: error} | _of_the_run(seconds)


def _swatches(task: SweepTask, folder: Path) -> dict[str, Row]:
    """Relax and stretch swatches, and return their rows; on a GPU all of them share launches."""
    from stitchmesh.yarnrelax.together.relax_together import ways_together

    began = time.perf_counter()
    made = _relaxed(task, folder)
    computations = [partial(_row_of, one, found, task.kept, folder) for one, found in zip(task.jobs, made, strict=True)]
    rows = list[Row]()
    for row in done_together(computations, ways_together() if task.needs_gpu else {}):
        if isinstance(row, StitchMeshError):  # of the machine: ``_row_of`` keeps the errors of jobs
            raise row
        rows.append(row)
    own = _of_the_run((time.perf_counter() - began) / len(task.jobs))
    return {one.key: row | own for one, row in zip(task.jobs, rows, strict=True)}


def _relaxed(task: SweepTask, folder: Path) -> list[Swatch | str]:
    """Return the swatches of a task; an error text stands in the place of a swatch that cannot be relaxed."""
    from stitchmesh.periodic.swatch import relax_swatches

    asked = [_request_or_fault(one, folder) for one in task.jobs]
    requests = [one for one in asked if not isinstance(one, str)]
    groups = [requests] if task.needs_gpu else [[one] for one in requests]
    try:
        together = [relax_swatches(group, device=task.jobs[0].job.device, progress=False) for group in groups]
    except Exception as error:
        if len(task.jobs) == 1:
            return [_fault_of(error, task.jobs[0], folder)]
        return [one for alone in task.alone() for one in _relaxed(alone, folder)]
    made = iter(one for group in together for one in group)
    found = [one if isinstance(one, str) else next(made) for one in asked]
    return [_text_of(one) if isinstance(one, StitchMeshError) else one for one in found]


def _request_or_fault(one: SweptJob, folder: Path) -> SwatchRequest | str:
    try:
        return _request(one.job)
    except Exception as error:
        return _fault_of(error, one, folder)


def _request(job: Job) -> SwatchRequest:
    """Return the request for the swatch of a job.

    Raises:
        ParameterError: an option is out of bounds.
    """
    from stitchmesh.periodic.swatch import SwatchRequest

    table = job.swatch
    assert table is not None
    return SwatchRequest(
        table.pattern, material=table.yarn_material(), quality=table.quality(job.quality or DEFAULT_QUALITY),
        shaken=table.shaken, options=vars(table.options()),
    )  # fmt: skip


def _row_of(one: SweptJob, found: Swatch | str, kept: Kept, folder: Path) -> Row:
    """Return the row of a swatch or of its error, and write the files that the sweep keeps.

    Raises:
        FileError: the disk is full, or the folder cannot be written.
    """
    if isinstance(found, str):
        return error_row(one, found)
    try:
        own = measures_of(found.report) | _files(one, found.yarns, found.fabric, kept, folder)
        for measure in kept.stretch:
            own |= _stretched(one.job, measure)
    except Exception as error:
        return error_row(one, _fault_of(error, one, folder))
    return inputs_of(one.job) | {ERROR: None} | own


def _garment(task: SweepTask, folder: Path) -> dict[str, Row]:
    """Run a job in a folder of its own, from its checkpoint if there is one, and return its row."""
    from stitchmesh.jobs.run_job import run_job

    (one,), began = task.jobs, time.perf_counter()
    own = folder / GARMENTS / one.key
    while is_locked(own):  # A worker that the scheduler has lost still works on it.
        time.sleep(1.0)
    try:
        made = run_job(one.job, own, resume=True)
        row = inputs_of(one.job) | {ERROR: None} | measures_of(made.report)
        row |= _files(one, made.yarns, made.fabric, task.kept, folder)
    except Exception as error:
        return {one.key: error_row(one, _fault_of(error, one, folder), time.perf_counter() - began)}
    return {one.key: row | _of_the_run(time.perf_counter() - began)}


def _files(one: SweptJob, yarns: YarnSet, fabric: StitchMesh | None, kept: Kept, folder: Path) -> Row:
    """Write the picture and the yarns of a job, where the sweep keeps them; returns their columns."""
    row: Row = {PICTURE: None, YARNS: None}
    if kept.write_yarns:
        row[YARNS] = f"{YARN_FILES}/{one.key}.h5"
        write_yarns(folder / row[YARNS], yarns)
    if kept.picture is not None:
        from stitchmesh.render import render

        name = f"{PICTURES}/{one.key}.png"
        tiles = None if yarns.lattice is None else (4, 4)
        try:
            # A page may hold thousands of pictures, and a yarn in light and shade has few colours.
            render(yarns, folder / name, fabric=fabric, size=kept.picture, tiles=tiles, colours=64)
            row[PICTURE] = name
        except DisplayError:  # A machine without a renderer also makes rows.
            pass
    return row


def _stretched(job: Job, measure: StretchMeasure) -> Row:
    """Return the columns of a stretch test: the strains and the tensions [dyn/cm]."""
    from stitchmesh.periodic.stretch import StretchPath, stretch_test

    assert job.swatch is not None
    options = {name: value for name, value in vars(job.swatch.options()).items() if name not in NOT_STRETCHED}
    table = job.swatch
    course, wale = (measure.strains if measure.direction == name else None for name in ("course", "wale"))
    path = StretchPath(course=course, wale=wale, steps=measure.steps, other=measure.other)
    curve = stretch_test(
        table.pattern, path, material=table.yarn_material(), quality=table.quality(job.quality or DEFAULT_QUALITY),
        device=job.device, run=QUIET, **options,
    )  # fmt: skip
    name = f"stretch_{measure.direction}"
    return {f"{name}.strain": curve.column("strain").tolist(), f"{name}.tension": curve.tension.tolist()}


def _of_the_run(seconds: float) -> Row:
    return {SECONDS: round(seconds, 4), WORKER: f"{socket.gethostname()}:{os.getpid()}"}


def _text_of(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


def _fault_of(error: Exception, one: SweptJob, folder: Path) -> str:
    """Return the text of an error of a job; the traceback of an unexpected error is kept in a file.

    Raises:
        FileError: the job failed because of the machine, for example because its disk is full.
    """
    cause = error.__cause__ if isinstance(error, FileError) else error
    if isinstance(cause, OSError) and cause.errno in OF_THE_MACHINE:
        raise error if isinstance(error, FileError) else FileError(_text_of(error)) from cause
    if isinstance(error, StitchMeshError):
        return _text_of(error)
    path = folder / FAULTS / f"{one.key}.txt"
    write_text(path, traceback.format_exc())
    return f"{_text_of(error)} (unexpected; {FAULTS}/{path.name} has the traceback)"
