# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Projects that open at one page: a swatch in the designer, a file in the viewer, or a scene on the page Drape."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from stitchmesh.app.pages.drape.drape_session import FOLDER
from stitchmesh.app.pages.drape.opened_scene import scene_of_file
from stitchmesh.app.pages.drape.scene_run import same_scene
from stitchmesh.app.pages.swatch.state import Look, SwatchState, read_state, state_table
from stitchmesh.app.pages.view.opened import read_viewed
from stitchmesh.app.project.opening import new_project_folder, projects_folder, title_of
from stitchmesh.app.project.project import Project
from stitchmesh.app.project.project_folder import TABLE_NAME
from stitchmesh.errors import FileError, StitchMeshError
from stitchmesh.io.path_kind import is_folder
from stitchmesh.mixed.drape import SCENE_FILE
from stitchmesh.mixed.scene.scene import write_scene
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch_design import SwatchDesign

SWATCH, VIEW, EDIT, DRAPE = "Swatch", "View", "Edit", "Drape"
"""Names of the pages."""


def swatch_project(pattern: str, **dials: float) -> Project:
    """Open a project whose page Swatch shows a pattern: a project with exactly this design, or a new one.

    Args:
        pattern: name of a pattern or of a weave, or the path of a file.
        dials: values of dials of the design (``SwatchDials``).

    Raises:
        StitchMeshError: the pattern cannot be read, or a value is out of bounds.
    """
    source = resolve_pattern(pattern)
    design = SwatchDesign(source)
    wanted = SwatchState((design.turned(**dials),), look=Look().fitted(source))
    name = title_of(source.name)
    for path in sorted(projects_folder().glob(f"*/{TABLE_NAME}")):
        project = _holding(path.parent, wanted)
        if project is not None:
            return project
    project = Project.create(new_project_folder(name), name)
    project.set_settings(SWATCH, state_table(wanted))
    return project


def view_project(path: str) -> Project:
    """Open a project whose page View shows a file or the folder of a running job.

    Raises:
        StitchMeshError: there is no such file or folder, or the file cannot be read.
    """
    if not is_folder(path):
        read_viewed(Path(path))  # An unreadable file is refused before a project is made.
    try:
        project = Project.open_or_create(projects_folder() / VIEW)
    except FileError:  # Another program already shows a file.
        project = Project.create(new_project_folder(VIEW))
    project.set_settings(VIEW, {**project.settings(VIEW), "show": "Opened file", "path": str(Path(path).absolute())})
    return project


def drape_project(path: Path) -> Project:
    """Open a project whose page Drape shows a scene, or a new scene with the cloth of a file.

    The project is one that already holds exactly this scene, or a new one.

    Raises:
        StitchMeshError: the file cannot be read.
    """
    scene = scene_of_file(path)
    for kept in sorted(projects_folder().glob(f"*/{FOLDER}/{SCENE_FILE}")):
        if same_scene(kept, scene):
            try:
                return Project.open(kept.parent.parent)
            except StitchMeshError:
                continue  # Another program uses the project, or it is damaged.
    project = Project.create(new_project_folder(title_of(path.name)), title_of(path.name))
    write_scene(project.folder / FOLDER / SCENE_FILE, scene)
    return project


def _holding(folder: Path, wanted: SwatchState) -> Project | None:
    """Return the project of a folder if its page Swatch shows the wanted design."""
    try:
        project = Project.open(folder)
    except StitchMeshError:
        return None  # Another program uses the project, or it is damaged.
    try:
        state = read_state(project.settings(SWATCH)) if project.settings(SWATCH) else None
    except StitchMeshError:
        state = None
    if state is not None and replace(state, charts=()) == replace(wanted, charts=()):
        return project
    project.close()
    return None
