# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Frames of a session reach the event thread: the newest always does, and none after the session is closed."""

from __future__ import annotations

import threading

import stitchmesh as sm
from stitchmesh.app.event_queue import EventQueue
from stitchmesh.app.pages.swatch.variant import FrameWatcher

SAFETY = 60.0
"""Seconds after which a waiting test fails."""


def test_the_newest_frame_arrives_in_the_event_thread_even_if_frames_must_wait():
    queue, arrived, numbers = EventQueue(), threading.Event(), []
    with sm.SwatchSession("plain", quality="draft", device="cpu", stopped=True, iterations_per_frame=1) as session:

        def deliver(frame):
            assert queue.is_own_thread()
            numbers.append(frame.number)
            if frame.number == last:
                arrived.set()

        last = session.frame.number + 8
        watcher = FrameWatcher(session, queue, deliver)
        watcher.seconds = 3600.0  # Without haste, the second frame would wait for an hour.
        for _ in range(8):
            watcher.hurry()
            session.step(timeout=SAFETY)
        watcher.hurry()
        assert arrived.wait(SAFETY)
    queue.stop()
    assert numbers == sorted(set(numbers))
