# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Work that the user asks for again with each change: only the newest request is done, and earlier ones end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from stitchmesh.app.task import Task, TaskControl, TaskRunner
from stitchmesh.errors import StitchMeshError


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
    progress: Callable[[], object] = lambda: None
    """Called after each report of the work."""


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
        self.task.on_frame = lambda value: self._pass_on(work.frame, value)
        self.task.on_progress = lambda: self._pass_on(work.progress)

    def _pass_on(self, function: Callable[..., object], *values: Any) -> None:
        """Pass on a frame or a report, unless newer work has taken the place of this work."""
        if self._waiting is None and self.task is not None:
            function(*values)

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
