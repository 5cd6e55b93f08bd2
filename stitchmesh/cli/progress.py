# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Progress reports on standard error: two lines with a bar on a terminal, and a line every few seconds in a file.

A job reports the same bar if standard error is a terminal, and lines of JSON if standard output is not a terminal.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING

from rich.console import Console, RenderableType
from rich.progress import BarColumn, Progress, TextColumn
from rich.text import Text

from stitchmesh.cli.say import printable, say
from stitchmesh.progress import STAGE_TEXTS, StageClock
from stitchmesh.progress import Progress as Report

if TYPE_CHECKING:
    from stitchmesh.jobs.job_status import JobStatus, Listener

LINE_SECONDS = 3.0
"""Shortest time between two lines in a file [s]."""
NEXT_LINE = "\n"
"""Separator of the two lines of a note."""


@contextmanager
def show_progress(console: Console | None = None) -> Iterator[Report]:
    """Provide a progress function that draws on a console; the console is standard error if it is None."""
    console = console or Console(stderr=True)
    if not console.is_terminal:
        yield _Lines(console)
        return
    with _Display(console) as display:
        bar = _Bar(display)
        yield bar
        bar.end_stage()


class _Lines:
    """Progress as a line every few seconds; a command that ends or fails within the first seconds prints no line."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._last_line = self._stage_start = time.monotonic()
        self._stage, self._clock = "", StageClock()

    def __call__(self, stage: str, done: float, note: str) -> None:
        now = time.monotonic()
        if stage != self._stage:
            self._stage, self._stage_start, self._clock = stage, now, StageClock()
        outlook = self._clock.outlook(now - self._stage_start, done)
        since = self._last_line - self._stage_start
        if now - self._last_line < max(LINE_SECONDS, 0.2 * since):  # a night fills no screen
            return
        self._last_line = now
        estimate = f", {outlook.words}" if outlook.words else ""
        line = f"{STAGE_TEXTS.get(stage, stage)}: {outlook.percent}{estimate} ({note.replace(NEXT_LINE, '; ')})"
        self._console.print(printable(line), highlight=False, markup=False, soft_wrap=True)


class _Display(Progress):
    """Lines on a terminal: stage, bar and note, and optionally a second line. Both lines are removed at the end."""

    def __init__(self, console: Console) -> None:
        self.second_line = ""
        name, words = (TextColumn(f"{{task.{text}}}", markup=False) for text in ("description", "fields[words]"))
        columns = (name, BarColumn(bar_width=12), words)
        super().__init__(*columns, console=console, transient=True)

    def get_renderables(self) -> Iterator[RenderableType]:
        """Yield the lines to draw."""
        yield self.make_tasks_table(self.tasks)
        if self.second_line:
            yield Text(self.second_line)


class _Bar:
    """Progress as a bar of the current stage; a line with the duration of each completed stage remains."""

    def __init__(self, display: _Display) -> None:
        self._display = display
        self._task = display.add_task("", total=1.0, words="")
        self._stage, self._start, self._clock = "", time.monotonic(), StageClock()

    def __call__(self, stage: str, done: float, note: str) -> None:
        if stage != self._stage:
            self.end_stage()
            self._stage, self._start, self._clock = stage, time.monotonic(), StageClock()
            self._display.reset(self._task, total=1.0, description=STAGE_TEXTS.get(stage, stage))
        outlook = self._clock.outlook(time.monotonic() - self._start, done)
        estimate = f"{outlook.words}, " if outlook.words else ""
        first_line, _, self._display.second_line = printable(note).partition(NEXT_LINE)
        self._display.update(self._task, completed=outlook.part, words=estimate + first_line)

    def end_stage(self) -> None:
        """Print the duration of the current stage."""
        if self._stage:
            line = f"{STAGE_TEXTS.get(self._stage, self._stage)}: {time.monotonic() - self._start:.1f} s"
            self._display.console.print(printable(line), highlight=False, markup=False)


@contextmanager
def show_reports() -> Iterator[Listener]:
    """Provide the listener of a job."""
    with ExitStack() as stack:
        listeners: list[Listener] = []
        if sys.stderr.isatty():
            bar = stack.enter_context(show_progress())
            listeners.append(lambda status: bar(status.stage, status.done, status.note) if status.stage else None)
        if not sys.stdout.isatty():
            listeners.append(_JsonLines())
        yield partial(_call_all, listeners)


def _call_all(listeners: Sequence[Listener], status: JobStatus) -> None:
    for listener in listeners:
        listener(status)


class _JsonLines:
    """A line of JSON when a stage begins or ends, when the job ends, and every few seconds."""

    def __init__(self) -> None:
        self._event: tuple[object, ...] = ()
        self._printed = 0.0

    def __call__(self, status: JobStatus) -> None:
        """Print a report, unless one of the same stage was printed just now."""
        event, now = (status.state, status.stage, len(status.stages)), time.monotonic()
        if event == self._event and now - self._printed < LINE_SECONDS:
            return
        self._event, self._printed = event, now
        entry = asdict(status)
        entry["stages"] = [stage["name"] for stage in entry["stages"]]
        say(json.dumps(entry), flush=True)
