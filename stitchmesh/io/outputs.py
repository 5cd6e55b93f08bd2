# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Guards the files that a command may not replace: its inputs, and the user's own files.

While a command runs, its outputs are guarded. Every reader notes the file that it reads (``note_input``), and every
write asks before it replaces a file (``check_output``) and enters the new one into the record of its folder
(``stitchmesh.io.own_files``). A file may be replaced if the program wrote it and nobody changed it since, or if the
user allows it by ``--overwrite``. An input is never replaced. There is one exception: a command reads and replaces the
files that it keeps in its own output folder for its next run, such as checkpoints and finished stages.

A command names its main outputs before a long computation (``plan_outputs``), so that it is refused at its start.

Functions of the library that are called from Python, without a guard, replace the files that the caller names.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path

from stitchmesh.errors import FileError
from stitchmesh.io.own_files import is_marked, is_own, mark_folder, note_file
from stitchmesh.io.path_kind import entries_of, is_folder, is_there, refuse_folder

Identity = tuple[int, int]
"""Device and number of a file."""


@dataclass
class _Guard:
    """What a command has read and written so far."""

    overwrite: bool
    """Whether files of the user's may be replaced."""
    inputs: set[Identity] = field(default_factory=set)
    """The files that were read, except for files that the command had written before."""
    planned: list[Path] = field(default_factory=list)
    """Outputs that the command has named."""
    folders: list[Path] = field(default_factory=list)
    """Output folders, in which the command keeps files for its next run."""
    claimed: list[Path] = field(default_factory=list)
    """Folders that belong to the program with all their content, even damaged files."""
    written: set[Path] = field(default_factory=set)
    """Files that the command has written."""


_present: ContextVar[_Guard | None] = ContextVar("guard of outputs", default=None)


@contextmanager
def guarded_outputs(*, overwrite: bool = False) -> Iterator[None]:
    """Guard the outputs of this thread for the block; a guard around the block stays in force.

    Args:
        overwrite: whether files may be replaced that the program did not write or that were changed since.
    """
    if _present.get() is not None:
        yield
        return
    token = _present.set(_Guard(overwrite))
    try:
        yield
    finally:
        _present.reset(token)


def plan_outputs(paths: Iterable[Path], *, folder: Path | None = None) -> None:
    """Name outputs before they are made.

    Args:
        paths: files that will be written.
        folder: an output folder; the program's own files in it may be read and replaced.

    Raises:
        FileError: one of the files may not be replaced or is a folder, or no file or folder can have the name.
    """
    guard = _present.get()
    if guard is None:
        return
    if folder is not None and is_there(folder):
        guard.folders.append(Path(os.path.realpath(folder)))
    for path in paths:
        refuse_folder(path)
        guard.planned.append(path)
        _check(guard, path)


def note_input(path: str | os.PathLike[str]) -> None:
    """Note that a file is read.

    Raises:
        FileError: the file is one of the outputs that the command has named.
    """
    guard, found = _present.get(), _identity(path)
    if guard is None or found is None or _place(Path(path)) in guard.written:
        return
    if any(_identity(output) == found for output in guard.planned):
        raise _is_input(path)
    guard.inputs.add(found)


def check_output(path: Path) -> None:
    """Check that a file may be written, and replaced if it is there.

    Raises:
        FileError: the file may not be replaced.
    """
    guard = _present.get()
    if guard is not None:
        _check(guard, path)


def note_output(path: Path, written: Path) -> None:
    """Enter a file that is about to be moved to a path into the record of its folder.

    Raises:
        FileError: the record cannot be written.
    """
    guard = _present.get()
    if guard is not None:
        note_file(path, written)
        guard.written.add(_place(path))


def claim_folder(folder: Path, inside: Iterable[str] = ()) -> None:
    """Mark a folder as the program's own, in which it removes files, or several of its processes write.

    Args:
        folder: the folder, which is made if it is missing.
        inside: names that only the program gives to its files there; by default the folder must be new or empty.

    Raises:
        FileError: the folder is a link, or holds something that the program did not make; or it cannot be made.
    """
    guard, names = _present.get(), tuple(inside)
    if guard is not None and not names:
        guard.claimed.append(Path(os.path.realpath(folder)))
    if is_marked(folder):
        return
    if os.path.islink(folder):
        raise FileError(f"{folder}: is a symbolic link; expected a folder; remove the link, or choose another output")
    others = [path for path in entries_of(folder) if path.name in names or not names] if is_folder(folder) else []
    if others and not (guard is not None and guard.overwrite):
        remedy = "choose another output, or add --overwrite to write into this one"
        raise FileError(f"{others[0]}: is there already and was not made by StitchMesh; {remedy}")
    mark_folder(folder)


def _check(guard: _Guard, path: Path) -> None:
    place = _place(path)
    if not os.path.lexists(path) or place in guard.written or any(map(place.is_relative_to, guard.claimed)):
        return
    is_kept = path not in guard.planned and any(place.is_relative_to(folder) for folder in guard.folders)
    if _identity(path) in guard.inputs and not (is_kept and is_own(path)):
        raise _is_input(path)
    if not guard.overwrite and not is_own(path):
        found = "was not written by StitchMesh, or was changed since"
        raise FileError(f"{path}: is there already and {found}; choose another name, or add --overwrite to replace it")


def _is_input(path: str | os.PathLike[str]) -> FileError:
    return FileError(f"{os.fspath(path)}: this command reads the file and would replace it; choose another output")


def _place(path: Path) -> Path:
    """Return the path of a file without links in the folders above it."""
    return Path(os.path.realpath(path.parent)) / path.name


def _identity(path: str | os.PathLike[str]) -> Identity | None:
    """Return the identity of a file, through links; None if there is none."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return found.st_dev, found.st_ino
