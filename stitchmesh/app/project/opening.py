# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where projects are, what the program remembers between its starts, and which project opens at the start."""

from __future__ import annotations

import contextlib
import json
import os
import re
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np

from stitchmesh.app.project.project import Project
from stitchmesh.app.project.project_folder import TABLE_NAME, stored_source
from stitchmesh.app.project.source import source_of
from stitchmesh.errors import FileError, ParameterError, StitchMeshError
from stitchmesh.io.atomic import write_json, write_text
from stitchmesh.io.checked import check_value, read_json
from stitchmesh.io.contents import FilePath, read_bytes
from stitchmesh.io.examples import mesh_file
from stitchmesh.io.path_kind import is_file, is_folder, is_there
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.mesh import BORDER, Mesh


def state_folder() -> Path:
    """Return the folder that keeps data between the starts of the program."""
    state = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(state) / "stitchmesh"


def prefers_dark() -> bool:
    """Return whether the user has chosen dark colours; a damaged file means light ones."""
    try:
        return check_value(read_json(_preferences_path()), dict[str, bool]).get("dark", False)
    except StitchMeshError:
        return False


def keep_dark(dark: bool) -> None:
    """Keep the choice; if the folder cannot be written, the earlier choice stays."""
    with contextlib.suppress(StitchMeshError):
        write_json(_preferences_path(), {"dark": dark})


def _preferences_path() -> Path:
    return state_folder() / "preferences.json"


MOST_LINES = 400
"""Largest number of lines in the outline of a garment."""
OUTLINE = re.compile(r"(M-?\d{1,3} -?\d{1,3}L-?\d{1,3} -?\d{1,3})*")
LONGEST_NAME = 60
"""Largest number of characters in the name of a new project."""


@dataclass(frozen=True)
class RecentProject:
    """A project that was open."""

    folder: Path
    """Folder of the project."""
    name: str
    """Name of the project when it was open."""
    outline: str = ""
    """Its garment from the front, as an SVG path in a square of 100 units; empty without a garment."""

    @property
    def changed(self) -> datetime:
        """When the project was changed last.

        Raises:
            OSError: the project is gone.
        """
        return datetime.fromtimestamp((self.folder / TABLE_NAME).stat().st_mtime)


def projects_folder() -> Path:
    """Return the folder of new projects: the variable ``STITCHMESH_PROJECTS`` names it, else StitchMesh in the home."""
    return Path(os.environ.get("STITCHMESH_PROJECTS") or Path.home() / "StitchMesh")


