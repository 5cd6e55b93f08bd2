# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A history of edits with undo and redo that are exact to the last bit, and the log of edits that it writes.

The history stores only the changes of each edit, so that the history of a large garment needs little memory. A log is
a text file with one JSON object in each line, ``{"edit": NAME, "arguments": {...}}``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from os import fspath
from typing import Any

from stitchmesh.editing.edit import Edit, Edited, apply_changes, apply_edit, checked_arguments
from stitchmesh.editing.undo_history import history_of_steps, steps_done, steps_undone
from stitchmesh.errors import StitchMeshError, check_kind
from stitchmesh.io.contents import FilePath
from stitchmesh.io.step_log import read_step_log, write_step_log
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import Change


@dataclass(frozen=True)
class _Step:
    """An edit with the changes that apply it and the changes that undo it."""

    edit: Edit
    changes: tuple[Change, ...]
    inverse: tuple[Change, ...]


class History:
    """A stitch mesh with the edits that were applied to it."""

    def __init__(self, fabric: StitchMesh) -> None:
        """Start with a stitch mesh; the given mesh is never modified."""
        check_kind("History", fabric, StitchMesh)
        self._fabric = fabric
        self._steps = history_of_steps(list[_Step]())

    @property
    def fabric(self) -> StitchMesh:
        """The current stitch mesh."""
        return self._fabric

    @property
    def edits(self) -> tuple[Edit, ...]:
        """The edits that lead to the current mesh; edits that were undone are not included."""
        return tuple(step.edit for step in steps_done(self._steps))

    @property
    def undone(self) -> tuple[Edit, ...]:
        """The edits that ``redo`` can apply, the next one first."""
        return tuple(step.edit for step in steps_undone(self._steps))

    def apply(self, edit: Edit | Callable[..., Edited], **arguments: object) -> StitchMesh:
        """Apply an edit and return the new mesh; edits that were undone can then no longer be redone.

        Args:
            edit: a function of ``sm.edits``, or an edit from a file.
            **arguments: the arguments of the function, without the mesh.

        Raises:
            StitchMeshError: an error of ``apply_edit``; the mesh stays unchanged.
        """
        if not isinstance(edit, Edit) and callable(edit):
            edit = Edit(edit.__name__, arguments)
        edited = apply_edit(self._fabric, edit)
        self._steps = self._steps.do(_Step(edit, edited.changes, edited.inverse))
        self._fabric = edited.fabric
        return self._fabric

    def undo(self) -> StitchMesh:
        """Undo the last edit and return the mesh.

        Raises:
            ParameterError: there is no edit to undo.
        """
        before = self._steps.undo("undo: there is no edit to undo")
        undone = self._steps.present
        assert undone is not None
        self._fabric = apply_changes(self._fabric, undone.inverse).fabric
        self._steps = before
        return self._fabric

    def redo(self) -> StitchMesh:
        """Apply the last undone edit again, and return the mesh.

        Raises:
            ParameterError: there is no edit to redo.
        """
        after = self._steps.redo("redo: there is no edit to redo")
        redone = after.present
        assert redone is not None
        self._fabric = apply_changes(self._fabric, redone.changes).fabric
        self._steps = after
        return self._fabric

    def write(self, path: FilePath) -> None:
        """Write the edits as a log for ``replay_edits``.

        Raises:
            FileError: the file cannot be written.
        """
        write_log(path, self.edits)


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
