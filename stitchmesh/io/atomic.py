# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Atomic writes: the content is written to a temporary file beside the target and renamed when it is complete."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from os import fspath
from pathlib import Path

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath


@contextmanager
def atomic_path(path: FilePath) -> Iterator[Path]:
    """Provide a temporary path in the target's folder; the temporary file replaces the target after the block.

    Missing folders are made. If the block raises an exception or is interrupted, the temporary file is removed and the
    target stays unchanged. The temporary name has the suffix of the target, because some writers use the suffix.

    Raises:
        FileError: the folder cannot be made or written, the target is a folder, or the disk refuses the file.
    """
    target = Path(path)
    temporary = _make_temporary_file(target)
    try:
        yield temporary
        _flush_to_disk(temporary)
        os.replace(temporary, target)
    except OSError as error:
        raise FileError(f"{fspath(path)}: cannot be written ({error.strerror or error})") from error
    finally:
        temporary.unlink(missing_ok=True)


def write_bytes(path: FilePath, content: bytes) -> None:
    """Write a file atomically.

    Raises:
        FileError: as for ``atomic_path``.
    """
    with atomic_path(path) as temporary:
        temporary.write_bytes(content)


def write_text(path: FilePath, text: str) -> None:
    """Write a text file atomically, in UTF-8 with plain newlines.

    Raises:
        FileError: as for ``atomic_path``.
    """
    write_bytes(path, text.encode("utf-8"))


def write_json(path: FilePath, content: Mapping[str, object]) -> None:
    """Write a JSON file atomically; the keys keep their order.

    Raises:
        FileError: as for ``atomic_path``.
    """
    write_text(path, json.dumps(content, indent=2, allow_nan=False) + "\n")


def _make_temporary_file(target: Path) -> Path:
    """Make an empty temporary file in the folder of the target, and return its path."""
    if target.is_dir():
        raise FileError(f"{target}: is a folder; expected the name of a file to write")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{target.stem}-", suffix=target.suffix, dir=target.parent)
    except (FileExistsError, NotADirectoryError) as error:
        raise FileError(f"{target}: the name of its folder is the name of a file; choose another folder") from error
    except OSError as error:
        reason = error.strerror or str(error)
        raise FileError(f"{target}: its folder cannot be written ({reason}); choose another one") from error
    os.close(handle)
    os.chmod(name, 0o666 & ~_file_mode_mask())  # mkstemp makes files that only the owner can read.
    return Path(name)


def _file_mode_mask() -> int:
    """Return the mask of permissions of new files; it can only be read by setting it."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _flush_to_disk(path: Path) -> None:
    with path.open("rb") as file:
        os.fsync(file.fileno())
