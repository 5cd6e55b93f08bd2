# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Atomic writes: the content is written to a temporary file, which replaces the target when it is complete.

The new file has the mode of the file that it replaces. Within a command it replaces no input, and no file of the user's
(``stitchmesh.io.outputs``). Content without a place of its own on disk, such as an upload, gets a temporary file,
because readers and writers need a path.
"""

from __future__ import annotations

import json
import os
import stat
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from os import fspath
from pathlib import Path

from stitchmesh.errors import FileError, StitchMeshError
from stitchmesh.io.contents import FilePath
from stitchmesh.io.disk_refusal import refusal
from stitchmesh.io.outputs import check_output, note_output
from stitchmesh.io.part_folder import PartFolder
from stitchmesh.io.path_kind import is_file, is_there, refuse_folder


@contextmanager
def atomic_path(path: FilePath) -> Iterator[Path]:
    """Provide the path of a temporary file, which replaces the target after the block.

    Missing folders are made. If the block raises an exception or is interrupted, the temporary file is removed and the
    target stays unchanged; after a kill the next write removes it (``part_folder``). The temporary file has the name of
    the target.

    Raises:
        FileError: the folder cannot be made or written, the target is a folder or may not be replaced, or the disk
            refuses the file.
    """
    target = Path(path)
    refuse_folder(target)
    if is_there(target) and not is_file(target):
        raise FileError(f"{target}: is a device or a pipe, whose place no file can take; choose another name")
    check_output(target)
    part = _begin_part(target)
    temporary = part.path / target.name
    try:
        yield temporary
        _copy_mode(target, temporary)
        _flush_to_disk(temporary)
        note_output(target, temporary)
        os.replace(temporary, target)
    except OSError as error:
        raise FileError(f"{fspath(path)}: cannot be written {refusal(error)}") from error
    finally:
        part.remove()


def write_bytes(path: FilePath, content: bytes | memoryview) -> None:
    """Write a file atomically.

    Raises:
        FileError: as for ``atomic_path``.
    """
    with atomic_path(path) as temporary:
        temporary.write_bytes(content)


def write_text(path: FilePath, text: str) -> None:
    """Write a text file atomically, in UTF-8 with plain newlines.

    Raises:
        FileError: as for ``atomic_path``, or the text contains the name of a file whose bytes are no text.
    """
    try:
        content = text.encode("utf-8")
    except UnicodeEncodeError as error:
        found = f"a name in it is not UTF-8 ({text[max(0, error.start - 20) : error.end]!r})"
        raise FileError(f"{fspath(path)}: cannot be written: {found}; rename the file of this name") from error
    write_bytes(path, content)


def write_json(path: FilePath, content: Mapping[str, object]) -> None:
    """Write a JSON file atomically; the keys keep their order.

    Raises:
        FileError: as for ``atomic_path``.
    """
    write_text(path, json.dumps(content, indent=2, allow_nan=False) + "\n")


def _begin_part(target: Path) -> PartFolder:
    """Make the folder in which a file is written before it replaces the target."""
    try:
        return PartFolder(target.parent)
    except (FileExistsError, NotADirectoryError) as error:
        raise FileError(f"{target}: the name of its folder is the name of a file; choose another folder") from error
    except OSError as error:
        raise FileError(f"{target}: its folder cannot be written {refusal(error)}") from error


def _copy_mode(target: Path, temporary: Path) -> None:
    """Give a new file the mode of the file that it is going to replace, so that a private file stays private."""
    with suppress(FileNotFoundError):
        mode = target.lstat().st_mode
        if stat.S_ISREG(mode):
            temporary.chmod(stat.S_IMODE(mode))


def _flush_to_disk(path: Path) -> None:
    with path.open("rb") as file:
        os.fsync(file.fileno())


@contextmanager
def temporary_file(name: str, content: bytes | None = None) -> Iterator[Path]:
    """Provide the path of a file in a temporary folder, which is removed after the block.

    An error that the block raises names the file without this folder, because the user does not know it.

    Args:
        name: name of the file; folders in it are left out, even folders in the form of Windows.
        content: what the file holds; there is no file yet if it is None.

    Raises:
        FileError: no file can have the name.
    """
    with tempfile.TemporaryDirectory(prefix="stitchmesh-") as folder:
        path = Path(folder) / Path(name.replace("\\", "/")).name
        try:
            if content is not None:
                _write(path, name, content)
            yield path
        except StitchMeshError as error:
            error.args = (str(error).replace(f"{folder}{os.sep}", ""),)
            raise


def _write(path: Path, name: str, content: bytes) -> None:
    try:
        path.write_bytes(content)
    except (OSError, ValueError) as error:
        raise FileError(f"{name[:40]!r}: cannot be opened ({error.__class__.__name__}); rename it") from error
