# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Chooses the project that opens at the start: the project of a folder or of a file, or the last project."""

from __future__ import annotations

from pathlib import Path

from stitchmesh.app.project.project import Project
from stitchmesh.app.project.project_folder import TABLE_NAME, stored_source
from stitchmesh.app.project.recent import new_project_folder, projects_folder, recent_projects
from stitchmesh.app.project.source import source_of
from stitchmesh.errors import FileError, StitchMeshError
from stitchmesh.io.contents import FilePath, read_bytes
from stitchmesh.io.examples import mesh_file
from stitchmesh.io.path_kind import is_folder, is_there
from stitchmesh.io.units import DEFAULT_UNIT

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
