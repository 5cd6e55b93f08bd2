# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The states of a project as tables that JSON can hold.

The tables hold no meshes, stitches and yarns, but the names of their files.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from stitchmesh.app.project.division import division_of, division_table
from stitchmesh.app.project.shaping import shaping_table
from stitchmesh.app.project.state import ProjectState
from stitchmesh.editing.edit import Edit
from stitchmesh.editing.undo_history import history_of_steps, steps_done, steps_undone
from stitchmesh.io.mesh_reading import MeshReading
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
