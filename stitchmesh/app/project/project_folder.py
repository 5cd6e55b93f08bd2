# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The folder of a project on disk, and the table in it.

``project.json`` holds the table of the project and the names of the files in ``files``. A result is written to a file
with a new name, and then a new ``project.json`` replaces the old one in one step. If the process is killed at any
moment, the project is therefore in its state before or after the write. Files that no table names are removed later.
"""

from __future__ import annotations

import contextlib
import json
import re
import shutil
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from stitchmesh.app.project.division import division_of, division_table
from stitchmesh.app.project.shaping import ShapedStitches, shaping_of, shaping_table
from stitchmesh.app.project.source import Source
from stitchmesh.app.project.state import NO_EDITS, NO_RESULTS, ProjectState, Results
from stitchmesh.editing.edit import Edit
from stitchmesh.editing.undo_history import history_of_steps, steps_done, steps_undone
from stitchmesh.errors import FileError, ParameterError, StitchMeshError
from stitchmesh.io.atomic import write_bytes, write_text
from stitchmesh.io.checked import check_value, read_json
from stitchmesh.io.contents import read_bytes
from stitchmesh.io.disk_refusal import refusal
from stitchmesh.io.history import HistoryEntry
from stitchmesh.io.mesh_reading import MeshReading
from stitchmesh.io.stitches import read_stitches, write_stitches
from stitchmesh.io.yarns import read_yarns, write_yarns
from stitchmesh.labeling.steps import LabelStep
from stitchmesh.mesh.upright import Direction, Y

FORMAT = "stitchmesh project"
"""Value of the key ``format`` of every project."""
VERSION = 1
"""Newest version of the table that this program reads and writes."""
Step = tuple[str, dict[str, Any]]
"""Name and arguments of a labeling step or of an edit."""


@dataclass(frozen=True, kw_only=True)
class WorkTable:
    """The work of the user, without the imported file."""

    label_steps: list[Step] = field(default_factory=list)
    undone_label_steps: list[Step] = field(default_factory=list)
    division: dict[str, Any] | None = None
    shaping: dict[str, Any] | None = None
    edits: list[Step] = field(default_factory=list)
    undone_edits: list[Step] = field(default_factory=list)
    files: dict[str, str] = field(default_factory=dict)
    """Names of the files of the stitches that were found on the mesh, and of each result, by the names of the
    fields."""
    yarn_settings: dict[str, Any] | None = None


@dataclass(frozen=True, kw_only=True)
class SourceTable(MeshReading):
    """The imported file, and how it is read."""

    name: str
    file: str
    """Name of the file in the project that holds the same bytes."""
    up: Direction | None = Y
    """Direction in the coordinates of the file that points up; files of earlier versions are upright."""


@dataclass(frozen=True, kw_only=True)
class ProjectTable:
    """A project."""

    format: str
    version: int
    name: str
    source: SourceTable | None = None
    work: WorkTable = field(default_factory=WorkTable)
    kept: list[WorkTable] = field(default_factory=list)
    settings: dict[str, dict[str, Any]] = field(default_factory=dict)


def work_table(state: ProjectState, files: Mapping[str, str]) -> WorkTable:
    """Return the table of the user's work; ``files`` holds the names of the files that belong to it."""
    settings = state.results.yarn_settings
    return WorkTable(
        label_steps=_steps(steps_done(state.label_steps)),
        undone_label_steps=_steps(steps_undone(state.label_steps)),
        division=None if state.division is None else division_table(state.division),
        shaping=None if state.shaped is None else shaping_table(state.shaped.shaping),
        edits=_steps(steps_done(state.edits)),
        undone_edits=_steps(steps_undone(state.edits)),
        files=dict(files),
        yarn_settings=None if settings is None else dict(settings),
    )


def work_fields(table: WorkTable) -> dict[str, Any]:
    """Return the fields of a state from a table, without those that are in files.

    Raises:
        ParameterError: the division has another form.
    """
    return {
        "label_steps": history_of_steps(
            [LabelStep(*step) for step in table.label_steps], [LabelStep(*step) for step in table.undone_label_steps]
        ),
        "division": None if table.division is None else division_of(table.division),
        "edits": history_of_steps(
            [Edit(*edit) for edit in table.edits], [Edit(*edit) for edit in table.undone_edits]
        ),
    }


def _steps(steps: tuple[LabelStep, ...] | tuple[Edit, ...]) -> list[Step]:
    return [(step.name, dict(step.arguments)) for step in steps]


