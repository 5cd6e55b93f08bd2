# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A project: the values of all stages of a garment, with undo, settings and autosave.

The stages depend on each other in this order: mesh, labeling, labeled mesh, fabric (divided, then edited), evened
fabric, yarns, relaxed yarns. The fabric can also be found on the mesh itself, without a labeling. A change of one stage
drops the later ones; undo and redo restore what the last change dropped. All methods run in one thread; another thread
writes the newest state to disk.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from stitchmesh.app.project.autosave import Autosave
from stitchmesh.app.project.division import Division
from stitchmesh.app.project.project_folder import TABLE_NAME, ProjectFolder
from stitchmesh.app.project.shaping import ShapedStitches, Shaping
from stitchmesh.app.project.source import Source, read_source, source_of
from stitchmesh.app.project.stage_values import StageValues
from stitchmesh.app.project.state import (
    NO_RESULTS,
    ProjectState,
    dropped,
    recoloured,
    with_division,
    with_edits,
    with_label_steps,
    with_results,
    with_shaped,
)
from stitchmesh.editing.edit import Edit
from stitchmesh.editing.undo_history import UndoHistory, steps_done
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checked import check_value, parse_json
from stitchmesh.io.folder_lock import FolderLock
from stitchmesh.io.garments import GarmentMesh
from stitchmesh.io.history import HistoryEntry
from stitchmesh.io.part_folder import remove_stale_parts
from stitchmesh.io.path_kind import is_there
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.labeling import PartialLabeling
from stitchmesh.labeling.steps import LabelStep
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.change import Change
from stitchmesh.mesh.repair import RepairAction
from stitchmesh.mesh.upright import Direction, Y
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.recolouring import changes_colours_only, keeps_yarn_routes

OPEN_ELSEWHERE = "the project is open in another stitchmesh app; use that one, or close it first"
"""Message for a folder whose lock another program holds."""


