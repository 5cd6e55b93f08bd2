# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls of a run of mixed yarns and triangles: its frames, and what of the yarns is drawn."""

from __future__ import annotations

from collections.abc import Callable

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.pages.view.draped_view import DrapedView
from stitchmesh.mixed.drape import Draped

NEWEST = 100.0
"""Place of the newest frame on the slider [%]."""
BACK, ON, LAST = "Frame before", "Next frame", "Newest"
"""Labels of the buttons."""


class FramePanel:
    """Chooses a frame; at the end of the slider the newest frame is shown, also of a run that goes on."""

    def __init__(self, controls: Controls, changed: Callable[[], object]) -> None:
        """Make the controls, hidden; ``changed`` is called when something else is to be drawn."""
        self._draped: Draped | None = None
        self._changed = changed
        self._moment = controls.slider(
            "Moment", "Part of the frames of the run [%]; at 100 the newest frame is followed.", NEWEST,
            lambda _: self._changed(), least=0.0, most=NEWEST, step=0.5,
        )  # fmt: skip
        self._steps = controls.buttons("Frames", "One frame back or on, or the newest.", (BACK, ON, LAST), self._step)
        self._everywhere = controls.toggle(
            "Yarns everywhere", "Draw all yarns and no triangles.", False, lambda _: self._changed()
        )
        self.show(None)

    @property
    def frame(self) -> int:
        """Number of the chosen frame."""
        count = 1 if self._draped is None else len(self._draped.frames)
        return min(round(float(self._moment.value) / NEWEST * (count - 1)), count - 1)

    def show(self, draped: Draped | None) -> None:
        """Show the controls that a run needs; None hides them."""
        self._draped = draped
        many = draped is not None and len(draped.frames) > 1
        self._moment.visible = self._steps.visible = many
        self._everywhere.visible = draped is not None

    def view(self, draped: Draped, before: object = None) -> DrapedView:
        """Return the view of the chosen frame of a run, which is shown from now on."""
        self.show(draped)
        return DrapedView(draped, before, frame=self.frame, everywhere=bool(self._everywhere.value))

    def _step(self, which: str) -> None:
        if self._draped is None:
            return
        last = len(self._draped.frames) - 1
        frame = {BACK: self.frame - 1, ON: self.frame + 1, LAST: last}[which]
        self._moment.value = NEWEST * min(max(frame, 0), last) / max(last, 1)
        self._changed()