TABLE_NAME = "project.json"
"""Name of the file with the table."""
FILES = "files"
"""Name of the folder with the files that the table names."""
OWN_FOLDERS = ("checkpoint", "bodies", "drape")
"""Names of the other folders of a project: checkpoints of its relaxation, bodies of its yarns, and its scene."""


@dataclass(frozen=True)
class ResultFormat:
    """The format of the file of one value."""

    suffix: str
    write: Callable[[Path, Any], None]
    read: Callable[[Path], Any]


def _write_plain(path: Path, value: object) -> None:
    write_text(path, json.dumps(value, indent=2) + "\n")


def _read_history(path: Path) -> list[HistoryEntry]:
    return check_value(read_json(path), list[HistoryEntry])


SHAPED = "shaped"
"""Name, among the files, of the stitches that were found on the mesh."""
RESULT_FORMATS: Mapping[str, ResultFormat] = {
    SHAPED: ResultFormat(".h5", write_stitches, read_stitches),
    "evened": ResultFormat(".h5", write_stitches, read_stitches),
    "yarns": ResultFormat(".h5", write_yarns, read_yarns),
    "relaxed": ResultFormat(".h5", write_yarns, read_yarns),
    "report": ResultFormat(".json", _write_plain, read_json),
    "history": ResultFormat(".json", _write_plain, _read_history),
}
"""Formats of the values that have files of their own: the stitches found on the mesh, and fields of ``Results``."""
SOURCE = "source"
"""Name, among the files, of the imported file."""
OWN_NAME = re.compile(rf"({'|'.join([SOURCE, *RESULT_FORMATS])})-\d+(\.[a-z0-9]+)?")
"""Form of the names of the files."""


