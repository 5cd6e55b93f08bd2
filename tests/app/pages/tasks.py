# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pages with long work, without a browser: everything is called in the thread of the events."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from tests.app.pages.headless import Headless

SAFETY = 120.0  # Time after which a test that blocks fails [s]; a test that passes waits for a much shorter time.


def call(shown: Headless, function: Callable[..., Any], *arguments: Any) -> None:
    """Call a function in the thread of the events, and wait for its end; an error becomes a notice."""
    shown.app.post(function, *arguments)
    shown.app.queue.settle(SAFETY)


def press(shown: Headless, label: str) -> None:
    """Press a button."""
    call(shown, shown.controls.press, label)


def wait_for_task(shown: Headless) -> None:
    """Wait until no task runs and its result has arrived."""
    for _ in range(int(SAFETY / 0.01)):
        if not shown.app.tasks.running:
            break
        threading.Event().wait(0.01)
    assert not shown.app.tasks.running
    shown.app.queue.settle(SAFETY)
