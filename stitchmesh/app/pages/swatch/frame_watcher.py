# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Frames of a live swatch on their way to the event thread: the newest one, and not more often than it can be shown."""

from __future__ import annotations

import threading
from collections.abc import Callable

from stitchmesh.app.event_queue import EventQueue
from stitchmesh.app.task import FRAME_SECONDS
from stitchmesh.periodic.session.frames import Frame
from stitchmesh.periodic.session.session import SwatchSession

URGENT_FRAMES = 6
"""Number of frames after a change that do not wait for the time of the next frame: those that the session was making
before, the drawing, and how it moves."""


class FrameWatcher:
    """Delivers the frames of a session in a thread of its own, until the session is closed."""

    def __init__(self, session: SwatchSession, queue: EventQueue, deliver: Callable[[Frame], object]) -> None:
        """Start to watch.

        Args:
            session: the session; its present frame is not delivered.
            queue: the queue in which ``deliver`` is called.
            deliver: function of each frame; a frame that waits while a newer one arrives is left out.
        """
        self.seconds = FRAME_SECONDS
        """Least time between two frames [s]."""
        self._session, self._queue, self._deliver = session, queue, deliver
        self._urgent = threading.Event()
        threading.Thread(target=self._watch, args=(session.frame.number,), name="frames", daemon=True).start()

    def hurry(self) -> None:
        """Deliver the next frames as soon as they come, because the user has changed something."""
        self._urgent.set()

    def _watch(self, seen: int) -> None:
        hurried = 0
        while (frame := self._session.wait_for_frame(after=seen)) is not None:
            seen = frame.number
            self._queue.post_newest((id(self), "frame"), self._deliver, frame)
            if hurried == 0 and self._urgent.wait(self.seconds):
                hurried = URGENT_FRAMES + 1
            self._urgent.clear()
            hurried = max(hurried - 1, 0)
