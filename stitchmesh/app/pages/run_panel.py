# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls of a relaxation that runs: pause, step, stop, and how far it is."""

from __future__ import annotations

from collections.abc import Callable

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.live_run import AnyRun
from stitchmesh.markup import Markup, markup
from stitchmesh.reporting.figures import duration

PAUSE, RESUME = "Pause", "Resume"
"""Labels of the button that pauses a relaxation and lets it go on."""


class RunPanel:
    """Controls that are shown while a relaxation runs."""

    def __init__(
        self, controls: Controls, step: str, words: Callable[[AnyRun], str] | None = None
    ) -> None:  # fmt: skip
        """Make the controls, hidden.

        Args:
            controls: where they stand.
            step: what one step of the relaxation is, for the hint.
            words: says how far a run is; ``status_of`` by default.
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
        """Show how far the relaxation is."""
        if self._run is None:
            return
        self._pause.label = RESUME if self._run.paused else PAUSE
        self._bar.value = round(100.0 * self._run.outlook.part, 1)
        self._status.content = markup('<p role="status" style="margin:0">{}</p>', self._words(self._run))

    def toggle_pause(self) -> None:
        """Pause the relaxation, or let it go on."""
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
