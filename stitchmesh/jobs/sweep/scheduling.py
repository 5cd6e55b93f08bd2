# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tasks given to workers a few at a time, and given again if a worker or the scheduler was lost.

A scheduler of Dask gives a task to another worker if its worker has died. A task of which several workers died is
divided: its jobs are done alone, and the one of which workers die again is a job that failed. If the scheduler is
lost, its tasks are given to the one that answers next at the same address.
"""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from os import fspath
from pathlib import Path
from typing import TYPE_CHECKING

from stitchmesh.errors import FileError, StitchMeshError
from stitchmesh.jobs.stop import StopRequest
from stitchmesh.jobs.sweep.task import Task
from stitchmesh.jobs.sweep.work import work

if TYPE_CHECKING:
    from distributed import Client, Future

Connect = Callable[[], AbstractContextManager["Client"]]
LEAST_GIVEN, GIVEN_PER_WORKER = 16, 4
"""Tasks that lie at the scheduler at a time, at least and for each thread of a worker."""
TICK_SECONDS = 0.5
"""Time between two looks at the wish to stop and at the scheduler [s]."""
RETURN_SECONDS = 600.0
"""Longest time in which a lost scheduler must come back [s]."""


@dataclass(frozen=True)
class Ended:
    """A task that has ended."""

    task: Task
    died: bool = False
    """Whether the processes that worked on its only job died."""


class _SchedulerLostError(Exception):
    """The scheduler does not answer any more, or has forgotten its tasks."""


def work_with(connect: Connect, tasks: Sequence[Task], folder: Path, stop: StopRequest) -> Iterator[Ended]:
    """Have tasks done, and yield each when it has ended.

    Args:
        connect: connects to a scheduler, for the time of a block.
        tasks: the tasks.
        folder: folder of the sweep.
        stop: a wish to stop.

    Raises:
        FileError: the scheduler does not answer, or a worker cannot write files.
        JobStopped: the user wants to stop.
        StitchMeshError: a worker does not work as this version does.
    """
    left, lost = {task.key: task for task in tasks}, None
    while left:
        try:
            with connect() as client:
                lost = None
                yield from _Given(client, left, folder, stop).all_ended()
        except (_SchedulerLostError, FileError) as error:
            first = time.monotonic() if lost is None else lost
            if isinstance(error, FileError) and (lost is None or time.monotonic() - lost > RETURN_SECONDS):
                raise
            lost = first
            stop.check()
            time.sleep(TICK_SECONDS)


class _Given:
    """The tasks that lie at a scheduler."""

    def __init__(self, client: Client, left: dict[str, Task], folder: Path, stop: StopRequest) -> None:
        """Begin; tasks are taken out of ``left`` when they have ended."""
        self._client, self._left, self._folder, self._stop = client, left, fspath(folder), stop
        self._waiting = list(reversed(left.values()))
        self._given: dict[str, Future] = {}
        self._ended: queue.SimpleQueue[str] = queue.SimpleQueue()

    def all_ended(self) -> Iterator[Ended]:
        """Yield each task when it has ended."""
        while self._waiting or self._given:
            self._give()
            try:
                key = self._ended.get(timeout=TICK_SECONDS)
            except queue.Empty:
                self._check()
                continue
            future, task = self._given.pop(key, None), self._left.get(key)
            if future is not None and task is not None and (ended := self._end(task, future)) is not None:
                yield ended

    def _give(self) -> None:
        """Give tasks to the scheduler, as many as its workers need."""
        most = max(LEAST_GIVEN, GIVEN_PER_WORKER * sum(self._client.nthreads().values())) if self._waiting else 0
        while self._waiting and len(self._given) < most:
            task = self._waiting.pop()
            future = self._client.submit(
                work, task, self._folder, key=f"stitchmesh-{task.key}", pure=False,
                resources={"GPU": 1} if task.needs_gpu else None,
            )  # fmt: skip
            self._given[task.key] = future
            future.add_done_callback(lambda _done, key=task.key: self._ended.put(key))

    def _check(self) -> None:
        """Return unless the user wants to stop, or the scheduler is lost."""
        self._stop.check()
        lost = self._client.status != "running"
        if lost or any(future.status in ("cancelled", "lost") for future in self._given.values()):
            raise _SchedulerLostError

    def _end(self, task: Task, future: Future) -> Ended | None:
        """Return a task that has ended; None if its jobs have to be done alone."""
        from distributed.scheduler import KilledWorker

        if future.status not in ("finished", "error"):
            raise _SchedulerLostError
        error = future.exception() if future.status == "error" else None
        if error is not None and not isinstance(error, KilledWorker):
            raise _as_own(error)
        del self._left[task.key]
        if error is None:
            return Ended(task)
        if len(task.jobs) == 1:
            return Ended(task, died=True)
        for one in task.alone():
            self._left[one.key] = one
            self._waiting.append(one)
        return None


def _as_own(error: BaseException) -> StitchMeshError:
    """Return an error of a worker as one of StitchMesh."""
    if isinstance(error, StitchMeshError):
        return error
    text = f"{type(error).__name__}: {error}"
    return StitchMeshError(f"a worker failed ({text}); its Python needs the same version of StitchMesh as this one")
