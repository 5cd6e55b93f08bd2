# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tells whether nothing, a file or a folder stands at a path; a refusal of the system gives an error of one line.

``pathlib`` asks the same, but raises ``PermissionError`` in a folder that may not be searched, and ``OSError`` for a
name that is too long.
"""

from __future__ import annotations

import errno
import os
import stat
from os import fspath
from pathlib import Path

from stitchmesh.errors import FileError

FilePath = str | os.PathLike[str]
REMEDIES = {
    errno.EACCES: "change the mode of its folder, or choose another one",
    errno.ENAMETOOLONG: "choose a shorter name",
    errno.ELOOP: "remove the symbolic links that lead in a circle",
}
"""The remedy for the user, by the number of the error."""


def is_there(path: FilePath) -> bool:
    """Return whether there is anything at a path, through symbolic links.

    Raises:
        FileError: the system does not say it.
    """
    return _mode(path) is not None


def is_file(path: FilePath) -> bool:
    """Return whether there is a regular file at a path; errors as for ``is_there``."""
    mode = _mode(path)
    return mode is not None and stat.S_ISREG(mode)


def is_folder(path: FilePath) -> bool:
    """Return whether there is a folder at a path; errors as for ``is_there``."""
    mode = _mode(path)
    return mode is not None and stat.S_ISDIR(mode)


def refuse_folder(path: FilePath) -> None:
    """Check that a file can be written at a path, as far as its name tells.

    Raises:
        FileError: a folder stands there, or no file can have the name.
    """
    if is_folder(path):
        raise FileError(f"{Path(path)}: is a folder; expected the name of a file to write")


def entries_of(folder: FilePath) -> list[Path]:
    """Return the paths of all that stands in a folder, sorted.

    Raises:
        FileError: the folder cannot be read.
    """
    try:
        return sorted(Path(folder).iterdir())
    except (OSError, ValueError) as error:
        raise _refused(folder, error) from error


def whole_path(path: FilePath) -> Path:
    """Return a path from the root, without symbolic links.

    Raises:
        FileError: the path cannot be followed.
    """
    try:
        return Path(path).resolve()
    except (OSError, ValueError, RuntimeError) as error:  # Python 3.11 has a RuntimeError for links in a circle.
        raise _refused(path, error) from error


def _mode(path: FilePath) -> int | None:
    """Return the mode of the file or folder at a path; None if there is neither."""
    try:
        return os.stat(path).st_mode
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError) as error:  # A ValueError means a name with a zero byte, or with half of a character.
        raise _refused(path, error) from error


def _refused(path: FilePath, error: Exception) -> FileError:
    """Return the error of a path that the system does not follow."""
    reason = getattr(error, "strerror", None) or error
    remedy = REMEDIES.get(getattr(error, "errno", None) or 0, "check the path")
    return FileError(f"{fspath(path)}: cannot be looked at ({reason}); {remedy}")
