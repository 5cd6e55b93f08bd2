# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A lock on the folder of a project or of a job, so that two programs never write into it at once.

The lock belongs to the process: the operating system releases it when the process ends, also when it is killed. Where
there are no locks (Windows, some network file systems), a second program is not refused.
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path
from typing import IO

from stitchmesh.errors import FileError
from stitchmesh.io.disk_refusal import refusal

try:
    import fcntl
except ImportError:  # Windows has no such locks.
    fcntl = None  # type: ignore[assignment]

NAME = ".lock"
"""Name of the lock's file in the folder."""
HAS_LOCKS = fcntl is not None
"""Whether the system has locks of files."""


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
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file: IO[str] | None = open_lock(self._path)
        except OSError as error:
            raise FileError(f"{folder}: cannot be written {refusal(error)}") from error
        if try_lock(self._file) is False:
            self._file.close()
            raise FileError(f"{folder}: {held}")

    def check(self) -> None:
        """Return if the lock is still that of the folder.

        Raises:
            FileError: another program has removed the folder, or the file of the lock.
        """
        try:
            same = self._file is not None and os.path.samestat(os.fstat(self._file.fileno()), self._path.lstat())
        except FileNotFoundError:
            same = False
        if not same:
            raise FileError(f"{self._path.parent}: was removed while it was in use, with files of it; begin again")

    def release(self) -> None:
        """Release the lock; a second call does nothing."""
        if self._file is not None:
            self._file.close()  # The file stays: a program that waits for it holds the same one.
            self._file = None


def is_locked(folder: Path) -> bool:
    """Return whether a program holds the lock of a folder; where there are no locks, the answer is yes."""
    try:
        with open_lock(folder / NAME, os.O_RDONLY) as file:
            return try_lock(file, shared=True) is not True  # A file that is open for reading may have a shared lock.
    except FileNotFoundError:
        return False
    except OSError:
        return True


def open_lock(path: str | Path, flags: int = os.O_RDWR | os.O_CREAT, *, above: int | None = None) -> IO[str]:
    """Open the file of a lock; a symbolic link is not followed, and a pipe does not block.

    Args:
        path: the file.
        flags: how it is opened; by default it is made if it is missing.
        above: an open folder in which the path begins; None for the present one.

    Raises:
        OSError: there is no such file, it is a link or no regular file, or it cannot be opened.
    """
    careful = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    number = os.open(path, flags | careful, 0o666, dir_fd=above)
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise OSError(errno.EINVAL, f"{os.fspath(path)} is no regular file")
    return os.fdopen(number, "r+" if flags & os.O_RDWR else "r")


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