def new_project_folder(name: str) -> Path:
    """Return a folder for a new project that does not exist yet; its name gets a number if another exists.

    Args:
        name: name of the project; characters that do not suit a folder become hyphens.

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
    """Return the projects that were open, the last one first; projects without a folder are left out."""
    try:
        entries = check_value(read_json(_list_path()), list[dict[str, str]])
        found = [RecentProject(Path(entry["folder"]), entry["name"], _checked(entry.get("outline", "")))
                 for entry in entries]  # fmt: skip
        return [project for project in found if is_file(project.folder / TABLE_NAME)]
    except (StitchMeshError, KeyError):
        return []  # The list is a convenience: a damaged list begins anew.


def remember(project: Project) -> None:
    """Put a project first in the list; if the list cannot be written, it stays as it is."""
    others = [one for one in recent_projects() if one.folder != project.folder]
    mesh = project.evened or project.fabric or project.mesh
    entries = [RecentProject(project.folder, project.name, "" if mesh is None else outline_of(mesh)), *others]
    table = [{"folder": str(one.folder), "name": one.name, "outline": one.outline} for one in entries[:12]]
    text = json.dumps(table, indent=1)
    try:
        write_text(_list_path(), text + "\n")
    except StitchMeshError:
        return


def outline_of(mesh: Mesh) -> str:
    """Return the borders and the outline of a garment from the front as an SVG path, in a square of 100 units.

    An edge belongs to the outline if one of its faces looks to the front and the other to the back.
    """
    towards = mesh.face_vector_area[:, 2] > 0.0
    side = mesh.edge_side
    other = mesh.twin[side]
    shown = side[(other == BORDER) | (towards[mesh.side_face[side]] != towards[mesh.side_face[other]])]
    shown = shown[:: len(shown) // MOST_LINES + 1]
    low, size = mesh.vertices.min(axis=0), float(np.ptp(mesh.vertices[:, :2], axis=0).max()) or 1.0
    place = np.rint(100.0 * (mesh.vertices[:, :2] - low[:2]) / size).astype(int)
    ends = place[mesh.face_vertex[np.stack([shown, mesh.side_next[shown]], axis=1)]]
    return "".join(f"M{x} {100 - y}L{u} {100 - v}" for (x, y), (u, v) in ends.tolist())


def _checked(outline: str) -> str:
    """Return a path from a file; an empty text if ``outline_of`` cannot have made it."""
    return outline if OUTLINE.fullmatch(outline) else ""


def _list_path() -> Path:
    return state_folder() / "projects.json"


FIRST_NAME = "Garment"
"""Name of the first project of all."""


def project_for(file: FilePath | None = None, folder: FilePath | None = None, unit: str | None = None) -> Project:
    """Open the project that the user asks for at the start.

    Args:
        file: a mesh or stitches, the name of an example, or the folder of a project. If a project was started from this
            file, that project opens again, unless it has another unit than the given one; otherwise a new project
            starts.
        folder: folder of the project; a missing one is made.
        unit: unit of the coordinates in the file; None for centimetres, or for the unit of the file's project.

    Returns:
        The project; without file and folder, the last open project, or an empty one.

    Raises:
        StitchMeshError: the project cannot be opened, the file cannot be read, or the folder holds a project that was
            started from another file.
    """
    if file is not None and is_folder(file):
        return Project.open(Path(file))
    file = None if file is None else mesh_file(file)
    if folder is not None:
        return _in_folder(Path(folder), file, unit)
    if file is not None:
        return _of_file(Path(file), unit)
    recent = recent_projects()
    return Project.open(recent[0].folder) if recent else Project.create(new_project_folder(FIRST_NAME), FIRST_NAME)


def title_of(name: str) -> str:
    """Return the name of a project from the name of a file."""
    return Path(name.replace("\\", "/")).stem.replace("_", " ").strip()[:40] or FIRST_NAME


def _in_folder(folder: Path, file: FilePath | None, unit: str | None) -> Project:
    source = None if file is None else source_of(Path(file).name, read_bytes(file), unit or DEFAULT_UNIT)
    if not is_there(folder / TABLE_NAME):
        return Project.create(folder, source=source)
    project = Project.open(folder)
    if source is None:
        return project
    try:
        if project.source is None:
            project.read_source(source)
        elif project.source.content != source.content:
            found = f"holds a project of {project.source.name}"
            raise FileError(f"{folder}: {found}, whose content is another one; give another --project, or no file")
        elif unit not in (None, project.source.reading.unit):
            found = f"holds a project of {project.source.name} in {project.source.reading.unit}"
            raise FileError(f"{folder}: {found}; leave --unit out, or give another --project")
    except StitchMeshError:
        project.close()
        raise
    return project


def _of_file(file: Path, unit: str | None) -> Project:
    content = read_bytes(file)
    known = [one.folder for one in recent_projects()]
    known += sorted(path.parent for path in projects_folder().glob(f"*/{TABLE_NAME}"))
    for folder in known:
        stored = stored_source(folder)
        if stored is not None and stored.content == content and unit in (None, stored.reading.unit):
            return Project.open(folder)
    title = title_of(file.name)
    return Project.create(new_project_folder(title), title, source_of(file.name, content, unit or DEFAULT_UNIT))
