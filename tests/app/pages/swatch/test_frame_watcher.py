# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Frames of a session reach the event thread: the newest always does, and none after the session is closed."""

from __future__ import annotations

import threading
from types import SimpleNamespace

from stitchmesh.app.event_queue import EventQueue
from stitchmesh.app.pages.swatch.variant import FrameWatcher

SAFETY = 60.0
"""Seconds after which a waiting test fails."""


class Frames:
    """A session that makes frames as it is told."""

    def __init__(self) -> None:
        self.frame = SimpleNamespace(number=0)
        self._changed, self._closed = threading.Condition(), False

    def make(self) -> None:
        with self._changed:
            self.frame = SimpleNamespace(number=self.frame.number + 1)
            self._changed.notify_all()

    def close(self) -> None:
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def wait_for_frame(self, after: int) -> SimpleNamespace | None:
        with self._changed:
            self._changed.wait_for(lambda: self._closed or self.frame.number > after, SAFETY)
            return None if self._closed else self.frame


def test_the_newest_frame_arrives_in_the_event_thread_even_if_frames_must_wait():
    queue, arrived, numbers, session = EventQueue(), threading.Event(), [], Frames()

    def deliver(frame):
        assert queue.is_own_thread()
        numbers.append(frame.number)
        if frame.number == 8:
            arrived.set()

    watcher = FrameWatcher(session, queue, deliver)
    watcher.seconds = 3600.0  # Without haste, the second frame would wait for an hour.
    for _ in range(8):
        watcher.hurry()
        session.make()
    watcher.hurry()
    assert arrived.wait(SAFETY)
    session.close()
    queue.stop()
    assert numbers == sorted(set(numbers))
