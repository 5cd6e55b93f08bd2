# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of the files and folders that are the program's own, and the functions that open and remove them.

A folder in which a command writes has a record, ``.stitchmesh``: a line for each file that was written, with its
SHA-256 checksum and its name as ``sha256sum`` writes them. A file is the program's own if its record holds its checksum
under its name. A file that the user made, or changed later, is not. A folder with a record was made or used by the
program.

A line is appended by one write, before the new file replaces the old one. Two commands may therefore write into one
folder at the same time, and if a process is killed between the two steps, the record still knows the old file. Other
users may write in a folder too. These functions therefore follow no symbolic link, and a pipe or a device in the place
of a file does not block them.
"""

from __future__ import annotations

import errno
import hashlib
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BufferedReader
from pathlib import Path

from stitchmesh.errors import FileError
from stitchmesh.io.disk_refusal import refusal

RECORD = ".stitchmesh"
"""Name of the record of a folder."""
HEAD = b"# StitchMesh wrote these files, and replaces them while they are unchanged.\n"
"""First line of a record."""
LONGEST_RECORD = 2**20
"""A record of at least this size is written again with only the last two lines of each name [bytes]."""
NO_FOLLOW = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)  # Windows has neither.
MADE = os.O_RDWR | os.O_CREAT
"""Flags of ``open_own`` with which a missing file is made."""


def open_own(path: str | Path, flags: int = MADE, *, above: int | None = None) -> int:
    """Open a file of the program's own, and return the number of the open file.

    Args:
        path: the file.
        flags: how it is opened.
        above: an open folder in which the path begins; None for the present one.

    Raises:
        OSError: there is no such file, it is a link or no regular file, or it cannot be opened.
    """
    number = os.open(path, flags | NO_FOLLOW, 0o666, dir_fd=above)
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise OSError(errno.EINVAL, f"{os.fspath(path)} is no regular file")
    return number


@contextmanager
def opened_folder(folder: str | Path, above: int | None = None) -> Iterator[int | None]:
    """Open a folder for the block, to work in it by its number.

    Args:
        folder: the folder; a link that the user has named is followed.
        above: an open folder that holds it; a link in it is not followed.

    Yields:
        The number of the open folder; None if there is none, it is a link, or it cannot be opened.
    """
    number = None
    if os.open in os.supports_dir_fd:  # Windows has no open folders.
        follow = 0 if above is None else os.O_NOFOLLOW
        with suppress(OSError):
            number = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | follow, dir_fd=above)
    try:
        yield number
    finally:
        if number is not None:
            os.close(number)


def mark_folder(folder: Path) -> None:
    """Make a folder with an empty record, or give a folder a record.

    Raises:
        FileError: the folder or the record cannot be made, or a file of its name is no record.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"{folder}: cannot be written {refusal(error)}") from error
    _append(folder / RECORD, b"")


def is_marked(folder: Path) -> bool:
    """Return whether a folder, which is no link, has a record."""
    return not os.path.islink(folder) and _lines(folder / RECORD) is not None


def note_file(path: Path, written: Path) -> None:
    """Write into the record of a folder that a new file is about to replace the file at a path.

    Args:
        path: the path.
        written: the complete new file.

    Raises:
        FileError: the record cannot be written, or a file of its name is no record.
    """
    with written.open("rb") as content:
        line = _line(path.name, content)
    _append(path.with_name(RECORD), line)


def is_own(path: Path) -> bool:
    """Return whether the program wrote a file and nobody has changed it; False if it cannot be read."""
    lines, end = _lines(path.with_name(RECORD)), _name_in_line(path.name)
    if lines is None or not any(line.endswith(end) for line in lines):
        return False
    try:
        with os.fdopen(open_own(path, os.O_RDONLY), "rb") as file:
            return _line(path.name, file) in lines
    except OSError:
        return False


def _append(record: Path, line: bytes) -> None:
    """Append a line to a record, which is made if it is missing."""
    try:
        number = open_own(record, MADE | os.O_APPEND)
    except OSError as error:
        raise FileError(f"{record}: the record of this folder cannot be written {refusal(error)}") from error
    with os.fdopen(number, "r+b", buffering=0) as file:
        size = os.fstat(number).st_size
        if size and file.read(len(HEAD)) != HEAD:
            raise FileError(f"{record}: is no record of StitchMesh; a record of this name is written here, remove it")
        added = line if size else HEAD + line
        try:
            if file.write(added) < len(added):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        except OSError as error:
            with suppress(OSError):
                file.truncate(size)  # Half a line would spoil the next one.
            raise FileError(f"{record}: the record of this folder cannot be written {refusal(error)}") from error
    if size > LONGEST_RECORD:
        _shorten(record)


def _shorten(record: Path) -> None:
    """Keep only the last two lines of each name in a record; a line that is appended meanwhile may be lost."""
    last: dict[bytes, list[bytes]] = {}
    for line in _lines(record) or []:
        name = line.partition(b"  ")[2]
        last[name] = [*last.get(name, [])[-1:], line]
    short = record.with_name(f"{RECORD}.{os.getpid()}")
    with os.fdopen(open_own(short, MADE | os.O_EXCL), "wb") as file:
        file.write(HEAD + b"".join(line for lines in last.values() for line in lines))
    os.replace(short, record)


def _lines(record: Path) -> list[bytes] | None:
    """Return the lines of a record, the last ones last; None if there is no record."""
    try:
        with os.fdopen(open_own(record, os.O_RDONLY), "rb") as file:
            head, *lines = file.readlines(2 * LONGEST_RECORD) or [b""]
    except OSError:
        return None
    return lines if head == HEAD else None


def _line(name: str, content: BufferedReader) -> bytes:
    """Return the line of a record for the content of a file with a name."""
    return hashlib.file_digest(content, "sha256").hexdigest().encode() + _name_in_line(name)


def _name_in_line(name: str) -> bytes:
    """Return the end of a line: two spaces, the name without line ends, and a line end."""
    return b"  " + os.fsencode(name).replace(b"\\", b"\\\\").replace(b"\n", b"\\n") + b"\n"
