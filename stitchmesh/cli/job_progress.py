# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Reports of a job: a bar if standard error is a terminal, and lines of JSON if standard output is not a terminal."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING

from stitchmesh.cli.progress import LINE_SECONDS, show_progress
from stitchmesh.cli.say import say

if TYPE_CHECKING:
    from stitchmesh.jobs.job_status import JobStatus, Listener


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
