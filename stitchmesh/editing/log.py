# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The log of edits: a text file with one JSON object in each line, ``{"edit": NAME, "arguments": {...}}``."""

from __future__ import annotations

import json
from collections.abc import Iterable
from os import fspath
from pathlib import Path
from typing import Any

import msgspec

from stitchmesh.editing.edit import Edit, apply_edit, checked_arguments
from stitchmesh.errors import FileError, ParameterError, StitchMeshError, check_kind
from stitchmesh.io.atomic import write_text
from stitchmesh.io.checked import check_value, parse_json
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import StitchMesh


def write_log(path: FilePath, edits: Iterable[Edit]) -> None:
    """Write a log of edits; the file is written atomically.

    Raises:
        FileError: the file cannot be written.
    """
    lines = [json.dumps({"edit": edit.name, "arguments": dict(edit.arguments)}, default=list) for edit in edits]
    write_text(path, "".join(line + "\n" for line in lines))


def read_log(path: FilePath) -> list[Edit]:
    """Read a log of edits; the name and the types of the arguments of each edit are checked.

    Raises:
        FileError: the file cannot be read, or a line is not a valid edit; the message names the line.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise FileError(f"{fspath(path)}: cannot be read ({reason}); expected a log of edits") from error
    return [_edit(line, f"{fspath(path)} line {number}") for number, line in enumerate(text.splitlines(), start=1)]


def replay_edits(fabric: StitchMesh, path: FilePath) -> StitchMesh:
    """Apply the edits of a log.

    Args:
        fabric: the stitch mesh for which the log was written.
        path: a file that ``write_log`` or ``History.save`` wrote.

    Returns:
        The edited stitch mesh.

    Raises:
        FileError: as for ``read_log``.
        StitchMeshError: an edit is not possible, as for ``apply_edit``; the message names the line and the edit.
    """
    check_kind("replay_edits", fabric, StitchMesh)
    for number, edit in enumerate(read_log(path), start=1):
        try:
            fabric = apply_edit(fabric, edit).fabric
        except StitchMeshError as error:
            raise type(error)(f"{fspath(path)} line {number}: {edit.name}: {error}") from error
    return fabric


class _Line(msgspec.Struct, forbid_unknown_fields=True):
    """The content of one line."""

    edit: str
    arguments: dict[str, Any]


def _edit(line: str, where: str) -> Edit:
    """Return the edit of a line; ``where`` is the file and the line number, for the error message."""
    try:
        content = parse_json(line)
    except ParameterError as error:
        raise FileError(f"{where}: {error}; expected one edit a line") from error
    try:
        found = check_value(content, _Line)
    except ParameterError as error:
        raise FileError(f'{where}: is no edit; expected {{"edit": NAME, "arguments": {{...}}}}: {error}') from error
    edit = Edit(found.edit, found.arguments)
    try:
        checked_arguments(edit)
    except ParameterError as error:
        raise FileError(f"{where}: {error}") from error
    return edit
