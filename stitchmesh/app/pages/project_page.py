# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Project: open and import, what the project holds, downloads, and other projects."""

from __future__ import annotations

import threading
from functools import cache
from typing import TYPE_CHECKING, ClassVar

from stitchmesh.app.pages.not_yet import draw_plainly
from stitchmesh.app.pages.page import Page
from stitchmesh.app.pages.project_text import download_list, project_summary, recent_list
from stitchmesh.app.project.exports import Export, exports
from stitchmesh.app.project.opening import title_of
from stitchmesh.app.project.project import Project
from stitchmesh.app.project.recent import new_project_folder, recent_projects, remember
from stitchmesh.app.project.source import Source, read_source, source_of
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.io.examples import example_names, read_example
from stitchmesh.io.meshes import FORMATS as MESH_FORMATS
from stitchmesh.io.units import CENTIMETRES, DEFAULT_UNIT
from stitchmesh.labeling.faults import triangles_message
from stitchmesh.markup import Markup
from stitchmesh.mesh import Mesh

if TYPE_CHECKING:
    from stitchmesh.app.application import App

SUFFIXES = (*MESH_FORMATS, ".h5", ".smobj", ".st")
"""Suffixes of the files that a project can start from."""
PREVIEW_OPACITY = 0.5
"""Opacity of an example that is only looked at."""


class ProjectPage(Page):
    """Shows the project, and changes to other ones."""

    name: ClassVar[str] = "Project"
    hint: ClassVar[str] = "Import a mesh, or drop its file here. Or take an example."

    def __init__(self, app: App) -> None:
        """Make the page."""
        super().__init__(app)
        self._unit = DEFAULT_UNIT
        self._new_name = "Garment"
        self._drawn: Mesh | None = None
        self._files: list[Export] = []
        names = example_names()
        self._example = "hat" if "hat" in names else "".join(names[:1])

    def build(self) -> None:
        """Make the controls, and draw what the project holds."""
        remember(self.app.project)
        controls = self.app.controls
        self._summary = controls.html(Markup())
        self._next = controls.button("Go on", "Open the page of the next step.", self._go_on, main=True)
        self._restore = controls.button("Bring back", "Return to what the last change dropped.", self._bring_back)
        with controls.group("Start from"):
            self._make_start()
        with controls.group("Download", opened=False):
            self._downloads = controls.html(Markup(), self._clicked)
        with controls.group("Projects", opened=False):
            controls.text("Name", "Name of this project.", self.app.project.name, self._rename)
            controls.text("New name", "Name of the new project.", self._new_name, self._set_new_name)
            controls.button("New project", "Start an empty project; this one stays saved.", self._new_project)
            self._recent = controls.html(Markup(), self._clicked)
        self._drawn = None
        self.refresh()

    def refresh(self) -> None:
        """Show the project."""
        project = self.app.project
        self._summary.content = project_summary(project)
        self._next.visible = project.source is not None
        self._next.label = f"Go on: {next_page(project)}"
        restored = ", ".join(project.can_restore)
        self._restore.visible = bool(restored)
        self._restore.label = f"Bring back: {restored}"
        self._files = exports(project)
        self._downloads.content = download_list(self._files)
        self._recent.content = recent_list(recent_projects(), project.folder)
        self._draw()

    def import_file(self, name: str, content: bytes) -> None:
        """Start from a file: in this project if it is empty, else in a new one.

        Raises:
            StitchMeshError: the file cannot be read; the projects stay as they are.
        """
        if self.app.project.source is None:
            self._import_here(name, content)
            return
        title = title_of(name)
        project = Project.create(new_project_folder(title), title, source_of(name, content, self._unit))
        self._change_to(project)
        self.app.notice(f"{project.name} is a new project; the project before is saved.")
        self.app.open_page(next_page(project))

    def _make_start(self) -> None:
        controls = self.app.controls
        controls.choice(
            "Unit", "Unit of the coordinates in the file; files that state their unit need cm here.",
            tuple(CENTIMETRES), self._unit, self._set_unit,
        )  # fmt: skip
        controls.upload("Import a mesh", "Choose a mesh of a garment, or stitches; or drop a file anywhere.", SUFFIXES,
                        self.import_file)  # fmt: skip
        names = example_names()
        if names:
            controls.choice("Example", "A garment that comes with the program.", names, self._example,
                            self._set_example)  # fmt: skip
            controls.button("Take the example", "Start from the chosen garment.", self._take_example)

    def _import_here(self, name: str, content: bytes) -> None:
        project = self.app.project
        project.import_mesh(name, content, self._unit)
        if project.name == project.folder.name:
            project.rename(title_of(name))
        self.app.open_page(next_page(project))

    def _take_example(self) -> None:
        unit, self._unit = self._unit, DEFAULT_UNIT
        try:
            self.import_file(*read_example(self._example))
        finally:
            self._unit = unit

    def _set_unit(self, unit: str) -> None:
        self._unit = unit

    def _set_example(self, name: str) -> None:
        self._example = name
        self._draw()

    def _set_new_name(self, name: str) -> None:
        self._new_name = name

    def _rename(self, name: str) -> None:
        self.app.project.rename(name)
        remember(self.app.project)

    def _new_project(self) -> None:
        self._change_to(Project.create(new_project_folder(self._new_name), self._new_name.strip()))

    def _change_to(self, project: Project) -> None:
        self.app.set_project(project)
        self.app.open_page(self.name)

    def _go_on(self) -> None:
        self.app.open_page(next_page(self.app.project))

    def _bring_back(self) -> None:
        self.app.project.restore()
        self.app.refresh()

    def _clicked(self, action: str, value: str) -> None:
        if action == "download":
            self._download(value)
        elif action == "open":
            self._open_recent(value)

    def _open_recent(self, place: str) -> None:
        projects = recent_projects()
        if not place.isdecimal() or int(place) >= len(projects):
            raise ParameterError("open: the list of projects has changed; look at it again")
        self._change_to(Project.open(projects[int(place)].folder))

    def _download(self, name: str) -> None:
        """Send a file; it is written in a thread of its own, because large files take seconds."""
        found = [file for file in self._files if file.name == name]
        if not found:
            raise ParameterError(f"download {name!r}: the project does not hold it any more")
        asked = found[0], self.app.front.acting_client
        threading.Thread(target=self._send, args=asked, name=f"download of {name}", daemon=True).start()

    def _send(self, file: Export, client: int | None) -> None:
        try:
            content = file.content()
        except StitchMeshError as error:
            self.app.post(self.app.report, error)
        else:
            self.app.post(self.app.download, file.name, content, client)

    def _draw(self) -> None:
        """Draw the newest stitches or the mesh; in an empty project the chosen example, pale."""
        project = self.app.project
        mesh = project.evened or project.fabric or project.mesh
        opacity = 1.0
        if mesh is None and self._example:
            mesh, opacity = _example_mesh(self._example), PREVIEW_OPACITY
        if mesh is None or mesh is self._drawn:
            return
        self._drawn = mesh
        draw_plainly(self.app.scene, mesh, opacity)


@cache
def _example_mesh(name: str) -> Mesh | None:
    """Return the mesh of an example."""
    return read_source(Source(*read_example(name))).mesh


def next_page(project: Project) -> str:
    """Return the page of the step that a project needs next."""
    if project.source is None:
        return "Project"
    if project.relaxed is not None:
        return "View"
    if project.evened is not None or project.yarns is not None:
        return "Yarns"
    if project.fabric is not None:
        return "Edit"
    if project.labeled is not None:
        return "Divide"
    return "Rows" if project.mesh is not None and triangles_message(project.mesh) else "Label"
