# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Progress on the terminal: a bar and a remaining time where it is one, a line now and then where it is a file."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from stitchmesh.pipeline import Progress as Report

STAGES = {
    "label": "labeling rows",
    "tessellate": "tessellating",
    "meshrelax": "evening out stitches",
    "yarngen": "generating yarns",
    "yarnrelax": "relaxing yarns",
}

LINE_SECONDS = 3.0
"""Time between two lines."""


@contextmanager
def on_terminal() -> Iterator[Report]:
    """A progress report that draws on standard error."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _Lines(console)
        return
    columns = (
        TextColumn("{task.description:<22}"),
        BarColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}"),
    )
    with Progress(*columns, console=console) as bars:
        yield _Bars(bars)


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
        left = f", about {(now - self._began) * (1.0 - done) / done:.0f} s left" if 0.05 < done < 1.0 else ""
        line = f"{STAGES.get(stage, stage)}: {done:.0%}{left} ({note})"
        self._console.print(line, highlight=False, soft_wrap=True)


class _Bars:
    """A bar for each stage; a stage that has been followed by another is done."""

    def __init__(self, bars: Progress) -> None:
        self._bars = bars
        self._task: dict[str, TaskID] = {}

    def __call__(self, stage: str, done: float, note: str) -> None:
        if stage not in self._task:
            for task in self._task.values():
                self._bars.update(task, completed=1.0)
            self._task[stage] = self._bars.add_task(STAGES.get(stage, stage), total=1.0, note=note)
        current = self._bars.tasks[self._task[stage]].completed
        self._bars.update(self._task[stage], completed=max(done, current), note=note)
