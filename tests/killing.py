# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Functions that are killed by SIGKILL at a chosen moment, which is counted in calls, so that no clock is needed."""

from __future__ import annotations

import functools
import os
import signal
import sys
from collections.abc import Callable
from io import IOBase
from pathlib import Path
from types import FrameType
from typing import Any

from stitchmesh.io.part_folder import PartFolder


class Countdown:
    """A profiling function that counts calls and runs an action before the call after ``calls`` calls.

    The count starts with the first call of the function of the given name. With ``of_files`` only calls that may change
    a file are counted.
    """

    def __init__(self, function: str, calls: float, act: Callable[[], None], *, of_files: bool) -> None:
        self.function, self.calls, self.act, self.of_files = function, calls, act, of_files
        self.begun, self.passed = False, 0

    def __call__(self, frame: FrameType, event: str, argument: Any) -> None:
        self.begun = self.begun or frame.f_code.co_name == self.function
        if not self.begun or event.endswith(("return", "exception")) or (self.of_files and not _on_files(argument)):
            return
        self.passed += 1
        if self.passed > self.calls:
            self.act()


def _on_files(called: Any) -> bool:
    """Whether a call may change a file: a call of the operating system, or of a method of an open file."""
    own = getattr(called, "__self__", None)
    return getattr(own, "__name__", "") == "posix" or isinstance(own, IOBase)


def count_calls(function: str, work: Callable[[], object]) -> int:
    """Count the calls in ``work`` from the first call of the function of the given name."""
    counter = Countdown(function, float("inf"), lambda: None, of_files=False)
    sys.setprofile(counter)
    try:
        work()
    finally:
        sys.setprofile(None)
    return counter.passed


def killed(function: str, calls: int, work: Callable[[], object], *, of_files: bool = False) -> bool:
    """Run ``work`` in a child process that is killed after a number of calls.

    The calling process must have only one thread.

    Args:
        function: name of the function whose first call starts the count.
        calls: number of calls before the child process is killed.
        work: what the child process runs.
        of_files: whether only calls that may change a file are counted.

    Returns:
        Whether the child process was killed; False if ``work`` ended before.
    """
    child = os.fork()
    if child == 0:
        kill = functools.partial(os.kill, os.getpid(), signal.SIGKILL)
        sys.setprofile(Countdown(function, calls, kill, of_files=of_files))
        work()
        os._exit(0)
    _child, status = os.waitpid(child, 0)
    if os.WIFEXITED(status) and os.WEXITSTATUS(status) != 0:
        raise RuntimeError(f"the child ended with status {os.WEXITSTATUS(status)}")
    return os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL


def leave_part(folder: Path, name: str) -> None:
    """Leave half of a file in a folder, as a process that is killed while it writes does."""
    folder.mkdir(parents=True, exist_ok=True)
    part = PartFolder(folder)
    (part.path / name).write_text("half of the n")
    part._lock.close()  # The operating system releases the lock of a process that is killed.
