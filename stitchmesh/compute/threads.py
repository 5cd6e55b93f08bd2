# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The threads that share the launches of kernels on a CPU, and the work on long arrays.

Results do not depend on the number of threads. The number is the argument of ``set_threads``, else the value of the
environment variable ``STITCHMESH_THREADS``, else the number of cores that the process may use.

``each_block`` shares the work of NumPy on long arrays in the same number of threads.

The threads of launches wait for work, and share it with the thread that offers it. They are started once in a process,
because starting a thread takes as long as a small launch. They sleep while there is no work. After a fork the child
process has no threads, and starts its own when it first has work.
"""

from __future__ import annotations

import functools
import logging
import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import TypeVar

from stitchmesh.errors import ParameterError

VARIABLE = "STITCHMESH_THREADS"
"""Environment variable with the number of threads."""
QUOTA_FILE = Path("/sys/fs/cgroup/cpu.max")
"""On Linux: processor time that a container may use in a period, or ``max``, and the period [microseconds]."""

BLOCK = 16384
"""Number of elements of a block, if nothing else is asked for."""

T = TypeVar("T")
Work = Callable[[int], object]
"""Work that threads share. It is called with the number of the thread; the thread that offers the work has number 0."""

logger = logging.getLogger(__name__)


@dataclass
class _Choice:
    """The chosen number of threads; None until it is first needed."""

    threads: int | None = None


_choice = _Choice()


def thread_count() -> int:
    """Number of threads that share a launch on a CPU.

    Raises:
        ParameterError: the environment variable is not a whole number of at least 1.
    """
    if _choice.threads is None:
        given = os.environ.get(VARIABLE)
        _choice.threads = _checked(given, VARIABLE) if given else core_count()
    return _choice.threads


def set_threads(threads: int | None) -> None:
    """Set how many threads share the launches on a CPU, for all later calls in this process.

    If the number is larger than the number of cores, the number of cores is taken and a warning says so.

    Args:
        threads: number of threads; None returns to the environment variable, or to all cores.

    Raises:
        ParameterError: the number is not a whole number of at least 1.
    """
    _choice.threads = None if threads is None else _checked(threads, "threads")


def core_count() -> int:
    """Number of cores that the affinity of this process and its container let it use."""
    if hasattr(os, "sched_getaffinity"):
        cores = len(os.sched_getaffinity(0))
    else:
        cores = os.cpu_count() or 1
    with suppress(OSError, ValueError):  # Not Linux, or no quota.
        time, period = QUOTA_FILE.read_text().split()
        cores = min(cores, max(round(int(time) / int(period)), 1))
    return cores


def _checked(threads: int | str, name: str) -> int:
    """Return a number of threads, or the number of cores if it is larger."""
    number = 0
    with suppress(ValueError):
        number = int(threads)
    if number < 1 or str(number) != str(threads):
        raise ParameterError(f"{name}: got {threads!r}; expected a whole number of at least 1")
    cores = core_count()
    if number > cores:
        logger.warning("%s: got %d, but this process may use %d cores; %d are taken", name, number, cores, cores)
    return min(number, cores)


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


def each_block(work: Callable[[slice], T], count: int, size: int = BLOCK) -> list[T]:
    """Do work on the elements of long arrays, one block after another, shared among ``thread_count()`` threads.

    Args:
        work: what is done with the elements of one slice. NumPy lets other threads run meanwhile.
        count: number of elements.
        size: number of elements of a block. Results do not depend on the number of threads if each element is
            computed by itself.

    Returns:
        The results in the order of the blocks.
    """
    blocks = [slice(first, min(first + size, count)) for first in range(0, count, size)]
    if thread_count() == 1 or len(blocks) <= 1 or getattr(_own, "is_of_pool", False):
        return [work(block) for block in blocks]
    return list(_pool_of(thread_count()).map(work, blocks))


_own = threading.local()
"""Marks the threads of a pool, which do the blocks of their own work alone: waiting for each other they would stop."""


def _mark_own_thread() -> None:
    _own.is_of_pool = True


@functools.cache
def _pool_of(threads: int) -> ThreadPoolExecutor:
    """Return the threads that share blocks; they are started once in a process."""
    return ThreadPoolExecutor(threads, "blocks", _mark_own_thread)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool_of.cache_clear)
