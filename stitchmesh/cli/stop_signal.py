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

TERMINATED = 143
"""Exit status of a job that a signal has stopped, as a shell gives it for SIGTERM."""


@contextmanager
def stopped_by_signal() -> Iterator[StopRequest]:
    """Provide the wish to stop, which SIGTERM utters within the block."""
    from stitchmesh.jobs.stop import StopRequest

    stop = StopRequest()
    before = signal.signal(signal.SIGTERM, lambda number, frame: stop.ask())
    try:
        yield stop
    finally:
        signal.signal(signal.SIGTERM, before)
