# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Progress on the terminal: a bar and a remaining time where it is one, a line a stage where it is a file."""

from __future__ import annotations

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
    """One line when a stage begins and one for every further tenth of it."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._tenths: dict[str, int] = {}

    def __call__(self, stage: str, done: float, note: str) -> None:
        tenth = int(done * 10)
        if tenth > self._tenths.get(stage, -1):
            self._tenths[stage] = tenth
            self._console.print(f"{STAGES.get(stage, stage)}: {tenth * 10}% ({note})", highlight=False, soft_wrap=True)


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
