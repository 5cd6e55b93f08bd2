# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxations that the user of a page watches, pauses, steps and stops, with their controls.

The library has the means in ``RunControl``; the task provides the worker thread and brings snapshots to the event
thread. A run continues unseen while another page is open.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from stitchmesh.app.controls.html_pieces import status_line
from stitchmesh.app.task import Task, TaskControl, TaskRunner
from stitchmesh.markup import Markup
from stitchmesh.mesh import StitchMesh
from stitchmesh.pipeline.garment import Garment
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.progress import Outlook, Progress, StageClock, relaxing_progress
from stitchmesh.reporting.figures import duration
from stitchmesh.run_control import WATCH_SECONDS, RunControl, Snapshot
from stitchmesh.yarn import YarnSet

if TYPE_CHECKING:
    from stitchmesh.app.pages.page import Page
    from stitchmesh.app.project.project import Project

S = TypeVar("S")
T = TypeVar("T")
LARGEST_SHARE = 0.05
"""Largest share of its time that the event thread spends on snapshots, because a solver needs the same processor."""

BYTES_PER_SECOND = 5e6
"""Largest number of bytes of snapshots per second; for a slower browser, messages would pile up."""


@dataclass(frozen=True, kw_only=True)
class WatchedWork(Generic[S, T]):
    """A relaxation in the worker thread."""

    name: str
    """The name of the work, in the words of the user."""
    relax: Callable[[RunControl[S], Progress], T]
    """Makes the relaxation; it gets the control of the run and the progress to report to."""
    stage: str | None
    """Name of the stage of the library whose progress follows from the residuals; None for work that reports its
    progress itself."""
    max_iterations: float = float("inf")
    """Iterations after which the relaxation ends."""
    frame_bytes: int = 0
    """Approximate size of a snapshot for a browser [bytes]; large snapshots come less often."""
    goal: float | None = None
    """Residual near which the relaxation ends; None for its tolerance."""


class LiveRun(Generic[S, T]):
    """One relaxation. All methods belong to the event thread."""

    def __init__(
        self, tasks: TaskRunner, watched: WatchedWork[S, T], done: Callable[[T], None],
        failed: Callable[[Exception | None], None],
    ) -> None:  # fmt: skip
        """Start the relaxation.

        Args:
            tasks: runs the relaxation.
            watched: the relaxation.
            done: called with the result, even after the user has stopped the relaxation.
            failed: called with an error, or with None if the application has ended the relaxation.

        Raises:
            ParameterError: another task runs.
        """
        self.newest: Snapshot[S] | None = None
        """The newest snapshot."""
        self.history: list[Snapshot[None]] = []
        """The figures of all snapshots."""
        self.on_snapshot: Callable[[Snapshot[S]], None] | None = None
        """Called with each snapshot."""
        self._watched, self._outlook, self._clock = watched, Outlook(0.0, None), StageClock()
        self._least_seconds = max(WATCH_SECONDS, watched.frame_bytes / BYTES_PER_SECOND)
        self._report: Callable[..., None] | None = None
        self.control: RunControl[S] = RunControl(self._watch, seconds=self._least_seconds)
        self._task_control: TaskControl | None = None
        self.task: Task[T] = tasks.start(watched.name, self._work, done, failed)
        self.task.on_frame = self._show
        self.task.on_cancel = self.control.stop

    @property
    def outlook(self) -> Outlook:
        """The completed part, and the remaining time without pauses."""
        return self.task.outlook if self._watched.stage is None else self._outlook

    @property
    def paused(self) -> bool:
        """Whether the relaxation waits, or will wait after its present step."""
        return self.control.paused

    def _work(self, task_control: TaskControl) -> T:
        self._task_control = task_control
        result = self._watched.relax(self.control, task_control)
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
        watched = self._watched
        if watched.stage is None:
            return
        if self._report is None:
            goal = watched.goal or snapshot.tolerance
            self._report = relaxing_progress(
                watched.stage, goal, self._keep_done, max_iterations=watched.max_iterations
            )
        self._report(snapshot.iteration, snapshot.residual)

    def _keep_done(self, stage: str, done: float, note: str) -> None:
        assert self.newest is not None
        self._outlook = self._clock.outlook(self.newest.seconds, done)


AnyRun = LiveRun[Any, Any]


BYTES_PER_STITCH = 120
"""Size of a frame of stitches for each stitch: two triangles and two sides."""
STALE = "The stitches or the yarns were changed meanwhile, so the result of the work was left out. Start it again."


