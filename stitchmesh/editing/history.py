# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits made so far, with undo and redo exact to the last bit.

Only what each edit changed is kept, so a long history of a large garment stays small.
"""

from __future__ import annotations

from stitchmesh.editing.edit import Edit, Edited, apply_changes, apply_edit
from stitchmesh.editing.log import write_log
from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import Change


class History:
    """A stitch mesh while it is edited."""

    def __init__(self, fabric: StitchMesh) -> None:
        """Start from a stitch mesh, which stays as it is."""
        self._fabric = fabric
        self._done: list[_Step] = []
        self._undone: list[_Step] = []

    @property
    def fabric(self) -> StitchMesh:
        """The stitch mesh as it is now."""
        return self._fabric

    @property
    def edits(self) -> tuple[Edit, ...]:
        """The edits that made it, undone ones left out."""
        return tuple(edit for edit, _, _ in self._done)

    @property
    def undone(self) -> tuple[Edit, ...]:
        """Edits that ``redo`` would do, the next one first."""
        return tuple(edit for edit, _, _ in reversed(self._undone))

    def apply(self, edit: Edit) -> StitchMesh:
        """Apply an edit; a refused one changes nothing. What was undone can no longer be redone.

        Raises:
            StitchMeshError: as for ``apply_edit``.
        """
        edited = apply_edit(self._fabric, edit)
        self._done.append((edit, edited.changes, edited.inverse))
        self._undone.clear()
        return self._take(edited)

    def undo(self) -> StitchMesh:
        """Undo the last edit.

        Raises:
            ParameterError: there is none.
        """
        step = _last(self._done, "undo")
        self._undone.append(step)
        return self._take(apply_changes(self._fabric, step[2]))

    def redo(self) -> StitchMesh:
        """Do the edit that was undone last again.

        Raises:
            ParameterError: there is none.
        """
        step = _last(self._undone, "redo")
        self._done.append(step)
        return self._take(apply_changes(self._fabric, step[1]))

    def save(self, path: FilePath) -> None:
        """Write the edits as a log that ``replay_edits`` reads.

        Raises:
            FileError: the file cannot be written.
        """
        write_log(path, self.edits)

    def _take(self, edited: Edited) -> StitchMesh:
        self._fabric = edited.fabric
        return self._fabric


_Step = tuple[Edit, tuple[Change, ...], tuple[Change, ...]]


def _last(steps: list[_Step], what: str) -> _Step:
    if not steps:
        raise ParameterError(f"{what}: there is no edit to {what}")
    return steps.pop()
