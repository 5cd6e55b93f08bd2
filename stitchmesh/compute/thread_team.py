# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Threads that wait for work and share it with the thread that has it.

The threads exist once in a process, because to start a thread takes as long as a small launch. Between two pieces of
work they sleep. After a fork the child has no threads, so it starts its own at its first work.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable

from stitchmesh.compute.threads import thread_count

Work = Callable[[], None]
"""Work that several threads share: each takes what is left, and returns where nothing is left or the work is done."""


class ThreadTeam:
    """A number of threads, with the calling thread as one of them."""

    def __init__(self, size: int) -> None:
        """Start ``size`` - 1 threads."""
        self.size = size
        self._lock = threading.Lock()
        self._wake, self._left = threading.Condition(self._lock), threading.Condition(self._lock)
        self._work: Work | None = None
        self._number, self._inside, self._closed = 0, 0, False
        self._errors: list[BaseException] = []
        for number in range(1, size):
            threading.Thread(target=self._help, name=f"launches {number}", daemon=True).start()

    def share(self, work: Work) -> None:
        """Do work together; return when it is done and no thread is in it any more.

        The calling thread begins at once and does not wait for threads that have not yet woken up. If another thread
        is sharing its work at the same time, the calling thread works alone.

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

    def close(self) -> None:
        """End the threads."""
        with self._lock:
            self._closed = True
            self._wake.notify_all()

    def _offer(self, work: Work) -> bool:
        """Wake the threads for work, unless they have other work."""
        with self._lock:
            if self._work is not None or self._inside or self.size == 1:
                return False
            self._work, self._number = work, self._number + 1
            self._wake.notify_all()
        return True

    def _withdraw(self) -> list[BaseException]:
        """Let no further thread begin, and wait for those within; an interrupt is raised after them."""
        errors: list[BaseException] = []
        with self._lock:
            self._work = None
            while self._inside:
                try:
                    self._left.wait()
                except BaseException as interrupt:
                    errors.append(interrupt)
            found, self._errors = self._errors, []
        return errors + found

    def _help(self) -> None:
        """Do every work that is offered, once, until the team is closed."""
        done = 0
        while True:
            with self._lock:
                while not self._closed and (self._work is None or self._number == done):
                    self._wake.wait()
                if self._closed:
                    return
                work, done = self._work, self._number
                self._inside += 1
            error = _raised(work)
            with self._lock:
                self._inside -= 1
                if error is not None:
                    self._errors.append(error)
                if not self._inside:
                    self._left.notify()


def _raised(work: Work | None) -> BaseException | None:
    """What work raises, or None."""
    try:
        if work is not None:
            work()
    except BaseException as error:
        return error
    return None


_team: ThreadTeam | None = None


def share(work: Work) -> None:
    """Do work with as many threads as ``thread_count`` says."""
    global _team
    if _team is None or _team.size != thread_count():
        if _team is not None:
            _team.close()
        _team = ThreadTeam(thread_count())
    _team.share(work)


def _forget_team() -> None:
    """Forget the threads of the parent process."""
    global _team
    _team = None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_team)
