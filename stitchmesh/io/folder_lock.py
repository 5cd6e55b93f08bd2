# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A lock on the folder of a project or of a job, so that two programs never write into it at once.

The lock belongs to the process: the operating system releases it when the process ends, also when it is killed.
"""

from __future__ import annotations

from pathlib import Path
from typing import IO

from stitchmesh.errors import FileError

try:
    import fcntl
except ImportError:  # Windows has no such locks; there a second program is not refused.
    fcntl = None  # type: ignore[assignment]

NAME = ".lock"
"""Name of the lock's file in the folder."""


class FolderLock:
    """The lock on a folder, from its construction until ``release``."""

    def __init__(self, folder: Path, held: str) -> None:
        """Take the lock; the folder is made if it is missing.

        Args:
            folder: the folder.
            held: what another program that holds the lock does, and how to continue, for the message.

        Raises:
            FileError: another program holds the lock, or the folder cannot be made or written.
        """
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file: IO[str] | None = (folder / NAME).open("a+")
        except OSError as error:
            reason = error.strerror or str(error)
            raise FileError(f"{folder}: cannot be written ({reason}); choose another folder") from error
        try:
            if fcntl is not None:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            self._file.close()
            raise FileError(f"{folder}: {held}") from error

    def release(self) -> None:
        """Release the lock; a second call does nothing."""
        if self._file is not None:
            self._file.close()  # The file stays: a program that waits for it holds the same one.
            self._file = None


def is_locked(folder: Path) -> bool:
    """Return whether a program holds the lock of a folder; where there are no locks, the answer is yes."""
    if fcntl is None:
        return True
    try:
        with (folder / NAME).open() as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except FileNotFoundError:
        return False
    except OSError:
        return True
    return False
