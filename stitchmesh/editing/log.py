# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The log of edits: a text file with one JSON object in each line, ``{"edit": NAME, "arguments": {...}}``."""

from __future__ import annotations

from collections.abc import Iterable
from os import fspath
from typing import Any

from stitchmesh.editing.edit import Edit, apply_edit, checked_arguments
from stitchmesh.errors import StitchMeshError, check_kind
from stitchmesh.io.contents import FilePath
from stitchmesh.io.step_log import read_step_log, write_step_log
from stitchmesh.mesh import StitchMesh


def write_log(path: FilePath, edits: Iterable[Edit]) -> None:
    """Write a log of edits; the file is written atomically.

    Raises:
        FileError: the file cannot be written.
    """
    write_step_log(path, "edit", [(edit.name, edit.arguments) for edit in edits])


def read_log(path: FilePath) -> list[Edit]:
    """Read a log of edits; the name and the types of the arguments of each edit are checked.

    Raises:
        FileError: the file cannot be read, or a line is not a valid edit; the message names the line.
    """
    return read_step_log(path, "edit", _edit)


def replay_edits(fabric: StitchMesh, path: FilePath) -> StitchMesh:
    """Apply the edits of a log.

    Args:
        fabric: the stitch mesh for which the log was written.
        path: a file that ``write_log`` or ``History.write`` wrote.

    Returns:
        The edited stitch mesh.

    Raises:
        FileError: an error of ``read_log``.
        StitchMeshError: an edit is not possible, with the error of ``apply_edit``; the message names the line and the
            edit.
    """
    check_kind("replay_edits", fabric, StitchMesh)
    for number, edit in enumerate(read_log(path), start=1):
        try:
            fabric = apply_edit(fabric, edit).fabric
        except StitchMeshError as error:
            raise type(error)(f"{fspath(path)} line {number}: {edit.name}: {error}") from error
    return fabric


def _edit(name: str, arguments: dict[str, Any]) -> Edit:
    edit = Edit(name, arguments)
    checked_arguments(edit)
    return edit
