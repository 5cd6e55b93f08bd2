# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Threads that wait for work, and share it with the thread that offers it.

The threads are started once in a process, because starting a thread takes as long as a small launch. They sleep while
there is no work. After a fork the child process has no threads, and starts its own when it first has work.
"""

from __future__ import annotations

import functools
import os
import threading
from collections.abc import Callable
from queue import SimpleQueue

from stitchmesh.compute.threads import thread_count

Work = Callable[[int], object]
"""Work that threads share. It is called with the number of the thread; the thread that offers the work has number 0."""


class ThreadTeam:
    """A number of threads, of which the calling thread is one."""

    def __init__(self, size: int) -> None:
        """Start ``size`` - 1 threads."""
        self._offered: tuple[Work, int] = (_nothing, 0)
        self._errors: SimpleQueue[BaseException] = SimpleQueue()
        self._calls: list[SimpleQueue[None]] = [SimpleQueue() for _ in range(1, size)]
        for thread in range(1, size):
            threading.Thread(target=self._help, args=[thread], name=f"launches {thread}", daemon=True).start()

    def share(self, work: Work, threads: int) -> None:
        """Do work, and offer it to other threads; return when the calling thread is done.

        Args:
            work: what each thread does. The calling thread does not wait for threads that have not begun, because they
                may sleep for long on a busy machine. Threads that come too late must find nothing left to do.
            threads: number of threads that the work keeps busy.

        Raises:
            BaseException: the work raised it here, or else in another thread, in this call or in an earlier one.
        """
        if threads > 1:
            self._offered = work, threads
        for calls in self._calls[: threads - 1]:
            if calls.empty():  # otherwise the thread has not heard the last call yet
                calls.put(None)
        work(0)
        if not self._errors.empty():
            raise self._errors.get()

    def _help(self, thread: int) -> None:
        """Do the work that was offered last, at each call."""
        calls = self._calls[thread - 1]
        while True:
            calls.get()
            work, threads = self._offered
            if thread >= threads:  # the call was for other work, which is done
                continue
            try:
                work(thread)
            except BaseException as error:
                self._errors.put(error)


def _nothing(_thread: int) -> None:
    """Do nothing; it stands for the work before the first work is offered."""


_team_of = functools.cache(ThreadTeam)
"""Return the team of a size; each team is made once."""
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_team_of.cache_clear)


def share(work: Work, threads: int) -> None:
    """Share work among at most ``thread_count()`` threads; ``ThreadTeam.share`` says what the arguments are."""
    _team_of(thread_count()).share(work, threads)
