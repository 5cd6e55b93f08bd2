# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The log of edits: one JSON object a line, ``{"edit": NAME, "arguments": {...}}``."""

from __future__ import annotations

import json
from collections.abc import Iterable
from os import fspath
from pathlib import Path

from stitchmesh.editing.edit import Edit, apply_edit, checked
from stitchmesh.errors import FileError, StitchMeshError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import StitchMesh


def write_log(path: FilePath, edits: Iterable[Edit]) -> None:
    """Write edits, atomically.

    Raises:
        FileError: the file cannot be written.
    """
    lines = [json.dumps({"edit": edit.name, "arguments": dict(edit.arguments)}) for edit in edits]
    write_text(path, "".join(line + "\n" for line in lines))


def read_log(path: FilePath) -> list[Edit]:
    """Read edits; each is checked for its name and the kinds of its arguments.

    Raises:
        FileError: the file cannot be read, or a line is no edit; the message names the line.
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
        fabric: the stitch mesh that the log was written for.
        path: what ``write_log`` or ``History.save`` wrote.

    Raises:
        FileError: as for ``read_log``.
        StitchMeshError: an edit is refused, as for ``apply_edit``; the message names the line and the edit.
    """
    for number, edit in enumerate(read_log(path), start=1):
        try:
            fabric = apply_edit(fabric, edit).fabric
        except StitchMeshError as error:
            raise type(error)(f"{fspath(path)} line {number}: {edit.name}: {error}") from error
    return fabric


def _edit(line: str, where: str) -> Edit:
    try:
        content = json.loads(line)
    except json.JSONDecodeError as error:
        raise FileError(f"{where}: is no JSON ({error.msg}, column {error.colno}); expected one edit a line") from error
    except RecursionError as error:
        raise FileError(f"{where}: is nested too deeply for an edit; expected one edit a line") from error
    if not isinstance(content, dict) or set(content) != {"edit", "arguments"}:
        raise FileError(f'{where}: is no edit; expected {{"edit": NAME, "arguments": {{...}}}}')
    if not isinstance(content["edit"], str) or not isinstance(content["arguments"], dict):
        raise FileError(f"{where}: is no edit; expected a name and an object of arguments")
    edit = Edit(content["edit"], content["arguments"])
    try:
        checked(edit)
    except StitchMeshError as error:
        raise FileError(f"{where}: {error}") from error
    return edit
