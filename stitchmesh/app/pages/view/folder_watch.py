# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Watches the folder of a job, and tells when its files have changed."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

from stitchmesh.app.pages.view.job_folder import JobFiles, job_files
from stitchmesh.errors import StitchMeshError

EVERY_SECONDS = 1.0
"""Time between two looks at the folder."""


class FolderWatch:
    """A thread that looks at a folder until it is stopped."""

    def __init__(self, folder: Path, changed: Callable[[JobFiles], object], every: float = EVERY_SECONDS) -> None:
        """Start; ``changed`` is called in the thread of the watch, with the files after each change."""
        self.folder = folder
        self._changed, self._every = changed, every
        self._stopped = threading.Event()
        self._seen = job_files(folder)
        threading.Thread(target=self._run, name=f"watching {folder}", daemon=True).start()

    def stop(self) -> None:
        """End the thread."""
        self._stopped.set()

    def _run(self) -> None:
        while not self._stopped.wait(self._every):
            try:
                files = job_files(self.folder)
            except StitchMeshError:
                continue  # The folder may come back, for example on a disk of another computer.
            if files != self._seen and not self._stopped.is_set():
                self._seen = files
                self._changed(files)
