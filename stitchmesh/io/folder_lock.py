# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A lock on the folder of a project or of a job, so that two programs never write into it at once.

The lock belongs to the process: the operating system releases it when the process ends, also when it is killed. Where
there are no locks (Windows, some network file systems), a second program can write too.
"""

from __future__ import annotations

import contextlib
import errno
import os
from pathlib import Path
from typing import IO

from stitchmesh.errors import FileError
from stitchmesh.io.disk_refusal import refusal
from stitchmesh.io.own_files import open_own
from stitchmesh.io.path_kind import is_there

try:
    import fcntl
except ImportError:  # Windows has no such locks.
    fcntl = None  # type: ignore[assignment]

NAME = ".lock"
"""Name of the lock's file in the folder."""
NO_LOCK = (errno.ENOENT, errno.EINVAL, errno.ELOOP)
"""Numbers of the errors that mean: the lock's file is missing, or something else has its name, so nobody holds the
lock."""


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
        self._path = folder / NAME
        self._file: IO[str] | None = None
        is_there(folder)  # This raises the error for a name that no folder can have.
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._was_there = os.path.lexists(self._path)
            self._take(held)
            if not self._is_of_folder():  # A program that gave up removed the file between the two steps.
                self._take(held)
        except OSError as error:
            raise FileError(f"{folder}: cannot be written {refusal(error)}") from error

    def check(self) -> None:
        """Check that this lock still belongs to the folder.

        Raises:
            FileError: another program has removed the folder, or the file of the lock.
        """
        if not self._is_of_folder():
            raise FileError(f"{self._path.parent}: was removed while it was in use, with files of it; begin again")

    def release(self) -> None:
        """Release the lock; a second call does nothing."""
        if self._file is not None:
            self._file.close()  # The file stays: a program that waits for it holds the same one.
            self._file = None

    def give_up(self) -> None:
        """Release the lock of a folder that is not used after all, and remove the lock's file if it is new."""
        if self._file is not None and not self._was_there:
            with contextlib.suppress(OSError):  # Windows removes no open file.
                self._path.unlink(missing_ok=True)
        self.release()

    def remove_folder(self) -> None:
        """Release the lock of a folder that is not used any more, and remove the folder if nothing else is in it."""
        with contextlib.suppress(OSError):  # Somebody else's files are in it; Windows removes no open file.
            self._path.unlink(missing_ok=True)
            self._path.parent.rmdir()
        self.release()

    def _take(self, held: str) -> None:
        self.release()
        self._file = os.fdopen(open_own(self._path), "r+")
        if try_lock(self._file) is False:
            self.release()
            raise FileError(f"{self._path.parent}: {held}")

    def _is_of_folder(self) -> bool:
        """Whether the open file is still the lock's file in the folder."""
        try:
            return self._file is not None and os.path.samestat(os.fstat(self._file.fileno()), self._path.lstat())
        except FileNotFoundError:
            return False


def is_locked(folder: Path) -> bool:
    """Return whether a program holds the lock of a folder; where there are no locks, the answer is yes."""
    try:
        with os.fdopen(open_own(folder / NAME, os.O_RDONLY)) as file:
            return try_lock(file, shared=True) is not True  # A file that is open for reading may have a shared lock.
    except OSError as error:
        return error.errno not in NO_LOCK


def try_lock(file: IO[str], *, shared: bool = False) -> bool | None:
    """Take the lock on an open file until the file is closed or the process ends.

    Args:
        file: the file, open for writing unless the lock is shared.
        shared: whether others may have a shared lock at the same time.

    Returns:
        True; False if another program holds the lock; None where the system or the file system has no locks.
    """
    if fcntl is None:
        return None
    try:
        fcntl.flock(file, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True
