# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Writing in the background: the disk has the newest state a moment after each change."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from stitchmesh.app.project.state import ProjectState
from stitchmesh.errors import StitchMeshError

logger = logging.getLogger(__name__)

DELAY = 0.2
"""Time between a change and its write [s]; further changes in this time join the write."""
RETRY = 5.0
"""Time between two writes while the disk refuses them [s]."""


class Autosave:
    """Writes the newest state of a project in a thread of its own."""

    def __init__(self, write: Callable[[ProjectState], None], on_trouble: Callable[[str | None], None]) -> None:
        """Start the thread.

        Args:
            write: writes a state; only one thread at a time calls it.
            on_trouble: called in the writing thread with a message after a failed write, and with None after the next
                successful one.
        """
        self._write, self._on_trouble = write, on_trouble
        self._changed = threading.Condition()
        self._writing = threading.Lock()
        self._newest: ProjectState | None = None
        self._closing = False
        self.trouble: str | None = None
        """Why the newest state cannot be written; None if it is written or still waits."""
        self._thread = threading.Thread(target=self._run, name="autosave", daemon=True)
        self._thread.start()

    def changed(self, state: ProjectState) -> None:
        """Write a state soon, in place of every earlier state that still waits."""
        with self._changed:
            self._newest = state
            self._changed.notify()

    def flush(self) -> None:
        """Write the newest state now.

        Raises:
            FileError: the disk refuses the state.
        """
        with self._writing:
            state = self._newest
            if state is not None:
                self._write_one(state)

    def end(self) -> None:
        """End the thread; a waiting state stays unwritten."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        self._thread.join()

    def close(self) -> None:
        """Write the newest state and end the thread.

        Raises:
            FileError: the disk refuses the state.
        """
        self.end()
        self.flush()

    def _run(self) -> None:
        while not self._closing:
            with self._changed:
                self._changed.wait_for(lambda: self._newest is not None or self._closing)
                self._changed.wait_for(lambda: self._closing, DELAY if self.trouble is None else RETRY)
            if self._closing:
                return
            try:
                self.flush()
            except StitchMeshError as error:
                logger.warning("autosave: %s", error)
            except Exception:  # The thread goes on, because the next state may succeed.
                logger.exception("autosave failed")

    def _write_one(self, state: ProjectState) -> None:
        try:
            self._write(state)
        except Exception as error:
            self.trouble = f"not saved: {error}"
            self._on_trouble(self.trouble)
            raise
        with self._changed:
            if self._newest is state:
                self._newest = None
        if self.trouble is not None:
            self.trouble = None
            self._on_trouble(None)
