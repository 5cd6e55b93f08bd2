# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tasks are given to workers a few at a time, and given again if a worker or the scheduler was lost.

A scheduler of Dask gives a task to another worker if its worker has died. If several workers have died during a task,
each of its jobs becomes a task of its own. If several workers have died during such a single job, the job is done once
more at the end, while nothing else is done, because Dask also suspects tasks that only waited at a worker; if the
worker dies again, the job has failed. If the scheduler is lost, its tasks are given to the next scheduler that answers
at the same address.
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
from stitchmesh.jobs.job_status import StopRequest
from stitchmesh.jobs.sweep.task import SweepTask
from stitchmesh.jobs.sweep.work import work
from stitchmesh.jobs.sweep.workers import GPU, offers_gpu

if TYPE_CHECKING:
    from distributed import Client, Future

Connect = Callable[[], AbstractContextManager["Client"]]
ALONE = "stitchmesh-alone"
"""Start of the keys of tasks that are done while nothing else is done."""
TICK_SECONDS = 0.5
"""Time between two checks of the request to stop and of the scheduler [s]."""
WORKERLESS_SECONDS = 60.0
"""Time without a worker after which the connection is made again [s]."""
RETURN_SECONDS = 600.0
"""Longest time in which a lost scheduler must come back [s]."""


@dataclass(frozen=True)
class Ended:
    """A task that has ended."""

    task: SweepTask
    died: bool = False
    """Whether the processes that worked on its only job died."""


@dataclass(frozen=True)
class Waiting:
    """A report that no task is being done at the moment."""

    reason: str
    """What the tasks are waiting for."""


class _SchedulerLostError(Exception):
    """The scheduler does not answer any more, has forgotten its tasks, or has lost its workers."""


def work_with(
    connect: Connect, tasks: Sequence[SweepTask], folder: Path, stop: StopRequest
) -> Iterator[Ended | Waiting]:
    """Give tasks to workers; yield each task that has ended, and the reason while nothing is done.

    Args:
        connect: connects to a scheduler, for the time of a block.
        tasks: the tasks.
        folder: folder of the sweep.
        stop: the request to stop.

    Raises:
        FileError: the scheduler does not answer, or a worker cannot write files.
        JobStopped: the user wants to stop.
        StitchMeshError: a worker does not behave as this version expects.
    """
    left = {task.key: task for task in tasks}
    last_seen: float | None = None
    while left:
        connected = False
        try:
            with connect() as client:
                connected = True
                yield from _Given(client, left, folder, stop).all_ended()
        except (_SchedulerLostError, OSError, FileError) as error:  # Broken connections of Dask are OSErrors.
            if connected and isinstance(error, FileError):
                raise
            last_seen = time.monotonic() if connected else last_seen
            if last_seen is None or time.monotonic() - last_seen > RETURN_SECONDS:
                raise _as_own(error) from error
            stop.check()
            yield Waiting("the scheduler does not answer")
            time.sleep(TICK_SECONDS)


class _Given:
    """The tasks that lie at a scheduler."""

    def __init__(self, client: Client, left: dict[str, SweepTask], folder: Path, stop: StopRequest) -> None:
        """Begin with all tasks in ``left``; a task is removed from it when it has ended."""
        self._client, self._left, self._folder, self._stop = client, left, fspath(folder), stop
        self._waiting = list(reversed(left.values()))
        self._suspected: list[SweepTask] = []
        self._last_worker = time.monotonic()
        self._given: dict[str, Future] = {}
        self._ended: queue.SimpleQueue[str] = queue.SimpleQueue()

    def all_ended(self) -> Iterator[Ended | Waiting]:
        """Yield each task that has ended, and the reason while all tasks wait."""
        while self._waiting or self._given or self._suspected:
            self._stop.check()
            self._give()
            try:
                key = self._ended.get(timeout=TICK_SECONDS)
            except queue.Empty:
                self._check()
                if reason := self._missing():
                    yield Waiting(reason)
                continue
            future, task = self._given.pop(key, None), self._left.get(key)
            if future is None or task is None:
                continue
            if (ended := self._end(task, future)) is not None:
                del self._left[key]
                yield ended

    def _give(self) -> None:
        """Give tasks to the scheduler, one for each thread of its workers; suspected tasks come last, one at a time."""
        if self._waiting:
            most = max(sum(self._client.nthreads().values()), 1)
            while self._waiting and len(self._given) < most:
                self._submit(self._waiting.pop(), "stitchmesh")
        elif self._suspected and not self._given:
            self._submit(self._suspected.pop(), ALONE)

    def _submit(self, task: SweepTask, name: str) -> None:
        future = self._client.submit(
            work, task, self._folder, key=f"{name}-{task.key}", pure=False,
            resources={GPU: 1} if task.needs_gpu else None,
        )  # fmt: skip
        self._given[task.key] = future
        future.add_done_callback(lambda _done, key=task.key: self._ended.put(key))

    def _check(self) -> None:
        """Raise an error if the scheduler is lost."""
        lost = self._client.status != "running"
        if lost or any(future.status in ("cancelled", "lost") for future in self._given.values()):
            raise _SchedulerLostError

    def _missing(self) -> str:
        """Return which kind of worker the given tasks wait for; an empty text if there is a worker.

        If there is none for a long time, the connection is made again, which starts the workers of this machine again.
        """
        if not self._client.nthreads():
            if time.monotonic() - self._last_worker > WORKERLESS_SECONDS:
                raise _SchedulerLostError
            return "no worker yet"
        self._last_worker = time.monotonic()
        needs_gpu = all(self._left[key].needs_gpu for key in self._given)
        return "no worker with a GPU yet" if needs_gpu and not offers_gpu(self._client) else ""

    def _end(self, task: SweepTask, future: Future) -> Ended | None:
        """Return a task that has ended; None if the task, or each of its jobs alone, has to be done again."""
        from distributed import KilledWorker

        if future.status not in ("finished", "error"):
            raise _SchedulerLostError
        error = future.exception() if future.status == "error" else None
        if error is not None and not isinstance(error, KilledWorker):
            raise _as_own(error)
        if error is None:
            return Ended(task)
        if len(task.jobs) > 1:
            del self._left[task.key]
            self._left |= {one.key: one for one in task.alone()}
            self._waiting += task.alone()
            return None
        if str(future.key).startswith(ALONE):
            return Ended(task, died=True)
        self._suspected.append(task)
        return None


def _as_own(error: BaseException) -> StitchMeshError:
    """Return an error of a worker as one of StitchMesh."""
    if isinstance(error, StitchMeshError):
        return error
    text = f"{type(error).__name__}: {error}"
    return StitchMeshError(f"a worker failed ({text}); its Python needs the same version of StitchMesh as this one")
