# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A relaxation in the worker thread that the user watches, pauses, steps and stops.

The library's ``RunControl`` does the work. The task provides the worker thread and brings snapshots to the event
thread.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from stitchmesh.app.task import Task, TaskControl, TaskRunner
from stitchmesh.progress import Outlook, Progress, StageClock, relaxing_progress
from stitchmesh.run_control import WATCH_SECONDS, RunControl, Snapshot

S = TypeVar("S")
T = TypeVar("T")
LARGEST_SHARE = 0.05
"""Largest share of its time that the event thread spends on snapshots, because a solver needs the same processor."""

BYTES_PER_SECOND = 5e6
"""Largest number of bytes of snapshots per second; for a slower browser, messages would pile up."""


class LiveRun(Generic[S, T]):
    """One relaxation. All methods belong to the event thread."""

    def __init__(
        self, tasks: TaskRunner, name: str, relax: Callable[[RunControl[S], Progress], T], *, stage: str | None,
        done: Callable[[T], None], failed: Callable[[Exception | None], None], max_iterations: float = float("inf"),
        frame_bytes: int = 0, goal: float | None = None,
    ) -> None:  # fmt: skip
        """Start the relaxation.

        Args:
            tasks: runs the relaxation.
            name: the name of the work, in the words of the user.
            relax: makes the relaxation in the worker thread; it gets the control of the run and the progress to report
                to.
            stage: name of the stage of the library whose progress follows from the residuals; None for work that
                reports its progress itself.
            done: called with the result, even after the user has stopped the relaxation.
            failed: called with an error, or with None if the application has ended the relaxation.
            max_iterations: iterations after which the relaxation ends.
            frame_bytes: approximate size of a snapshot for a browser [bytes]; large snapshots come less often.
            goal: residual near which the relaxation ends; None for its tolerance.

        Raises:
            ParameterError: another task runs.
        """
        self.newest: Snapshot[S] | None = None
        """The newest snapshot."""
        self.history: list[Snapshot[None]] = []
        """The figures of all snapshots."""
        self._outlook, self._clock, self._goal = Outlook(0.0, None), StageClock(), goal
        self.on_snapshot: Callable[[Snapshot[S]], None] | None = None
        """Called with each snapshot."""
        self._least_seconds = max(WATCH_SECONDS, frame_bytes / BYTES_PER_SECOND)
        self._stage, self._max_iterations = stage, max_iterations
        self._report: Callable[..., None] | None = None
        self.control: RunControl[S] = RunControl(self._watch, seconds=self._least_seconds)
        self._task_control: TaskControl | None = None
        self.task: Task[T] = tasks.start(name, lambda control: self._work(control, relax), done, failed)
        self.task.on_frame = self._show
        self.task.on_cancel = self.control.stop

    @property
    def outlook(self) -> Outlook:
        """The completed part, and the remaining time without pauses."""
        return self.task.outlook if self._stage is None else self._outlook

    @property
    def paused(self) -> bool:
        """Whether the relaxation waits, or will wait after its present step."""
        return self.control.paused

    def _work(self, task_control: TaskControl, relax: Callable[[RunControl[S], Progress], T]) -> T:
        self._task_control = task_control
        result = relax(self.control, task_control)
        task_control.check()
        return result

    def _watch(self, snapshot: Snapshot[S]) -> None:
        """Hand a snapshot to the event thread; called in the worker thread."""
        assert self._task_control is not None
        self._task_control.frame(snapshot)

    def _show(self, snapshot: Snapshot[S]) -> None:
        """Keep the figures, show the state, and make snapshots less frequent if that took long."""
        began = time.monotonic()
        self.newest = snapshot
        self._note_progress(snapshot)
        if self.on_snapshot is not None:
            self.on_snapshot(snapshot)
        self.control.seconds = max(self._least_seconds, (time.monotonic() - began) / LARGEST_SHARE)

    def _note_progress(self, snapshot: Snapshot[S]) -> None:
        figures = snapshot.iteration, snapshot.residual, snapshot.tolerance, snapshot.seconds, snapshot.energies
        self.history.append(Snapshot(None, *figures))
        if self._stage is None:
            return
        if self._report is None:
            self._report = relaxing_progress(
                self._stage, self._goal or snapshot.tolerance, self._keep_done, max_iterations=self._max_iterations
            )
        self._report(snapshot.iteration, snapshot.residual)

    def _keep_done(self, stage: str, done: float, note: str) -> None:
        assert self.newest is not None
        self._outlook = self._clock.outlook(self.newest.seconds, done)


AnyRun = LiveRun[Any, Any]