class Project:
    """A garment from its mesh to its relaxed yarns, in a folder.

    A method that changes the project returns the names of the values that it dropped, such as ``("yarns", "relaxed
    yarns")``. If a method raises an error, the project stays unchanged.

    Use ``create``, ``open`` or ``open_or_create`` to make one, and ``close`` at the end.
    """

    def __init__(
        self, store: ProjectFolder, lock: FolderLock, state: ProjectState, values: StageValues,
        notes: tuple[str, ...] = (),
    ) -> None:  # fmt: skip
        """Hold a state and its values; ``notes`` says what was left out when they were read."""
        self._store, self._lock, self._state, self._values = store, lock, state, values
        self.notes = notes
        """A line for each result that was damaged on disk and therefore left out."""
        self.on_trouble: Callable[[str | None], None] = lambda message: None
        """Called from another thread with a message when autosave fails, and with None when it succeeds again."""
        self.autosave = Autosave(store.write, self._trouble)

    @classmethod
    def create(cls, folder: Path, name: str = "", source: Source | None = None) -> Project:
        """Make a project from an imported file, or an empty one; its default name is the name of its folder.

        Raises:
            StitchMeshError: the imported file cannot be read, the folder already holds a project, another program uses
                it, or it cannot be written; nothing new is then left in the folder.
        """
        folder = Path(folder).absolute()
        if is_there(folder / TABLE_NAME):
            raise FileError(f"{folder}: holds a project already; open it, or choose another folder")
        source, values = _read(source)
        state = ProjectState(name=name or folder.name, source=source)
        is_new = not folder.exists()
        lock = FolderLock(folder, OPEN_ELSEWHERE)
        project = cls(ProjectFolder(folder), lock, state, values)
        try:
            project.save()
        except FileError:
            project.autosave.end()
            lock.give_up()
            if is_new:
                shutil.rmtree(folder, ignore_errors=True)
            raise
        return project

    @classmethod
    def open(cls, folder: Path) -> Project:
        """Open the project of a folder in its last state.

        Raises:
            FileError: the folder holds no project, another program uses it, or the project is damaged.
        """
        folder = Path(folder).absolute()
        _check_holds_project(folder)
        lock = FolderLock(folder, OPEN_ELSEWHERE)
        remove_stale_parts(folder)
        store = ProjectFolder(folder)
        try:
            state, notes = store.read()
            return cls(store, lock, state, StageValues.of(state), notes)
        except BaseException:
            lock.give_up()
            raise

    @staticmethod
    def delete(folder: Path) -> None:
        """Delete the project of a folder; files of the user in the folder stay, and the folder with them.

        Raises:
            FileError: the folder holds no project, another program uses it, or something cannot be removed.
        """
        _check_holds_project(folder)
        lock = FolderLock(folder, OPEN_ELSEWHERE)
        try:
            ProjectFolder(folder).delete()
        except FileError:
            lock.release()
            raise
        lock.remove_folder()

    @classmethod
    def open_or_create(cls, folder: Path) -> Project:
        """Open the project of a folder, or make an empty one there.

        Raises:
            FileError: an error of ``open`` or ``create``.
        """
        return cls.open(folder) if is_there(Path(folder) / TABLE_NAME) else cls.create(folder)

    @property
    def folder(self) -> Path:
        """The folder of the project."""
        return self._store.folder

    @property
    def checkpoint_folder(self) -> Path:
        """Folder of the checkpoints of a relaxation; autosave does not write it."""
        return self.folder / "checkpoint"

    @property
    def name(self) -> str:
        """Name of the project."""
        return self._state.name

    @property
    def source(self) -> Source | None:
        """The imported file; None until one is imported."""
        return self._state.source

    @property
    def up(self) -> Direction:
        """Direction in the coordinates of the imported file that points up and becomes y in the project."""
        return Y if self.source is None else self.source.reading.up or Y

    @property
    def mesh(self) -> Mesh | None:
        """The polygon mesh; None if none is imported, or if the imported file holds stitches."""
        return None if self.labeling is None else self.labeling.mesh

    @property
    def surface(self) -> Mesh | None:
        """The mesh after the repair that a search for rows needs; None where ``mesh`` is None."""
        return self._values.start.surface

    @property
    def repairs(self) -> tuple[RepairAction, ...]:
        """The changes that the repair has made to the surface."""
        return self._values.start.repairs

    @property
    def labeling(self) -> PartialLabeling | None:
        """The labeling of the mesh; None if there is no mesh."""
        return self._values.labeling

    @property
    def label_steps(self) -> tuple[LabelStep, ...]:
        """The steps that led to the labeling."""
        return steps_done(self._state.label_steps)

    @property
    def labeled(self) -> StitchMesh | None:
        """The labeled mesh; None until every face has a row."""
        return self._values.labeled

    @property
    def division(self) -> Division | None:
        """The values with which the labeled mesh was divided; None before it is divided."""
        return self._state.division

    @property
    def shaping(self) -> Shaping | None:
        """The options with which the stitches were found on the mesh without labels; None if they were not."""
        return None if self._state.shaped is None else self._state.shaped.shaping

    @property
    def fabric(self) -> StitchMesh | None:
        """The stitches with all edits; None before the mesh is divided or its rows are found."""
        return self._values.fabric

    @property
    def edits(self) -> tuple[Edit, ...]:
        """The edits that led to the fabric."""
        return steps_done(self._state.edits)

    @property
    def last_changes(self) -> tuple[Change, ...]:
        """The changes of the last edit, undo or redo, which made the present fabric, in their order."""
        return self._values.last_changes

    @property
    def evened(self) -> StitchMesh | None:
        """The fabric after mesh relaxation; None before it."""
        return self._state.results.evened

    @property
    def yarns(self) -> YarnSet | None:
        """The generated yarns; None until they are generated."""
        return self._state.results.yarns

    @property
    def yarn_settings(self) -> Mapping[str, Any] | None:
        """Settings with which the yarns were generated; None until they are generated."""
        return self._state.results.yarn_settings

    @property
    def relaxed(self) -> YarnSet | None:
        """The relaxed yarns; None until they are relaxed."""
        return self._state.results.relaxed

    @property
    def report(self) -> Mapping[str, Any] | None:
        """Figures of the relaxation; None until the yarns are relaxed."""
        return self._state.results.report

    @property
    def history(self) -> Sequence[HistoryEntry] | None:
        """Assessments of the relaxation; None until the yarns are relaxed."""
        return self._state.results.history

    @property
    def garment(self) -> GarmentMesh | None:
        """The imported mesh with the facts about its file; None if labels or stitches were imported."""
        return self._values.start.garment

    def import_mesh(self, name: str, content: bytes, unit: str = DEFAULT_UNIT) -> tuple[str, ...]:
        """Start again from a file: a polygon mesh, a labeled or partly labeled mesh, or stitches.

        Args:
            name: name of the file; its suffix decides the format.
            content: the bytes of the file.
            unit: unit of the coordinates in the file.

        Raises:
            StitchMeshError: the file cannot be read, or it holds yarns.
        """
        return self.read_source(source_of(name, content, unit))

    def read_source(self, imported: Source) -> tuple[str, ...]:
        """Start again from a file, which the value says how to read.

        Raises:
            StitchMeshError: an error of ``import_mesh``, or the file has no object of a chosen name.
        """
        source, values = _read(imported)
        return self._change(ProjectState(name=self.name, source=source, settings=self._state.settings), values)

    def apply_label_step(self, step: LabelStep) -> tuple[str, ...]:
        """Take a step of the labeling.

        Raises:
            StitchMeshError: there is no mesh, or the step is not possible.
        """
        return self._label(self._state.label_steps.do(step), self._values.with_label_step(step))

    @property
    def label_history(self) -> UndoHistory[LabelStep | None]:
        """The steps of the labeling, with those that were undone."""
        return self._state.label_steps

    def undo_label(self) -> tuple[str, ...]:
        """Undo the last step of the labeling.

        Raises:
            ParameterError: there is none.
        """
        before = self._state.label_steps.undo("undo: no step of the labeling is left to undo")
        return self._label(before, self._values.without_label_step())

    def redo_label(self) -> tuple[str, ...]:
        """Take the last undone step of the labeling again.

        Raises:
            ParameterError: there is none.
        """
        after = self._state.label_steps.redo("redo: no step of the labeling is left to redo")
        assert after.present is not None
        return self._label(after, self._values.with_label_step(after.present))

    def divide(self, division: Division, fabric: StitchMesh | None = None) -> tuple[str, ...]:
        """Divide the labeled mesh into stitches.

        Args:
            division: how the mesh is divided.
            fabric: the result of the division, if for example a worker thread has made it already.

        Raises:
            StitchMeshError: the mesh is not labeled, or it cannot be divided in this way.
        """
        values = self._values.divided(division, fabric)
        return self._change(with_division(self._state, division), values)

    def shape(self, shaping: Shaping, fabric: StitchMesh | None = None) -> tuple[str, ...]:
        """Find rows and stitches on the mesh, without labels.

        Args:
            shaping: the options for the search.
            fabric: the stitches, if for example a worker thread has found them already.

        Raises:
            StitchMeshError: there is no mesh, or no stitches can be found in this way.
        """
        if fabric is None and self.surface is not None:
            fabric = shaping.shape(self.surface).fabric
        if fabric is None:
            raise ParameterError("rows: there is no mesh to find rows on; import a polygon mesh first")
        state = with_shaped(self._state, ShapedStitches(shaping, fabric))
        return self._change(state, self._values.shaped(fabric))

    def apply_edit(self, edit: Edit) -> tuple[str, ...]:
        """Edit the fabric.

        Raises:
            StitchMeshError: there is no fabric, or the edit is not possible.
        """
        return self._edit(self._state.edits.do(edit), self._values.edited(edit))

    @property
    def edit_history(self) -> UndoHistory[Edit | None]:
        """The edits, with those that were undone."""
        return self._state.edits

    def undo(self) -> tuple[str, ...]:
        """Undo the last edit.

        Raises:
            ParameterError: there is none.
        """
        return self._edit(self._state.edits.undo("undo: no edit is left to undo"), self._values.undone())

    def redo(self) -> tuple[str, ...]:
        """Apply the last undone edit again.

        Raises:
            ParameterError: there is none.
        """
        after = self._state.edits.redo("redo: no edit is left to redo")
        assert after.present is not None
        return self._edit(after, self._values.edited(after.present))

    @property
    def can_restore(self) -> tuple[str, ...]:
        """The names of what ``restore`` brings back; empty if the last changes have dropped nothing."""
        return self._state.kept[0].made if self._state.kept else ()

    def restore(self) -> tuple[str, ...]:
        """Return to the state before the last change that dropped something; a second call leads back.

        Raises:
            ParameterError: no change has dropped anything.
        """
        if not self._state.kept:
            raise ParameterError("restore: nothing was dropped since the file was imported")
        last, *others = self._state.kept
        kept = (replace(self._state, kept=()), *others)
        state = replace(last, name=self.name, settings=self._state.settings, kept=kept)
        return self._change(state, StageValues.of(state))

    def set_evened(self, fabric: StitchMesh) -> tuple[str, ...]:
        """Set the fabric after mesh relaxation."""
        return self._change(replace(self._state, results=replace(NO_RESULTS, evened=fabric)), self._values)

    def set_yarns(self, yarns: YarnSet, settings: Mapping[str, Any]) -> tuple[str, ...]:
        """Set the generated yarns, and the settings of their generation.

        Raises:
            ParameterError: JSON cannot hold the settings.
        """
        kept = _plain("settings of the yarns", settings)
        state = with_results(self._state, yarns=yarns, yarn_settings=kept, relaxed=None, report=None, history=None)
        return self._change(state, self._values)

    def set_relaxed(
        self, yarns: YarnSet, report: Mapping[str, Any], history: Sequence[HistoryEntry]
    ) -> tuple[str, ...]:
        """Set the relaxed yarns, the figures and the assessments of their relaxation.

        Raises:
            ParameterError: JSON cannot hold the report.
        """
        state = with_results(self._state, relaxed=yarns, report=_plain("report", report), history=list(history))
        return self._change(state, self._values)

    def settings(self, page: str) -> dict[str, Any]:
        """Return the settings of a page; an empty dictionary if none were set."""
        return dict(self._state.settings.get(page, {}))

    def set_settings(self, page: str, values: Mapping[str, Any]) -> None:
        """Set the settings of a page.

        Raises:
            ParameterError: JSON cannot hold the settings.
        """
        kept = {**self._state.settings, page: _plain(f"settings of page {page}", values)}
        self._change(replace(self._state, settings=kept), self._values)

    def rename(self, name: str) -> None:
        """Give the project another name; its folder stays the same.

        Raises:
            ParameterError: the name is empty or longer than a line.
        """
        if not name.strip() or len(name) > 80 or not name.isprintable():
            raise ParameterError(f"name: got {name[:40]!r}; expected a text of 1 to 80 characters in one line")
        self._change(replace(self._state, name=name.strip()), self._values)

    def save(self) -> None:
        """Write the project now.

        Raises:
            FileError: the disk refuses it; autosave tries again.
        """
        self.autosave.changed(self._state)
        self.autosave.flush()

    def close(self) -> None:
        """Write the project, and release it for other programs.

        Raises:
            FileError: the disk refuses the project.
        """
        try:
            self.autosave.close()
        finally:
            self._lock.release()

    def _trouble(self, message: str | None) -> None:
        self.on_trouble(message)

    def _label(self, steps: UndoHistory[LabelStep | None], values: StageValues) -> tuple[str, ...]:
        state = with_label_steps(self._state, steps)
        return self._change(state, values.divided_as(state))

    def _edit(self, edits: UndoHistory[Edit | None], values: StageValues) -> tuple[str, ...]:
        """Take a change of the edits; results stay if only colours change, because colours move no yarn."""
        before, after, results = self.fabric, values.fabric, self._state.results
        assert before is not None and after is not None
        if not (changes_colours_only(values.last_changes) and keeps_yarn_routes(before, after)):
            results = NO_RESULTS
        elif results is not NO_RESULTS:
            results = recoloured(results, before, after)
        return self._change(with_edits(self._state, edits, results), values)

    def _change(self, state: ProjectState, values: StageValues) -> tuple[str, ...]:
        lost = dropped(self._state, state)
        self._state, self._values = state, values
        self.autosave.changed(state)
        return lost


def _check_holds_project(folder: Path) -> None:
    if not is_there(folder / TABLE_NAME):
        raise FileError(f"{folder}: holds no project; expected a folder with {TABLE_NAME}")


def _read(source: Source | None) -> tuple[Source | None, StageValues]:
    """Read an imported file; return it with the upward direction that was found, and the values of the project."""
    if source is None:
        return None, StageValues()
    start = read_source(source)
    up = source.reading.up if start.garment is None else start.garment.up
    return replace(source, reading=replace(source.reading, up=up)), StageValues.begin(start)


def _plain(what: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of values that JSON can hold.

    Raises:
        ParameterError: JSON cannot hold the values.
    """
    try:
        return check_value(parse_json(json.dumps(values, allow_nan=False)), dict[str, Any])
    except (TypeError, ValueError) as error:
        raise ParameterError(f"{what}: {error}; expected texts, numbers, lists and dictionaries") from error
