# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading of files that users name, and checks that are common to all formats.

Every reader begins with ``read_bytes``. Libraries get the content or a copy of the file and not the name. With the name
they could wait for ever at a pipe, read a device without end, or find another file than the checked one.
"""

from __future__ import annotations

import errno
import logging
import os
import stat
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike, fspath
from pathlib import Path

import numpy as np

from stitchmesh.errors import FileError, ParameterError, described
from stitchmesh.io.outputs import note_input
from stitchmesh.io.path_kind import FilePath
from stitchmesh.lattice import LARGEST_LENGTH
from stitchmesh.mesh import FloatArray

logger = logging.getLogger(__name__)

READING = os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)
"""Flags to open a file that may be anything: at once, and without making it the terminal of this process."""
LARGEST_FILE = 4 * 2**30
"""Largest size of a file that is read [bytes]."""
LARGEST_EXPANSION, FREE_EXPANSION = 100, 2**24
"""Bytes of numbers that a compressed file may hold for each of its bytes, and additional bytes for each file."""


def check_path(path: FilePath) -> None:
    """Check that a path is a text or a ``Path``.

    Raises:
        ParameterError: the path is anything else.
    """
    if not isinstance(path, str | PathLike):
        raise ParameterError(f"path: got {described(path)}; expected the name of a file, a text or a pathlib.Path")


def suffix_of(path: FilePath, known: Iterable[str]) -> str:
    """Return the suffix of a path in lower case.

    Raises:
        ParameterError: the path is neither a text nor a ``Path``.
        FileError: the suffix is not one of the known ones.
    """
    check_path(path)
    suffix = Path(path).suffix.lower()
    if suffix not in known:
        found = f"unknown format {suffix!r}" if suffix else "the name has no suffix"
        raise FileError(f"{fspath(path)}: {found}; expected one of {' '.join(known)}")
    return suffix


def read_bytes(path: FilePath, *, may_be_empty: bool = False) -> bytes:
    """Return the content of a regular file.

    A pipe or a device is refused at once: the file is opened without waiting, and its kind is checked after this.

    Raises:
        FileError: the file is missing, a folder, no regular file, unreadable, larger than ``LARGEST_FILE``, or empty
            although ``may_be_empty`` is False.
    """
    name = fspath(path)
    note_input(path)
    try:
        opened = os.open(path, READING)
        try:
            size = _size(name, os.fstat(opened))
            with os.fdopen(opened, "rb", closefd=False) as file:
                content = file.read(size)  # Without bytes that others append meanwhile.
        finally:
            os.close(opened)
    except FileNotFoundError as error:
        raise FileError(f"{name}: there is no such file; check the path") from error
    except PermissionError as error:
        raise FileError(f"{name}: no permission to read it; change its mode or copy it") from error
    except MemoryError as error:
        raise FileError(f"{name}: is larger than the memory that is free; divide it") from error
    except (OSError, ValueError) as error:
        no_file = isinstance(error, OSError) and error.errno == errno.ENXIO
        raise FileError(f"{name}: cannot be read ({'it is a socket' if no_file else error})") from error
    if not content and not may_be_empty:
        raise FileError(f"{name}: the file is empty; write it again")
    return content


def read_lines(path: FilePath) -> list[str]:
    """Return the lines of a text file in UTF-8.

    Raises:
        FileError: as for ``read_bytes``, or the file holds binary data.
    """
    content = read_bytes(path)
    if b"\0" in content:
        raise FileError(f"{fspath(path)}: holds binary data; expected a text file")
    return content.decode("utf-8-sig", errors="replace").splitlines()


def _size(name: str, found: os.stat_result) -> int:
    """Return the size of a regular file that may be read [bytes].

    Raises:
        FileError: the file is no regular file, or larger than ``LARGEST_FILE``.
    """
    if stat.S_ISDIR(found.st_mode):
        raise FileError(f"{name}: is a folder; expected a file")
    if not stat.S_ISREG(found.st_mode):
        kind = "a pipe" if stat.S_ISFIFO(found.st_mode) else "a device"
        raise FileError(f"{name}: is {kind}; expected a file, write its content to one")
    if found.st_size > LARGEST_FILE:
        raise FileError(f"{name}: has {found.st_size} bytes; expected {LARGEST_FILE} at most, divide it")
    return found.st_size


def check_expansion(expanded: int, size: int) -> None:
    """Check that numbers in a compressed file do not need very much more memory than the file.

    Args:
        expanded: bytes of the numbers.
        size: bytes of the file.

    Raises:
        ValueError: the numbers need more; the message has no path.
    """
    if expanded > FREE_EXPANSION + LARGEST_EXPANSION * size:
        found = f"a file of {size} bytes states {expanded} bytes of numbers"
        raise ValueError(f"{found}, more than {LARGEST_EXPANSION} times as many")


def check_points(place: str, points: FloatArray) -> None:
    """Check that coordinates are finite, and so small that areas and volumes are finite too.

    Args:
        place: the name of the file and of the points, for the message, such as ``yarns.bcc: curve 3, point``.
        points: shape (n, 3).

    Raises:
        FileError: a coordinate is not finite or larger than ``LARGEST_LENGTH``.
    """
    bad = np.flatnonzero(~(np.abs(points) <= LARGEST_LENGTH).all(axis=1))
    if len(bad):
        found = f"{place} {bad[0]} is {points[bad[0]].tolist()}"
        raise FileError(f"{found}; coordinates must be finite, and at most {LARGEST_LENGTH:g}")


def is_coordinate(value: float) -> bool:
    """Return whether a number is finite and at most ``LARGEST_LENGTH``."""
    return abs(value) <= LARGEST_LENGTH


def check_one_mesh(path: FilePath, names: Sequence[str]) -> None:
    """Check that a file of a mesh that moves has one mesh.

    Args:
        path: the file.
        names: names of its meshes.

    Raises:
        FileError: it has none or several.
    """
    if len(names) == 1:
        return
    listed = ", ".join(name[:20] for name in names[:4]) + (", ..." if len(names) > 4 else "")
    found = f"has {len(names)} meshes ({listed})" if names else "has no mesh"
    raise FileError(f"{fspath(path)}: {found}; expected one mesh that moves; export it alone")


def say_left_out(path: FilePath, counts: Mapping[str, int], what: str) -> None:
    """Log a warning about what was left out of a file, if anything was.

    Args:
        path: the file.
        counts: number of the things that were left out, by their name in the file.
        what: word for the things, in the plural, such as ``lines``.
    """
    if not counts:
        return
    listed_names = 8  # A line lists no more.
    names = [f"{name[:20]} ({count})" for name, count in list(counts.items())[:listed_names]]
    more = f" and {len(counts) - listed_names} more" if len(counts) > listed_names else ""
    listed = ", ".join(names) + more
    logger.warning("%s: left out %s, which the surface does not need: %s", fspath(path), what, listed)
