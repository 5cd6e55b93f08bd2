# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Threads that wait for work and share it with the thread that has it.

The threads exist once in a process, because to start a thread takes as long as a small launch. Between two pieces of
work they sleep. After a fork the child has no threads, so it starts its own at its first work.
"""

from __future__ import annotations

import functools
import os
import threading
from collections.abc import Callable

from stitchmesh.compute.threads import thread_count

Work = Callable[[], None]
"""Work that several threads share: each takes what is left, and returns where nothing is left or the work is done."""


class ThreadTeam:
    """A number of threads, of which the calling thread is one."""

    def __init__(self, size: int) -> None:
        """Start ``size`` - 1 threads."""
        self._lock = threading.Lock()
        self._wake, self._left = threading.Condition(self._lock), threading.Condition(self._lock)
        self._work: Work | None = None
        self._number, self._inside = 0, 0
        self._errors: list[BaseException] = []
        for number in range(1, size):
            threading.Thread(target=self._help, name=f"launches {number}", daemon=True).start()

    def share(self, work: Work) -> None:
        """Do work together; return when it is done and no other thread is in it.

        The calling thread begins at once, without waiting until the others are awake. It works alone if the others have
        work already, because another thread called this function.

        Raises:
            BaseException: what the work raised in one of the threads.
        """
        if not self._offer(work):
            work()
            return
        try:
            work()
        finally:
            errors = self._withdraw()
        if errors:
            raise errors[0]

    def _offer(self, work: Work) -> bool:
        """Wake the others for work, unless they have work."""
        with self._lock:
            if self._work is not None or self._inside:
                return False
            self._work, self._number = work, self._number + 1
            self._wake.notify_all()
        return True

    def _withdraw(self) -> list[BaseException]:
        """Let no thread begin any more, and wait for those within; also an interrupt must wait for them."""
        interrupts: list[BaseException] = []
        with self._lock:
            self._work = None
            while self._inside:
                try:
                    self._left.wait()
                except BaseException as interrupt:
                    interrupts.append(interrupt)
            errors, self._errors = self._errors, []
        return interrupts + errors

    def _help(self) -> None:
        """Take part in all work that is offered, once in each."""
        done = 0
        while True:
            with self._lock:
                while self._work is None or self._number == done:
                    self._wake.wait()
                work, done = self._work, self._number
                self._inside += 1
            error = _raised_by(work)
            with self._lock:
                self._inside -= 1
                self._errors += error
                if not self._inside:
                    self._left.notify()


def _raised_by(work: Work) -> list[BaseException]:
    """Do work; return what it raises."""
    try:
        work()
    except BaseException as error:
        return [error]
    return []


_team_of = functools.cache(ThreadTeam)
"""The team of each size that was asked for; threads that sleep cost nothing."""
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_team_of.cache_clear)


def share(work: Work) -> None:
    """Do work with as many threads as ``thread_count`` says."""
    _team_of(thread_count()).share(work)
