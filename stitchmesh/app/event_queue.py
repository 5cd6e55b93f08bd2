# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The event queue: one thread runs all callbacks of the application, one after another.

Callbacks of the browser, of tasks and of timers only post to the queue. Only one thread therefore uses the pages and
the project, and they need no locks.
"""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class _Event:
    """A call that waits in the queue; an event with a key holds the newest arguments that were posted with this key."""

    function: Callable[..., object]
    arguments: tuple[Any, ...]
    key: Hashable = None


class EventQueue:
    """Calls that one thread makes in the order in which they were posted."""

    on_error: Callable[[Exception], None]
    """Called in the thread of the queue with the exception of a call; the queue then continues."""

    def __init__(self) -> None:
        """Start the thread; errors are logged until ``on_error`` is set."""
        self.on_error = _log
        self._waiting: queue.SimpleQueue[_Event | None] = queue.SimpleQueue()
        self._newest: dict[Hashable, tuple[Any, ...]] = {}
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._run, name="stitchmesh events", daemon=True)
        self._thread.start()

    def post(self, function: Callable[..., object], *arguments: object) -> None:
        """Call a function with arguments in the thread of the queue, after all waiting calls."""
        self._waiting.put(_Event(function, arguments))

    def post_newest(self, key: Hashable, function: Callable[..., object], *arguments: object) -> None:
        """Call a function with a key; if a call with this key still waits, that call takes the new arguments instead.

        In this way a stream of values, such as the positions of a slider, never fills the queue.
        """
        with self._lock:
            waits = key in self._newest
            self._newest[key] = arguments
        if not waits:
            self._waiting.put(_Event(function, (), key))

    def is_own_thread(self) -> bool:
        """Whether the caller runs in the thread of the queue."""
        return threading.current_thread() is self._thread

    def settle(self, timeout: float = 60.0) -> None:
        """Wait until all calls that are waiting now are done.

        Raises:
            TimeoutError: the calls took longer than the timeout [s].
        """
        done = threading.Event()
        self.post(done.set)
        if not done.wait(timeout):
            raise TimeoutError(f"event queue: calls still wait after {timeout:g} s")

    def stop(self) -> None:
        """Make the waiting calls, and end the thread."""
        self._waiting.put(None)
        if not self.is_own_thread():
            self._thread.join(timeout=10.0)

    def _run(self) -> None:
        while (event := self._waiting.get()) is not None:
            try:
                event.function(*self._arguments(event))
            except Exception as error:
                self._report(error)

    def _arguments(self, event: _Event) -> tuple[Any, ...]:
        if event.key is None:
            return event.arguments
        with self._lock:
            return self._newest.pop(event.key)

    def _report(self, error: Exception) -> None:
        """Report an exception; the thread continues even if the report itself fails."""
        try:
            self.on_error(error)
        except Exception:
            logger.exception("the report of an error failed")


def _log(error: Exception) -> None:
    logger.error("a call of the event queue failed", exc_info=error)
