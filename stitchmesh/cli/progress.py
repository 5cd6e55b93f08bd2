# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Progress on standard error: on a terminal the stage under way in two lines, in a file a line now and then.

What is left is what the stage has taken so far times the
part that is still to do over the part that is done.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta

from rich.console import Console, RenderableType
from rich.progress import BarColumn, Progress, TextColumn
from rich.text import Text

from stitchmesh.pipeline import Progress as Report

STAGES = {
    "label": "labeling rows",
    "tessellate": "tessellating",
    "pattern": "laying the pattern",
    "meshrelax": "evening out stitches",
    "yarngen": "generating yarns",
    "yarnrelax": "relaxing yarns",
}

LINE_SECONDS = 3.0
"""Time between two lines."""
TOO_EARLY = 0.05
"""Part done below which nobody can tell what is left."""
NEXT_LINE = "\n"
"""Between the two lines of a note."""


@contextmanager
def on_terminal(console: Console | None = None) -> Iterator[Report]:
    """A progress report that is drawn on a console, standard error unless given."""
    console = console or Console(stderr=True)
    if not console.is_terminal:
        yield _Lines(console)
        return
    with _Display(console) as display:
        bar = _Bar(display)
        yield bar
        bar.end_stage()


def seconds_left(spent: float, done: float) -> float | None:
    """Time that a stage still takes [s], if it goes on as it went; None where that cannot be told."""
    return spent * (1.0 - done) / done if TOO_EARLY < done < 1.0 else None


class _Lines:
    """A line every few seconds; what is done sooner, a refusal of bad input among it, is told by nobody."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._told = self._began = time.monotonic()
        self._stage = ""

    def __call__(self, stage: str, done: float, note: str) -> None:
        now = time.monotonic()
        if stage != self._stage:
            self._stage, self._began = stage, now
        if now - self._told < LINE_SECONDS:
            return
        self._told = now
        left = seconds_left(now - self._began, done)
        about = "" if left is None else f", about {left:.0f} s left"
        line = f"{STAGES.get(stage, stage)}: {done:.0%}{about} ({note.replace(NEXT_LINE, '; ')})"
        self._console.print(line, highlight=False, soft_wrap=True)


class _Display(Progress):
    """A bar between what is going on and how it goes, and perhaps a line below; both vanish at the end."""

    def __init__(self, console: Console) -> None:
        self.below = ""
        columns = (TextColumn("{task.description}"), BarColumn(bar_width=12), TextColumn("{task.fields[words]}"))
        super().__init__(*columns, console=console, transient=True)

    def get_renderables(self) -> Iterator[RenderableType]:
        """The two lines."""
        yield self.make_tasks_table(self.tasks)
        if self.below:
            yield Text(self.below)


class _Bar:
    """The bar of the stage under way; a stage that has ended leaves a line with its time."""

    def __init__(self, display: _Display) -> None:
        self._display = display
        self._task = display.add_task("", total=1.0, words="")
        self._stage, self._began, self._done = "", time.monotonic(), 0.0

    def __call__(self, stage: str, done: float, note: str) -> None:
        if stage != self._stage:
            self.end_stage()
            self._stage, self._began, self._done = stage, time.monotonic(), 0.0
            self._display.reset(self._task, total=1.0, description=STAGES.get(stage, stage))
        self._done = max(done, self._done)
        left = seconds_left(time.monotonic() - self._began, self._done)
        about = "" if left is None else f"about {timedelta(seconds=round(left))} left, "
        beside, _, self._display.below = note.partition(NEXT_LINE)
        self._display.update(self._task, completed=self._done, words=about + beside)

    def end_stage(self) -> None:
        """Say how long the stage took."""
        if self._stage:
            line = f"{STAGES.get(self._stage, self._stage)}: {time.monotonic() - self._began:.1f} s"
            self._display.console.print(line, highlight=False)
