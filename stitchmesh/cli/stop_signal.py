# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The signal with which a scheduler of a cluster or a shell asks a job to stop."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stitchmesh.jobs.stop import StopRequest

SIGNALS = (signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else []))
"""The signals: that of a scheduler or of `kill`, and that of a terminal that is closed."""
TERMINATED = 143
"""Exit status of a job that a signal has stopped, as a shell gives it for SIGTERM."""


@contextmanager
def stopped_by_signal() -> Iterator[StopRequest]:
    """Provide the wish to stop, which SIGTERM utters within the block, and SIGHUP unless it is ignored (``nohup``)."""
    from stitchmesh.jobs.stop import StopRequest

    stop = StopRequest()
    heard = [number for number in SIGNALS if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, lambda number, frame: stop.ask()) for number in heard}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
