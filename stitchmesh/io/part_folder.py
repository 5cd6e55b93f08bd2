# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Folders of parts: a file is written in a hidden folder beside its target, and moved when it is complete.

Each write has a folder of its own in ``.stitchmesh-parts``, with a lock that belongs to its process. Libraries that
write additional files beside a file leave them there too. If a process is killed, its folder stays without a lock, and
the next write or run in the same target folder removes it. The folder of a process that is still writing, even on
another machine that shares the target folder, has its lock and stays. Other users may write in the target folder too.
Therefore a folder is removed only if it has the name and the lock's file of a part, and nothing behind a symbolic link
is removed: each step of the removal opens a folder by its name in the folder above, without following links. No file is
written into a folder of parts that is a link, or that others may change.
"""

from __future__ import annotations

import os
import re
import shutil
import stat
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import IO

from stitchmesh.errors import FileError
from stitchmesh.io.folder_lock import NAME, try_lock
from stitchmesh.io.own_files import open_own, opened_folder

PARTS = ".stitchmesh-parts"
"""Name of the folder with the folders of parts; it exists only while there are any."""
PREFIX = "part-"
"""First letters of the name of the folder of a part; random letters follow."""
PART_NAME = re.compile(re.escape(PREFIX) + r"[a-z0-9_]{8}")
MOST_TRIES = 100
"""Number of folders that are tried: another process may remove an empty folder before it is locked."""


class PartFolder:
    """An empty folder for a file that is being written, from its construction until ``remove``."""

    def __init__(self, beside: Path) -> None:
        """Make and lock the folder; the folder of the target is made if it is missing.

        Raises:
            FileError: the folder of parts is a link, or belongs to another user.
            OSError: the folder cannot be made.
        """
        with opened_folder(beside) as folder:
            _remove_stale(folder)
        self.path, self._lock = _locked_folder(beside / PARTS)

    def remove(self) -> None:
        """Remove the folder with all that is left in it."""
        self._lock.close()
        shutil.rmtree(self.path, ignore_errors=True)
        with suppress(OSError):  # Another process writes there.
            self.path.parent.rmdir()


def remove_stale_parts(folder: Path) -> None:
    """Remove the parts that ended processes have left in a folder, and in the folders directly in it."""
    with opened_folder(folder) as opened:
        _remove_stale(opened)
        for name in [] if opened is None else os.listdir(opened):
            with opened_folder(name, opened) as inside:
                _remove_stale(inside)


def _remove_stale(folder: int | None) -> None:
    """Remove the folders of parts whose processes have ended from an open folder."""
    if folder is None:
        return
    with opened_folder(PARTS, folder) as parts:
        if parts is None:
            return
        for name in filter(PART_NAME.fullmatch, os.listdir(parts)):
            _remove_if_stale(name, parts)
    with suppress(OSError):  # Other parts are still written, or others have put files there.
        os.rmdir(PARTS, dir_fd=folder)


def _remove_if_stale(name: str, parts: int) -> None:
    """Remove a folder of a part, but only if it is known that no process holds its lock."""
    with opened_folder(name, parts) as part, suppress(OSError):  # It was removed meanwhile, or belongs to another user.
        if part is None:
            return
        try:
            lock = os.fdopen(open_own(NAME, os.O_RDWR, above=part), "r+")
        except FileNotFoundError:
            os.rmdir(name, dir_fd=parts)  # The process ended before it made the lock; a folder with files stays.
            return
        with lock:
            if not try_lock(lock):
                return
            # The removal is done under the lock, so that no process begins to write in the folder.
            shutil.rmtree(name, ignore_errors=True, dir_fd=parts)
        shutil.rmtree(name, ignore_errors=True, dir_fd=parts)  # A network file system keeps a folder with an open file.


def _locked_folder(parts: Path) -> tuple[Path, IO[str]]:
    """Make a folder, and return it with its lock.

    Raises:
        FileError: the folder of parts is a link, or belongs to another user.
        OSError: the folder cannot be made.
    """
    for left in reversed(range(MOST_TRIES)):
        try:
            parts.parent.mkdir(parents=True, exist_ok=True)
            if not parts.is_dir() or parts.is_symlink():
                _make_parts(parts)
            folder = Path(tempfile.mkdtemp(prefix=PREFIX, dir=parts))
            _check_owner(parts, folder)
            lock = os.fdopen(open_own(folder / NAME), "r+")
        except FileNotFoundError:  # Another process has removed a folder that was still empty.
            if left == 0:
                raise
            continue
        if try_lock(lock) is not False and (folder / NAME).exists():
            return folder, lock
        lock.close()
    raise OSError(f"{MOST_TRIES} folders for parts of files were removed by another process")


def _make_parts(parts: Path) -> None:
    """Make the folder of parts, in which only this user may write.

    Raises:
        FileError: a link or a file has the name of the folder.
        OSError: the folder cannot be made.
    """
    try:
        parts.mkdir(mode=stat.S_IRWXU)
    except FileExistsError as error:
        if stat.S_ISDIR(parts.lstat().st_mode):  # Another process has made it meanwhile.
            return
        found = "a symbolic link" if parts.is_symlink() else "a file"
        raise FileError(f"{parts}: is {found}; files are written in a folder of this name first, remove it") from error


def _check_owner(parts: Path, folder: Path) -> None:
    """Check that nobody else can rename a new folder in the folder of parts; remove it if somebody can.

    The owner and the mode are compared with the owner and the mode of the new folder, because some file systems give
    all files the same owner and mode.

    Raises:
        FileError: another user can rename it.
    """
    outer, inner = parts.lstat(), folder.lstat()
    if outer.st_uid != inner.st_uid or outer.st_mode & (stat.S_IWGRP | stat.S_IWOTH) & ~inner.st_mode:
        folder.rmdir()
        found = "belongs to another user, or others may write in it"
        raise FileError(f"{parts}: {found}; remove it, or choose a folder of your own")
