# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The signals by which a scheduler of a cluster, a shell or a user asks a command to stop."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stitchmesh.jobs.job_status import StopRequest

SIGNALS = (signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else []))
"""The signals that ask for a stop: that of a scheduler or of `kill`, and that of a terminal that is closed."""
INTERRUPTED = 130
"""Exit status after an interrupt from the keyboard (SIGINT)."""
TERMINATED = 143
"""Exit status of a job that a signal has stopped, as a shell gives it for SIGTERM."""


@contextmanager
def stopped_by_signal() -> Iterator[StopRequest]:
    """Provide the wish to stop, which SIGTERM utters within the block, and SIGHUP unless it is ignored (``nohup``)."""
    from stitchmesh.jobs.job_status import StopRequest

    stop = StopRequest()
    heard = [number for number in SIGNALS if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, lambda number, frame: stop.ask()) for number in heard}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def interrupt_noted() -> Iterator[Callable[[], bool]]:
    """Provide a function that tells whether an interrupt came within the block.

    An interrupt raises ``KeyboardInterrupt`` where the program is. Code of other packages that runs there may drop the
    exception, for example while it loads a library; the command then goes on, and the note remains.
    """
    noted = False

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal noted
        noted = True
        signal.default_int_handler(number, frame)

    before = signal.getsignal(signal.SIGINT)
    # A shell lets commands in the background ignore interrupts, and only the main thread may set handlers.
    if before is not signal.default_int_handler or threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    signal.signal(signal.SIGINT, note)
    try:
        yield lambda: noted
    finally:
        signal.signal(signal.SIGINT, before)
