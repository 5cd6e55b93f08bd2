# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The file or the job that the user has opened."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from stitchmesh.app.pages.view.job_folder import WAITING, FolderWatch, JobFiles, job_files, read_job
from stitchmesh.app.pages.view.viewed import Viewed, read_viewed
from stitchmesh.errors import FileError
from stitchmesh.io.atomic import temporary_file
from stitchmesh.io.path_kind import is_folder, is_there


class Opened:
    """What was opened, and the watch of its folder if it is a job. All methods belong to the event thread."""

    def __init__(self, post: Callable[..., None], changed: Callable[[], object]) -> None:
        """Start with nothing.

        Args:
            post: calls a function in the event thread; may be called from any thread.
            changed: called in the event thread when a job has a newer state.
        """
        self.viewed: Viewed | None = None
        self.watch: FolderWatch | None = None
        self._post, self._changed = post, changed
        self._files: JobFiles | None = None

    def open_path(self, path: Path) -> None:
        """Open a file, or the output folder of a job, which is followed from now on.

        Raises:
            StitchMeshError: it cannot be read.
        """
        if not is_there(path):
            raise FileError(f"{path}: does not exist; expected a file, or the output folder of a job")
        self.stop()
        if not is_folder(path):
            self.viewed = read_viewed(path)
            return
        files = job_files(path)
        self.viewed = self._read(files) if files.times or files.status else Viewed(path.name, text=WAITING)
        self.watch = FolderWatch(path, lambda now: self._post(self.take_state, now))

    def receive(self, name: str, content: bytes) -> None:
        """Open an uploaded file.

        Raises:
            StitchMeshError: it cannot be read.
        """
        self.viewed = read_upload(name, content)
        self.stop()

    def take_state(self, files: JobFiles) -> None:
        """Read the newest state of the job, unless something else was opened.

        Raises:
            StitchMeshError: a file cannot be read.
        """
        if self.watch is not None and files.folder == self.watch.folder:
            self.viewed = self._read(files)
            self._changed()

    def _read(self, files: JobFiles) -> Viewed:
        """Read a state of a job; a state of the same folder before it saves work."""
        before, self._files = self._files, files
        if before is None or self.viewed is None or before.folder != files.folder:
            return read_job(files)
        return read_job(files, (before, self.viewed))

    def follow_again(self) -> None:
        """Watch the folder again after a stop, and read what has changed."""
        if self.watch is not None:
            self.open_path(self.watch.folder)

    def stop(self) -> None:
        """Watch no folder any more."""
        if self.watch is not None:
            self.watch.stop()
            self.watch = None

    def pause(self) -> None:
        """End the watch, but keep its folder for ``follow_again``."""
        if self.watch is not None:
            self.watch.stop()


def read_upload(name: str, content: bytes) -> Viewed:
    """Read an uploaded file.

    Raises:
        StitchMeshError: the file cannot be read.
    """
    with temporary_file(name, content) as path:
        return read_viewed(path)
