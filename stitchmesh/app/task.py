# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Long work in a worker thread, with progress and cancellation, and work of which only the newest request is done.

The work is a function of a ``TaskControl``. It reports its progress through the control, which is a ``Progress``
function of the library. At each report the work ends if it is cancelled. Results, frames and errors arrive in the
thread of the event queue. Work that can be paused is a ``LiveRun``.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from stitchmesh.app.event_queue import EventQueue
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.progress import Outlook, StageClock

T = TypeVar("T")

FRAME_SECONDS = 0.1
"""Shortest time between two frames of a task; the browser needs about this time to draw a garment."""


class TaskCancelled(BaseException):
    """The user stopped the task. This is no ``Exception``, so that no error handler takes it for a failure."""


class TaskControl:
    """The actions of a task's work: to report, publish frames and end."""

    def __init__(self, task: Task[Any]) -> None:
        """Make the control of a task."""
        self._task = task

    def __call__(self, stage: str, done: float, note: str) -> None:
        """Report progress, as a ``Progress`` function.

        Raises:
            TaskCancelled: the user stopped the task.
        """
        self._task.report(stage, done)
        self.check()

    progress = __call__

    def check(self) -> None:
        """End the work if the user stopped the task.

        Raises:
            TaskCancelled: the user stopped the task.
        """
        if self._task.cancel_requested.is_set():
            raise TaskCancelled

    def frame(self, value: object) -> None:
        """Publish a frame; it replaces an earlier frame that has not been shown yet."""
        self._task.publish(value)


class Task(Generic[T]):
    """One piece of long work, with its progress. Any thread may call its methods."""

    def __init__(self, name: str, queue: EventQueue) -> None:
        """Make a task that does not run yet."""
        self.name = name
        self.stage, self.outlook = "", Outlook(0.0, None)
        self._clock = StageClock()
        self.on_frame: Callable[[Any], None] | None = None
        """Called in the event thread with each frame."""
        self.on_cancel: Callable[[], None] | None = None
        """Called when the user cancels the task, for work that can end with a good state."""
        self.cancel_requested = threading.Event()
        self._queue = queue
        self._began = time.monotonic()

    @property
    def done(self) -> float:
        """Completed part of the present stage, from 0 to 1."""
        return self.outlook.part

    def report(self, stage: str, done: float) -> None:
        """Keep a report of the work."""
        if stage != self.stage:
            self._began, self._clock = time.monotonic(), StageClock()
        self.stage, self.outlook = stage, self._clock.outlook(time.monotonic() - self._began, done)

    def publish(self, value: object) -> None:
        """Hand a frame to the event thread."""
        self._queue.post_newest((id(self), "frame"), self._show_frame, value)

    def cancel(self) -> None:
        """Ask the work to end."""
        self.cancel_requested.set()
        if self.on_cancel is not None:
            self.on_cancel()

    def _show_frame(self, value: object) -> None:
        if self.on_frame is not None:
            self.on_frame(value)


class TaskRunner:
    """Runs one task at a time in a worker thread."""

    def __init__(self, queue: EventQueue, on_error: Callable[[Exception], None]) -> None:
        """Make a runner; the event thread calls ``on_error`` with errors of tasks that do not handle them."""
        self._queue, self._on_error = queue, on_error
        self.current: Task[Any] | None = None
        """The running task; None without one."""

    @property
    def running(self) -> bool:
        """Whether a task runs."""
        return self.current is not None

    def start(
        self, name: str, work: Callable[[TaskControl], T], done: Callable[[T], None],
        failed: Callable[[Exception | None], None] | None = None,
    ) -> Task[T]:  # fmt: skip
        """Start a task; only the event thread may call this.

        Args:
            name: name of the work, in the words of the user: ``relaxing the yarns``.
            work: the work, in the worker thread.
            done: called in the event thread with the result.
            failed: called in the event thread with the error, or with None if the task was cancelled; a notice shows
                the error too.

        Raises:
            ParameterError: another task runs.
        """
        if self.current is not None:
            raise ParameterError(f"{name}: {self.current.name} is still running; stop it first, or wait")
        task: Task[T] = Task(name, self._queue)
        self.current = task
        threading.Thread(target=self._run, args=(task, work, done, failed), name=name, daemon=True).start()
        return task

    def cancel(self) -> None:
        """Ask the current task to end, if there is one."""
        if self.current is not None:
            self.current.cancel()

    def _run(
        self, task: Task[T], work: Callable[[TaskControl], T], done: Callable[[T], None],
        failed: Callable[[Exception | None], None] | None,
    ) -> None:  # fmt: skip
        try:
            result = work(TaskControl(task))
        except TaskCancelled:
            self._queue.post(self._end, failed, None)
        except Exception as error:
            self._queue.post(self._end, failed, error)
        else:
            self._queue.post(self._end, done, result)

    def _end(self, then: Callable[[Any], None] | None, value: object) -> None:
        """Free the runner, and pass on the result or the error."""
        self.current = None
        if isinstance(value, Exception):
            self._on_error(value)
        if then is not None:
            then(value)


@dataclass(frozen=True)
class Refused:
    """The result of work that is not possible."""

    reason: str
    """The reason, in one line."""


@dataclass(frozen=True, eq=False)
class Work:
    """Work for a task, and the functions that the event thread then calls."""

    name: str
    """Name of the work, in the words of the user."""
    run: Callable[[TaskControl], Any]
    """The work, in the worker thread."""
    done: Callable[[Any], object]
    """Called with the result, with ``Refused`` if the work is not possible, or with None if it was stopped."""
    frame: Callable[[Any], object] = lambda value: None
    """Called with each frame."""


class NewestTask:
    """Does one piece of work at a time. All methods belong to the event thread."""

    def __init__(self, tasks: TaskRunner) -> None:
        """Do nothing yet."""
        self._tasks = tasks
        self._work: Work | None = None
        self._waiting: Work | None = None
        self.task: Task[Any] | None = None
        """The running task; None if none runs."""

    @property
    def work(self) -> Work | None:
        """The newest work that has not ended."""
        return self._waiting or self._work

    @property
    def blocked_by(self) -> str | None:
        """Name of another task that must end first; None if there is none."""
        other = self._tasks.current
        return None if other is None or other is self.task else other.name

    def ask(self, work: Work) -> None:
        """Do a piece of work, in place of one that still runs.

        Raises:
            ParameterError: another task runs.
        """
        if self.task is None:
            self._start(work)
        else:
            self._waiting = work
            self.task.cancel()

    def stop(self) -> None:
        """End the work, and do none that waits."""
        self._waiting = None
        if self.task is not None:
            self.task.cancel()

    def _start(self, work: Work) -> None:
        self._waiting = None
        self.task = self._tasks.start(
            work.name, lambda control: _caught(work, control), lambda result: self._ended(work, result),
            lambda error: self._ended(work, None),
        )  # fmt: skip
        self._work = work
        self.task.on_frame = lambda value: self._pass_on(work, value)

    def _pass_on(self, work: Work, value: Any) -> None:
        """Pass on a frame, unless newer work has taken the place of this work."""
        if self._waiting is None and self.task is not None:
            work.frame(value)

    def _ended(self, work: Work, result: Any) -> None:
        self.task = self._work = None
        if self._waiting is not None:
            self._start(self._waiting)
        else:
            work.done(result)


def _caught(work: Work, control: TaskControl) -> Any:
    """Return the result of work, or the refusal of the library, which the page shows itself instead of a notice."""
    try:
        return work.run(control)
    except StitchMeshError as error:
        return Refused(str(error))
