# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cases that run in processes of their own: for their memory, for a limit of their time, or some at a time."""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, Generic, TypeVar

Case = TypeVar("Case")
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "STITCHMESH_THREADS": "1"}
"""Environment of processes of which some run at a time."""
LOOK = 0.05
"""Time between two looks at the running processes [s]."""


@dataclass
class _Running(Generic[Case]):
    """A process, and what it has sent."""

    case: Case
    process: BaseProcess
    connection: Connection
    since: float = field(default_factory=time.perf_counter)
    found: list[Any] = field(default_factory=list)

    def receive(self) -> None:
        """Take what the process has sent."""
        try:
            while self.connection.poll():
                self.found.append(self.connection.recv())
        except EOFError:
            pass


def results_of(
    work: Callable[[Case], Iterable[Any]],
    cases: Sequence[Case],
    *,
    processes: int | None = None,
    limit: float = float("inf"),
    seconds: float = float("inf"),
) -> Iterator[tuple[Case, list[Any], str]]:
    """Run a generator function of each case in a process of its own, and yield what it yields when it ends.

    Args:
        work: a function of a module, whose results can be pickled.
        cases: its arguments.
        processes: how many run at a time, each with one thread; by default one with all threads.
        limit: time after which a process is ended [s].
        seconds: time after which all are ended, and no further one begins [s].

    Yields:
        The case, what it has yielded, and why it has not ended by itself; an empty text if it has.
    """
    context = multiprocessing.get_context("spawn")
    waiting, running = list(cases)[::-1], list[_Running[Case]]()
    began = time.perf_counter()
    if processes is not None:
        os.environ.update(ONE_THREAD)  # Processes take over the environment when they start.
    while waiting or running:
        over = time.perf_counter() - began > seconds
        if over:
            waiting.clear()
        while waiting and len(running) < (processes or 1):
            case = waiting.pop()
            here, there = context.Pipe(duplex=False)
            process = context.Process(target=_send, args=(work, case, there))
            process.start()
            there.close()
            running.append(_Running(case, process, here))
        wait([one.process.sentinel for one in running], LOOK)
        for one in list(running):
            one.receive()
            spent = time.perf_counter() - one.since
            if one.process.is_alive() and not over and spent < limit:
                continue
            late = one.process.is_alive()
            one.process.kill()
            one.process.join()
            one.receive()
            running.remove(one)
            status = f"status {one.process.exitcode}" if one.process.exitcode else ""
            yield one.case, one.found, f"ended after {spent:.0f} s" if late else status


def _send(work: Callable[[Any], Iterable[Any]], case: Any, connection: Connection) -> None:
    for result in work(case):
        connection.send(result)
