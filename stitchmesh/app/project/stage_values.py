# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The values that follow from the state of a project: the labelings, the divided mesh and the edited fabric.

The values are made again when a project is opened. The labeling before each step and the changes of each edit are kept,
so that undo takes no time.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from stitchmesh.app.project.division import Division
from stitchmesh.app.project.source import NO_START, Start, read_source
from stitchmesh.app.project.state import ProjectState
from stitchmesh.editing.edit import Edit, Edited, apply_changes, apply_edit
from stitchmesh.editing.undo_history import steps_done
from stitchmesh.errors import ParameterError
from stitchmesh.labeling import PartialLabeling
from stitchmesh.labeling.steps import LabelStep, apply_label_step
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import Change


@dataclass(frozen=True, eq=False, kw_only=True)
class StageValues:
    """The values of the stages up to the edited fabric."""

    start: Start = NO_START
    """The imported file."""
    labelings: tuple[PartialLabeling, ...] = ()
    """The labeling before the first step and after each step; empty if there is no mesh."""
    labeled: StitchMesh | None = None
    """The labeled mesh; None until every face has a row."""
    fabric: StitchMesh | None = None
    """The fabric with all edits; None until the mesh is divided."""
    inverses: tuple[tuple[Change, ...], ...] = ()
    """The changes that undo each edit."""
    last_changes: tuple[Change, ...] = ()
    """The changes of the last edit, undo or redo."""

    @classmethod
    def of(cls, state: ProjectState) -> StageValues:
        """Return the values of a state.

        Raises:
            StitchMeshError: the imported file cannot be read, or a step or an edit is not possible.
        """
        if state.source is None:
            return cls()
        values = cls.begin(read_source(state.source))
        for step in steps_done(state.label_steps):
            values = values.with_label_step(step)
        return values.divided_as(state)

    @classmethod
    def begin(cls, start: Start) -> StageValues:
        """Return the values of an imported file."""
        values = cls(start=start, fabric=start.fabric)
        return values if start.labeling is None else values._labeled_as((start.labeling,))

    @property
    def labeling(self) -> PartialLabeling | None:
        """The labeling after the last step; None if there is no mesh."""
        return self.labelings[-1] if self.labelings else None

    def with_label_step(self, step: LabelStep) -> StageValues:
        """Return the values after a step of the labeling.

        Raises:
            StitchMeshError: there is no mesh, or the step is not possible.
        """
        if self.labeling is None:
            raise ParameterError(f"step {step.name}: there is no mesh to label; import a polygon mesh first")
        labeling = apply_label_step(self.labeling, step)
        return self._labeled_as((*self.labelings, labeling))

    def without_label_step(self) -> StageValues:
        """Return the values before the last step of the labeling."""
        return self._labeled_as(self.labelings[:-1])

    def divided_as(self, state: ProjectState) -> StageValues:
        """Return the values with the stitches and the edits of a state, which must have the same labeling.

        Raises:
            StitchMeshError: the division or an edit is not possible.
        """
        values = self if state.division is None else self.divided(state.division)
        if state.shaped is not None:
            values = self.shaped(state.shaped.fabric)
        for edit in steps_done(state.edits):
            values = values.edited(edit)
        return values

    def divided(self, division: Division, fabric: StitchMesh | None = None) -> StageValues:
        """Return the values after a division; ``fabric`` is its result, if it is known.

        Raises:
            StitchMeshError: the mesh is not labeled, or it cannot be divided in this way.
        """
        if self.labeled is None:
            raise ParameterError("divide: the mesh is not labeled completely; label all its faces first")
        return replace(self, fabric=fabric or division.divide(self.labeled), inverses=(), last_changes=())

    def shaped(self, fabric: StitchMesh) -> StageValues:
        """Return the values with stitches that were found on the mesh.

        Raises:
            ParameterError: there is no mesh.
        """
        if self.labeling is None:
            raise ParameterError("rows: there is no mesh to find rows on; import a polygon mesh first")
        return replace(self, fabric=fabric, inverses=(), last_changes=())

    def edited(self, edit: Edit) -> StageValues:
        """Return the values after an edit.

        Raises:
            StitchMeshError: there is no fabric, or the edit is not possible.
        """
        if self.fabric is None:
            raise ParameterError(f"edit {edit.name}: there are no stitches yet; divide the labeled mesh first")
        edited = apply_edit(self.fabric, edit)
        return replace(self._of(edited), inverses=(*self.inverses, edited.inverse))

    def undone(self) -> StageValues:
        """Return the values before the last edit."""
        assert self.fabric is not None
        return replace(self._of(apply_changes(self.fabric, self.inverses[-1])), inverses=self.inverses[:-1])

    def _labeled_as(self, labelings: tuple[PartialLabeling, ...]) -> StageValues:
        return StageValues(start=self.start, labelings=labelings, labeled=_labeled(labelings[-1]))

    def _of(self, edited: Edited) -> StageValues:
        return replace(self, fabric=edited.fabric, last_changes=edited.changes)


def _labeled(labeling: PartialLabeling) -> StitchMesh | None:
    """Return the labeled mesh; None if a face has no row."""
    return labeling.finish() if labeling.labeled.all() else None
