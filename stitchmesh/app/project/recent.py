# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where projects are, and which ones were open last."""

from __future__ import annotations

import json
import os
import re
from dataclasses import dataclass
from pathlib import Path

from stitchmesh.app.preferences import state_folder
from stitchmesh.app.project.project import Project
from stitchmesh.app.project.project_folder import TABLE_NAME
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.checked import check_value
from stitchmesh.io.json_file import read_json
from stitchmesh.io.path_kind import is_file, is_there

MOST_RECENT = 12
"""Number of projects that are remembered."""
LONGEST_NAME = 60
"""Largest number of characters in the name of a new project."""


@dataclass(frozen=True)
class RecentProject:
    """A project that was open."""

    folder: Path
    """Folder of the project."""
    name: str
    """Name of the project when it was open."""


def projects_folder() -> Path:
    """Return the folder of new projects: that of the variable ``STITCHMESH_PROJECTS``, else StitchMesh in the home."""
    return Path(os.environ.get("STITCHMESH_PROJECTS") or Path.home() / "StitchMesh")


def new_project_folder(name: str) -> Path:
    """Return a folder for a new project that does not exist yet; a number is added to its name if it exists.

    Args:
        name: name of the project; characters that a folder should not have become hyphens.

    Raises:
        ParameterError: the name has no letter and no digit, or is too long.
    """
    plain = re.sub(r"[^\w.-]+", "-", name).strip("-.")
    if not plain or len(name) > LONGEST_NAME:
        raise ParameterError(f"name: got {name[:LONGEST_NAME]!r}; expected letters or digits, at most {LONGEST_NAME}")
    folder, number = projects_folder() / plain, 2
    while is_there(folder):
        folder, number = projects_folder() / f"{plain}-{number}", number + 1
    return folder


def recent_projects() -> list[RecentProject]:
    """Return the projects that were open, the last one first; projects whose folders are gone are left out."""
    try:
        entries = check_value(read_json(_list_path()), list[dict[str, str]])
        found = [RecentProject(Path(entry["folder"]), entry["name"]) for entry in entries]
        return [project for project in found if is_file(project.folder / TABLE_NAME)]
    except (StitchMeshError, KeyError):
        return []  # The list is a convenience: a damaged one is made anew.


def remember(project: Project) -> None:
    """Put a project first in the list; a list that cannot be written is left as it is."""
    others = [one for one in recent_projects() if one.folder != project.folder]
    entries = [RecentProject(project.folder, project.name), *others][:MOST_RECENT]
    text = json.dumps([{"folder": str(one.folder), "name": one.name} for one in entries], indent=1)
    try:
        write_text(_list_path(), text + "\n")
    except StitchMeshError:
        return


def _list_path() -> Path:
    return state_folder() / "projects.json"
