# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A run that a page starts and shows, with its controls; it continues unseen while another page is open."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Generic, TypeVar

from stitchmesh.app.live_run import AnyRun, LiveRun
from stitchmesh.markup import Markup, markup
from stitchmesh.progress import Progress
from stitchmesh.reporting.figures import duration
from stitchmesh.run_control import RunControl, Snapshot

if TYPE_CHECKING:
    from stitchmesh.app.pages.page import Page
    from stitchmesh.app.project.project import Project

S = TypeVar("S")
T = TypeVar("T")
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

    def start(
        self, name: str, work: Callable[[RunControl[S], Progress], T], done: Callable[[T], object], *,
        stage: str | None, max_iterations: float = float("inf"), frame_bytes: int = 0, goal: float | None = None,
    ) -> None:  # fmt: skip
        """Start a run; ``LiveRun`` describes the other arguments.

        Args:
            name: the name of the work, in the words of the user.
            work: the work, in the worker thread.
            done: called with the result.
            stage: name of the stage of the library whose progress follows from the residuals; None for work that
                reports its progress itself.
            max_iterations: iterations after which the relaxation ends.
            frame_bytes: approximate size of a snapshot for a browser [bytes].
            goal: residual near which the relaxation ends; None for its tolerance.

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

        self.live = LiveRun(
            self._page.app.tasks, name, work, stage=stage, done=end, failed=fail, max_iterations=max_iterations,
            frame_bytes=frame_bytes, goal=goal,
        )  # fmt: skip
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
        self._status.content = markup('<p role="status" style="margin:0">{}</p>', self._words(self.live))

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