class PageRun(Generic[S, T]):
    """At most one run of a page, with its controls. All methods belong to the event thread."""

    def __init__(self, page: Page, shown: Callable[[Snapshot[S]], object], ended: Callable[[], object]) -> None:
        """Run nothing yet; ``shown`` gets each snapshot while the page is open, ``ended`` is called after each run."""
        self._page, self._shown, self._ended = page, shown, ended
        self.live: LiveRun[S, T] | None = None
        """The run; None while nothing runs."""

    def build(self, step: str, words: Callable[[AnyRun], str] | None = None) -> None:
        """Make the controls of the open page, which are visible while something runs.

        Args:
            step: the name of one step of the work, for the hint.
            words: returns how far a run is, in words; ``status_of`` by default.
        """
        controls, self._words = self._page.app.controls, words or status_of
        self._pause = controls.button("Pause", "Wait after the present step, or go on (key P)", self._toggle_pause)
        self._step = controls.button("Step", f"Make one step and wait: {step} (key N)", self._make_step)
        self._stop = controls.button("Stop", "End now and keep the state that is shown", self._end_now)
        self._bar = controls.progress_bar()
        self._status = controls.html(Markup())
        controls.key("Pause or resume", "Pause the relaxation, or let it go on", "P", None, self._toggle_pause)
        controls.key("Step", "Make one step of the relaxation", "N", None, self._make_step)
        if self.live is not None:
            self.live.on_snapshot = self._show
        self.refresh()

    def leave(self) -> None:
        """Let the run go on unseen."""
        if self.live is not None:
            self.live.on_snapshot = None

    def start(self, watched: WatchedWork[S, T], done: Callable[[T], object]) -> None:
        """Start a run; ``done`` is called with its result.

        Raises:
            ParameterError: another task runs.
        """

        def end(result: T) -> None:
            self.live = None
            done(result)
            self._ended()

        def fail(error: Exception | None) -> None:
            self.live = None
            self._ended()

        self.live = LiveRun(self._page.app.tasks, watched, end, fail)
        self.live.on_snapshot = self._show

    def refresh(self) -> None:
        """Show the controls on the open page if something runs."""
        for control in (self._pause, self._step, self._stop, self._bar, self._status):
            control.visible = self.live is not None
        self._show_progress()

    def _show(self, snapshot: Snapshot[S]) -> None:
        self._shown(snapshot)
        self._show_progress()

    def _show_progress(self) -> None:
        if self.live is None:
            return
        self._pause.label = "Resume" if self.live.paused else "Pause"
        self._bar.value = round(100.0 * self.live.outlook.part, 1)
        self._status.content = status_line(self._words(self.live))

    def _toggle_pause(self) -> None:
        if self.live is not None:
            control = self.live.control
            control.resume() if control.paused else control.pause()
            self._show_progress()

    def _make_step(self) -> None:
        if self.live is not None:
            self.live.control.step()
            self._show_progress()

    def _end_now(self) -> None:
        """End the run with its last good state."""
        if self.live is not None:
            self.live.control.stop()


def garment_of(project: Project, fabric: StitchMesh, options: KnitOptions) -> Garment:
    """Return the garment of a project before one of its next stages: its mesh, a fabric, and its yarns."""
    mesh = (project.mesh if project.shaping is None else project.surface) or fabric
    values: dict[type, Any] = {StitchMesh: fabric}
    if project.yarns is not None:
        values[YarnSet] = project.yarns
    return Garment(mesh=mesh, options=options, values=values)


def is_wanted(page: Page, project: Project, unchanged: bool) -> bool:
    """Return whether a result belongs to the open project and its present input; if the input has changed, say so."""
    open_now = page.app.project is project
    if open_now and not unchanged:
        page.app.notice(STALE, "warning")
    return open_now and unchanged


def status_of(run: AnyRun) -> str:
    """Return how far a relaxation is, in words."""
    if run.newest is None:
        return "Preparing."
    now = run.newest
    return progress_words(run, f"iteration {now.iteration:,}, residual {now.residual:.2g} (done at {now.tolerance:g})")


def progress_words(run: AnyRun, progress: str) -> str:
    """Return a sentence on a run that has a state: its progress, its time, and the time that is left."""
    assert run.newest is not None
    state = "Paused" if run.paused else "Running"
    left = "" if run.paused else run.outlook.words
    remaining = f" {left[0].upper()}{left[1:]}." if left else ""
    return f"{state}: {progress}, {duration(run.newest.seconds)}.{remaining}"
