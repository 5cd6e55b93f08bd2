# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A history of edits with undo and redo that are exact to the last bit.

The history stores only the changes of each edit, so that the history of a large garment needs little memory.
"""

from __future__ import annotations

from stitchmesh.editing.edit import Edit, Edited, apply_changes, apply_edit
from stitchmesh.editing.log import write_log
from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import Change


class History:
    """A stitch mesh with the edits that were applied to it."""

    def __init__(self, fabric: StitchMesh) -> None:
        """Start with a stitch mesh; the given mesh is never modified."""
        check_kind("History", fabric, StitchMesh)
        self._fabric = fabric
        self._done: list[_Step] = []
        self._undone: list[_Step] = []

    @property
    def fabric(self) -> StitchMesh:
        """The current stitch mesh."""
        return self._fabric

    @property
    def edits(self) -> tuple[Edit, ...]:
        """The edits that lead to the current mesh; edits that were undone are not included."""
        return tuple(edit for edit, _, _ in self._done)

    @property
    def undone(self) -> tuple[Edit, ...]:
        """The edits that ``redo`` can apply, the next one first."""
        return tuple(edit for edit, _, _ in reversed(self._undone))

    def apply(self, edit: Edit) -> StitchMesh:
        """Apply an edit and return the new mesh; edits that were undone can then no longer be redone.

        Raises:
            StitchMeshError: as for ``apply_edit``; the mesh stays unchanged.
        """
        edited = apply_edit(self._fabric, edit)
        self._done.append((edit, edited.changes, edited.inverse))
        self._undone.clear()
        return self._set_fabric(edited)

    def undo(self) -> StitchMesh:
        """Undo the last edit and return the mesh.

        Raises:
            ParameterError: there is no edit to undo.
        """
        step = _last(self._done, "undo")
        self._undone.append(step)
        return self._set_fabric(apply_changes(self._fabric, step[2]))

    def redo(self) -> StitchMesh:
        """Apply again the edit that was undone last, and return the mesh.

        Raises:
            ParameterError: there is no edit to redo.
        """
        step = _last(self._undone, "redo")
        self._done.append(step)
        return self._set_fabric(apply_changes(self._fabric, step[1]))

    def save(self, path: FilePath) -> None:
        """Write the edits as a log for ``replay_edits``.

        Raises:
            FileError: the file cannot be written.
        """
        write_log(path, self.edits)

    def _set_fabric(self, edited: Edited) -> StitchMesh:
        self._fabric = edited.fabric
        return self._fabric


_Step = tuple[Edit, tuple[Change, ...], tuple[Change, ...]]


def _last(steps: list[_Step], action: str) -> _Step:
    if not steps:
        raise ParameterError(f"{action}: there is no edit to {action}")
    return steps.pop()
