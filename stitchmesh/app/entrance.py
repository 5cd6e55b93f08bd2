# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How the user's browser gets the token: through a page on disk that only the user can read.

All users of a machine can read the arguments of a process. A browser is therefore started with the path of the page,
and not with the address, which holds the token.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from stitchmesh.errors import FileError
from stitchmesh.io.folder_lock import NAME as LOCK
from stitchmesh.io.folder_lock import FolderLock, is_locked
from stitchmesh.markup import markup

PREFIX = "browser~"
"""First letters of the name of the page's folder; no folder of a project begins in this way."""
NAME = "open.html"
"""Name of the page."""
LEADING = """<!doctype html><html lang="en"><meta charset="utf-8"><title>StitchMesh</title>
<link rel="icon" href="data:,"><meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0; url={}">
<p><a href="{}">Open StitchMesh</a></p></html>
"""
"""Content of a page that leads to an address at once."""


@contextlib.contextmanager
def entrance(address: str, folder: Path) -> Iterator[Path]:
    """Make a page that leads to an address, in a new folder that only the user can enter; remove it at the end.

    Pages of killed programs are removed too.

    Args:
        address: the address.
        folder: the place for the new folder. Browsers in containers can read neither hidden folders nor temporary ones.

    Raises:
        FileError: the page cannot be written, or the file system cannot hide it from other users.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        own = Path(tempfile.mkdtemp(prefix=PREFIX, dir=folder))
    except OSError as error:
        raise FileError(f"{folder}: cannot be written ({error.strerror or error})") from error
    lock = FolderLock(own, "another program uses it")
    try:
        for other in folder.glob(f"{PREFIX}*"):
            if not other.is_symlink() and not is_locked(other):
                _remove(other)
        _write_for_owner(own / NAME, leading_page(address))
        yield own / NAME
    finally:
        lock.give_up()
        _remove(own)


def leading_page(address: str) -> str:
    """Return a page of HTML that leads to an address at once.

    A page that sets a cookie leads to its address in this way too: after an HTTP redirect, a browser that comes from a
    page on disk would not send a cookie that other sites must not see.
    """
    return markup(LEADING, address, address)


def _remove(own: Path) -> None:
    with contextlib.suppress(OSError):  # Another start removes what cannot be removed now.
        for name in (NAME, LOCK):
            (own / name).unlink(missing_ok=True)
        own.rmdir()


def _write_for_owner(path: Path, text: str) -> None:
    try:
        with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
            if os.name == "posix" and os.fstat(file.fileno()).st_mode & 0o077:
                raise FileError(f"{path.parent}: its file system lets other users read the page with the token")
            file.write(text)
    except OSError as error:
        raise FileError(f"{path}: cannot be written ({error.strerror or error})") from error
