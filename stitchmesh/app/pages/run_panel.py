# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A run that a page starts and shows, with its controls; it continues unseen while another page is open."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Generic, TypeVar

from stitchmesh.app.controls.controls import Controls
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
PAUSE, RESUME = "Pause", "Resume"
"""Labels of the button that pauses and resumes a relaxation."""
STALE = "The stitches or the yarns were changed meanwhile, so the result of the work was left out. Start it again."


class RunPanel:
    """Controls that are visible while a relaxation runs."""

    def __init__(self, controls: Controls, step: str, words: Callable[[AnyRun], str] | None = None) -> None:
        """Make the controls, hidden.

        Args:
            controls: where they stand.
            step: the name of one step of the relaxation, for the hint.
            words: returns how far a run is, in words; ``status_of`` by default.
        """
        self._words = words or status_of
        self._run: AnyRun | None = None
        self._pause = controls.button(PAUSE, "Wait after the present step, or go on (key P)", self.toggle_pause)
        self._step = controls.button("Step", f"Make one step and wait: {step} (key N)", self.step)
        self._stop = controls.button("Stop", "End now and keep the state that is shown", self.stop)
        self._bar = controls.progress_bar()
        self._status = controls.html(Markup())
        controls.key("Pause or resume", "Pause the relaxation, or let it go on", "P", None, self.toggle_pause)
        controls.key("Step", "Make one step of the relaxation", "N", None, self.step)
        self.show(None)

    def show(self, run: AnyRun | None) -> None:
        """Show the controls of a relaxation; None hides them."""
        self._run = run
        for control in (self._pause, self._step, self._stop, self._bar, self._status):
            control.visible = run is not None
        self.update()

    def update(self) -> None:
        """Show the progress of the relaxation."""
        if self._run is None:
            return
        self._pause.label = RESUME if self._run.paused else PAUSE
        self._bar.value = round(100.0 * self._run.outlook.part, 1)
        self._status.content = markup('<p role="status" style="margin:0">{}</p>', self._words(self._run))

    def toggle_pause(self) -> None:
        """Pause or resume the relaxation."""
        if self._run is not None:
            control = self._run.control
            control.resume() if control.paused else control.pause()
            self.update()

    def step(self) -> None:
        """Make one step."""
        if self._run is not None:
            self._run.control.step()
            self.update()

    def stop(self) -> None:
        """End the relaxation with its last good state."""
        if self._run is not None:
            self._run.control.stop()


class PageRun(Generic[S, T]):
    """At most one run of a page, with its controls. All methods belong to the event thread."""

    def __init__(self, page: Page, shown: Callable[[Snapshot[S]], object], ended: Callable[[], object]) -> None:
        """Run nothing yet.

        Args:
            page: the page.
            shown: called with each snapshot while the page is open.
            ended: called after each run has ended and handed over its result.
        """
        self._page, self._shown, self._ended = page, shown, ended
        self._panel: RunPanel | None = None
        self.live: LiveRun[S, T] | None = None
        """The run; None while nothing runs."""

    def build(self, step: str, words: Callable[[AnyRun], str] | None = None) -> None:
        """Make the controls of the open page, and show the run in them; see ``RunPanel``."""
        self._panel = RunPanel(self._page.app.controls, step, words)
        if self.live is not None:
            self.live.on_snapshot = self._show

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
        """Show the controls if something runs."""
        if self._panel is not None:
            self._panel.show(self.live)

    def _show(self, snapshot: Snapshot[S]) -> None:
        self._shown(snapshot)
        if self._panel is not None:
            self._panel.update()


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
    state = "Paused" if run.paused else "Running"
    left = run.outlook.words
    remaining = f" {left[0].upper()}{left[1:]}." if left and not run.paused else ""
    residual = f"residual {now.residual:.2g} (done at {now.tolerance:g})"
    return f"{state}: iteration {now.iteration:,}, {residual}, {duration(now.seconds)}.{remaining}"
