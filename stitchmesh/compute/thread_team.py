# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Threads that wait for work and share it with the thread that has it.

The threads exist once in a process, because to start a thread takes as long as a small launch. Without work they sleep.
After a fork the child has no threads, so it starts its own at its first work.
"""

from __future__ import annotations

import functools
import os
import threading
from collections.abc import Callable
from queue import SimpleQueue

from stitchmesh.compute.threads import thread_count

Work = Callable[[], object]


class ThreadTeam:
    """A number of threads, of which the calling thread is one."""

    def __init__(self, size: int) -> None:
        """Start ``size`` - 1 threads."""
        self._errors: SimpleQueue[BaseException] = SimpleQueue()
        self._queues: list[SimpleQueue[Work]] = [SimpleQueue() for _ in range(1, size)]
        for number, queue in enumerate(self._queues, start=1):
            threading.Thread(target=self._help, args=[queue], name=f"launches {number}", daemon=True).start()

    def share(self, own: Work, other: Work, threads: int) -> None:
        """Do work in the calling thread, and offer the others a part in it; return when the calling thread is done.

        Args:
            own: what the calling thread does. It does not wait for threads that have not begun, because they may sleep
                for long on a machine with other work.
            other: what up to ``threads`` - 1 other threads do, perhaps late. It returns at once if nothing is left.
            threads: number of threads that the work is enough for.

        Raises:
            BaseException: what ``own`` raises, or else what ``other`` raised, in this call or in one before it.
        """
        for queue in self._queues[: threads - 1]:
            if queue.empty():  # a thread with work of which it has not heard yet comes too late for more
                queue.put(other)
        own()
        if not self._errors.empty():
            raise self._errors.get()

    def _help(self, queue: SimpleQueue[Work]) -> None:
        """Do the work of a queue."""
        while True:
            work = queue.get()
            try:
                work()
            except BaseException as error:
                self._errors.put(error)


_team_of = functools.cache(ThreadTeam)
"""The team of each size that was asked for."""
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_team_of.cache_clear)


def share(own: Work, other: Work, threads: int) -> None:
    """Share work with as many threads as ``thread_count`` says; arguments and errors as for ``ThreadTeam.share``."""
    _team_of(thread_count()).share(own, other, threads)
