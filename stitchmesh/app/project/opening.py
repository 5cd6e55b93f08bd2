# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which project a start of the application opens: that of a folder, that of a file, or the last one."""

from __future__ import annotations

from pathlib import Path

from stitchmesh.app.project.project import Project
from stitchmesh.app.project.project_folder import TABLE_NAME, stored_source
from stitchmesh.app.project.recent import new_project_folder, projects_folder, recent_projects
from stitchmesh.app.project.source import source_of
from stitchmesh.errors import FileError, StitchMeshError
from stitchmesh.io.contents import FilePath, read_bytes
from stitchmesh.io.examples import mesh_file
from stitchmesh.io.path_kind import is_folder
from stitchmesh.io.units import DEFAULT_UNIT

FIRST_NAME = "Garment"
"""Name of the first project of all."""


def project_for(file: FilePath | None = None, folder: FilePath | None = None, unit: str = DEFAULT_UNIT) -> Project:
    """Open the project that a user asks for at the start.

    Args:
        file: a mesh or stitches, the name of an example, or the folder of a project. A file that a project was started
            from opens that project again; another file starts a new project.
        folder: folder of the project; it is made if it is missing.
        unit: unit of the coordinates in the file.

    Returns:
        The project; without file and folder, the one that was open last, or an empty one.

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
    """Return the name of a project for the name of a file."""
    return Path(name.replace("\\", "/")).stem.replace("_", " ").strip()[:40] or FIRST_NAME


def _in_folder(folder: Path, file: FilePath | None, unit: str) -> Project:
    source = None if file is None else source_of(Path(file).name, read_bytes(file), unit)
    if not (folder / TABLE_NAME).exists():
        return Project.create(folder, source=source)
    project = Project.open(folder)
    if source is None:
        return project
    try:
        if project.source is None:
            project.import_mesh(source.name, source.content, unit)
        elif project.source.content != source.content:
            found = f"holds a project of {project.source.name}"
            raise FileError(f"{folder}: {found}, whose content is another one; give another --project, or no file")
    except StitchMeshError:
        project.close()
        raise
    return project


def _of_file(file: Path, unit: str) -> Project:
    content = read_bytes(file)
    known = [one.folder for one in recent_projects()]
    known += sorted(path.parent for path in projects_folder().glob(f"*/{TABLE_NAME}"))
    for folder in known:
        if stored_source(folder) == content:
            return Project.open(folder)
    title = title_of(file.name)
    return Project.create(new_project_folder(title), title, source_of(file.name, content, unit))
