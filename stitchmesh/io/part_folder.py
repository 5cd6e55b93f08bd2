# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Folders of parts: a file is written in a hidden folder beside its target, and moved when it is complete.

Each write has a folder of its own in ``.stitchmesh-parts``, with a lock that belongs to its process. Libraries that
write files of their own beside a file leave them there too. A process that is killed leaves the folder without its
lock; the next write into the same target folder removes it, and so does the next run there. What another process
writes at the same time, also on another machine that shares the folder, keeps its lock and stays.
"""

from __future__ import annotations

import shutil
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import IO

from stitchmesh.io.folder_lock import NAME, try_lock

PARTS = ".stitchmesh-parts"
"""Name of the folder with the folders of parts; it exists only while there are any."""
MOST_TRIES = 100
"""Number of folders that are tried: another process may remove an empty one before it is locked."""


class PartFolder:
    """An empty folder for a file that is being written, from its construction until ``remove``."""

    def __init__(self, beside: Path) -> None:
        """Make and lock the folder in the folder of the target; that one is made if it is missing.

        Raises:
            OSError: the folder cannot be made.
        """
        _remove_stale(beside / PARTS)
        self.path, self._lock = _locked_folder(beside / PARTS)

    def remove(self) -> None:
        """Remove the folder with all that is left in it."""
        self._lock.close()
        shutil.rmtree(self.path, ignore_errors=True)
        with suppress(OSError):  # Another process writes there.
            self.path.parent.rmdir()


def remove_stale_parts(folder: Path) -> None:
    """Remove the parts that ended processes have left in a folder, and in the folders directly in it."""
    for parts in (folder / PARTS, *folder.glob(f"*/{PARTS}")):
        _remove_stale(parts)


def _remove_stale(parts: Path) -> None:
    """Remove the folders of parts whose processes have ended."""
    with suppress(OSError):  # There are none, or they belong to another user.
        for part in parts.iterdir():
            _remove_if_stale(part)
        parts.rmdir()


def _remove_if_stale(part: Path) -> None:
    """Remove a folder of a part unless a process holds its lock, or it is not known whether one does."""
    with (part / NAME).open("a+") as lock:
        if not try_lock(lock):
            return
        shutil.rmtree(part, ignore_errors=True)  # Under the lock, so that no process begins to write in the folder.
    shutil.rmtree(part, ignore_errors=True)  # A network file system keeps a folder with an open file.


def _locked_folder(parts: Path) -> tuple[Path, IO[str]]:
    """Make a folder, and return it with its lock.

    Raises:
        OSError: the folder cannot be made.
    """
    for left in reversed(range(MOST_TRIES)):
        try:
            parts.mkdir(parents=True, exist_ok=True)
            folder = Path(tempfile.mkdtemp(prefix="", dir=parts))
            lock = (folder / NAME).open("a+")
        except FileNotFoundError:  # Another process has removed a folder that was still empty.
            if left == 0:
                raise
            continue
        if try_lock(lock) is not False and (folder / NAME).exists():
            return folder, lock
        lock.close()
    raise OSError(f"{MOST_TRIES} folders for parts of files were removed by another process")