class ProjectFolder:
    """Reads and writes the states of a project; a value that is on disk already is not written again."""

    def __init__(self, folder: Path) -> None:
        """Use a folder, which need not exist before the first write."""
        self.folder = folder
        self._written: dict[str, object] = {}
        """The value in each file that was written or read."""
        self._number = 0

    @property
    def table_path(self) -> Path:
        """The file with the table."""
        return self.folder / TABLE_NAME

    def write(self, state: ProjectState) -> None:
        """Write a state; whenever the process ends, the folder holds the state before or this state.

        Raises:
            FileError: a file cannot be written; the folder then holds the state before.
        """
        named: dict[str, object] = {}
        table = ProjectTable(
            format=FORMAT, version=VERSION, name=state.name, source=self._source_table(state.source, named),
            work=self._work_table(state, named),
            kept=[self._work_table(kept, named) for kept in state.kept],
            settings={page: dict(values) for page, values in state.settings.items()},
        )  # fmt: skip
        write_text(self.table_path, json.dumps(asdict(table), indent=1, allow_nan=False) + "\n")
        self._written = named
        self._remove_unnamed()

    def read(self) -> tuple[ProjectState, tuple[str, ...]]:
        """Read the state of the folder, and return with it a line for each damaged result that was left out.

        Raises:
            FileError: there is no project, or its table or its imported file is damaged.
        """
        table = self._table()
        self._written, notes = {}, list[str]()
        try:
            state = ProjectState(
                name=table.name, source=self._read_source(table.source), settings=table.settings,
                **self._read_work(table.work, notes),
            )  # fmt: skip
            kept = [ProjectState(name=table.name, source=state.source, **self._read_work(work, notes))
                    for work in table.kept]  # fmt: skip
            state = replace(state, kept=tuple(kept))
        except ParameterError as error:
            raise FileError(f"{self.table_path}: {error}") from error
        self._number = max((_number(name) for name in self._names()), default=0)
        return state, tuple(notes)

    def delete(self) -> None:
        """Remove all files of the program from the folder of a project, the table last.

        Raises:
            FileError: something cannot be removed; the project is then still in the list.
        """
        try:
            for name in (*OWN_FOLDERS, FILES):
                shutil.rmtree(self.folder / name, ignore_errors=True)
            self.table_path.unlink()
        except OSError as error:
            raise FileError(f"{self.folder}: cannot be removed {refusal(error)}") from error

    def _table(self) -> ProjectTable:
        try:
            table = check_value(read_json(self.table_path), ProjectTable)
        except ParameterError as error:
            raise FileError(f"{self.table_path}: {error}; expected the table of a project") from error
        if table.format != FORMAT or not 1 <= table.version <= VERSION:
            found = f"{table.format!r}, version {table.version}"
            raise FileError(f"{self.table_path}: is {found}; expected {FORMAT!r}, version 1 to {VERSION}")
        return table

    def _source_table(self, source: Source | None, named: dict[str, object]) -> SourceTable | None:
        if source is None:
            return None
        write = lambda path, value: write_bytes(path, value.content)  # noqa: E731
        file = self._file_of(source, SOURCE, Path(source.name).suffix.lower(), write, named)
        return SourceTable(name=source.name, file=file, **vars(replace(source.reading, up=source.reading.up or Y)))

    def _work_table(self, state: ProjectState, named: dict[str, object]) -> WorkTable:
        files: dict[str, str] = {}
        for kind, form in RESULT_FORMATS.items():
            value = _value_of(state, kind)
            if value is not None:
                files[kind] = self._file_of(value, kind, form.suffix, form.write, named)
        return work_table(state, files)

    def _file_of(
        self, value: object, kind: str, suffix: str, write: Callable[[Path, Any], None], named: dict[str, object]
    ) -> str:
        """Return the name of the file that holds a value; write the file if it does not exist."""
        found = [name for name, held in self._written.items()
                 if held is value and name.startswith(kind) and self._path(name).is_file()]  # fmt: skip
        if not found:
            self._number += 1
            found = [f"{kind}-{self._number}{suffix}"]
            write(self.folder / FILES / found[0], value)
            self._written[found[0]] = value  # If the next file is refused, this one need not be written again.
        named[found[0]] = value
        return found[0]

    def _read_source(self, table: SourceTable | None) -> Source | None:
        if table is None:
            return None
        reading = MeshReading(**{part.name: getattr(table, part.name) for part in fields(MeshReading)})
        source = Source(Path(table.name).name, read_bytes(self._path(table.file)), reading)
        self._written[table.file] = source
        return source

    def _read_work(self, table: WorkTable, notes: list[str]) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for kind, name in table.files.items():
            if kind not in RESULT_FORMATS:
                raise ParameterError(f"files has no key {kind!r}; the keys are {', '.join(RESULT_FORMATS)}")
            try:
                values[kind] = self._read_result(name, RESULT_FORMATS[kind])
            except StitchMeshError as error:
                notes.append(f"{kind} left out: {error}")
        if table.yarn_settings is not None:
            values["yarn_settings"] = table.yarn_settings
        fabric = values.pop(SHAPED, None)
        if table.shaping is not None and fabric is None:  # Nothing that follows from the lost stitches remains.
            return {**work_fields(table), "edits": NO_EDITS}
        shaped = None if table.shaping is None else ShapedStitches(shaping_of(table.shaping), fabric)
        return {**work_fields(table), "shaped": shaped, "results": Results(**values) if values else NO_RESULTS}

    def _read_result(self, name: str, form: ResultFormat) -> object:
        """Return the value of a file; a file that two tables name is read once."""
        if name not in self._written:
            self._written[name] = form.read(self._path(name))
        return self._written[name]

    def _path(self, name: str) -> Path:
        """Return the path of a file that the table names.

        Raises:
            ParameterError: the name is not the name of a file in the folder of the files.
        """
        if OWN_NAME.fullmatch(name) is None:
            raise ParameterError(f"file {name!r}: is no file of a project; expected a name such as yarns-3.h5")
        return self.folder / FILES / name

    def _names(self) -> list[str]:
        """Return the names of the project's own files; files that a user has put beside them do not count."""
        files = self.folder / FILES
        inside = files.iterdir() if files.is_dir() and not files.is_symlink() else ()
        return [path.name for path in inside if OWN_NAME.fullmatch(path.name)]

    def _remove_unnamed(self) -> None:
        for name in self._names():
            if name not in self._written:
                with contextlib.suppress(OSError):  # A later write removes it.
                    (self.folder / FILES / name).unlink()


def _value_of(state: ProjectState, kind: str) -> object:
    """Return the value that a state holds for a file; None if it holds none."""
    if kind == SHAPED:
        return None if state.shaped is None else state.shaped.fabric
    return getattr(state.results, kind)


def stored_source(folder: Path) -> Source | None:
    """Return the file from which the project in a folder was started; None if it cannot be read."""
    store = ProjectFolder(folder)
    try:
        return store._read_source(store._table().source)
    except StitchMeshError:
        return None


def _number(name: str) -> int:
    found = re.search(r"-(\d+)", name)
    return int(found[1]) if found else 0
