# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Project: opening and import of files, the contents of the project, downloads, and other projects."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, get_args

from stitchmesh.app.controls.html_pieces import action_button
from stitchmesh.app.pages.downloads import STYLE, Export, download_list, exports, send_file
from stitchmesh.app.pages.page import Page
from stitchmesh.app.pages.typed import AXES
from stitchmesh.app.project.opening import RecentProject, new_project_folder, recent_projects, remember, title_of
from stitchmesh.app.project.project import Project
from stitchmesh.app.project.source import Source, read_source, source_of
from stitchmesh.app.scene.mesh_drawing import draw_plainly
from stitchmesh.errors import ParameterError
from stitchmesh.io.examples import example_names, read_example
from stitchmesh.io.garments import doubt_of_unit
from stitchmesh.io.meshes import FORMATS as MESH_FORMATS
from stitchmesh.io.meshes import stated_unit
from stitchmesh.io.units import CENTIMETRES, DEFAULT_UNIT, other_units
from stitchmesh.labeling.faults import triangles_message
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh import Mesh, extent
from stitchmesh.mesh.layers import Layer
from stitchmesh.mesh.upright import Y

if TYPE_CHECKING:
    from stitchmesh.app.application import App

NOT_YET = "not yet"


def project_summary(project: Project) -> Markup:
    """Return the name, the place and the stages of a project."""
    rows = joined(markup("<tr><th scope='row'>{}</th><td>{}</td></tr>", name, text)
                   for name, text in stage_lines(project))  # fmt: skip
    notes = joined(markup('<p class="trouble">{}</p>', note) for note in project.notes)
    taken = joined(markup("<p>{}.</p>", _sentence(note)) for note in _taken(project))
    return markup(
        '{}<div class="sm-project">{}{}<table>{}</table>{}</div>',
        STYLE, saving_line(project), notes, rows, taken,
    )


def saving_line(project: Project) -> Markup:
    """Return one line that says where the project is, or why it cannot be saved."""
    trouble = project.autosave.trouble
    if trouble is not None:
        return markup('<p class="trouble" role="alert">{}. It is tried again every few seconds.</p>', trouble)
    return markup("<p>Every change is saved at once in <b>{}</b>.</p>", _short(project.folder))


def stage_lines(project: Project) -> list[tuple[str, str]]:
    """Return for each stage its name and a description of its value."""
    return [
        ("Mesh", _mesh(project)),
        *([("Repaired", " ".join(f"{action.text}: {action.places}." for action in project.repairs))]
          if project.repairs else []),
        ("Rows", _rows(project)),
        ("Stitches", _stitches(project)),
        ("Edits", str(len(project.edits)) if project.edits else NOT_YET),
        ("Evened out", "yes" if project.evened is not None else NOT_YET),
        ("Yarns", NOT_YET if project.yarns is None else f"{len(project.yarns.points):,} control points"),
        ("Relaxed", NOT_YET if project.relaxed is None else _relaxed(project)),
    ]


def unit_offer(project: Project) -> Markup:
    """Return a doubt about the size of the mesh, and a button for each unit that would make it a garment.

    The action is ``unit``, and ``data-value`` is the unit; the result is empty if the mesh has the size of a garment.
    """
    mesh, source = project.mesh, project.source
    doubt = "" if mesh is None or source is None else doubt_of_unit(source.name, mesh, source.reading.unit)
    if mesh is None or source is None or not doubt:
        return Markup()
    others = {} if stated_unit(source.name) else other_units(mesh.vertices, source.reading.unit)
    buttons = joined(
        action_button("unit", unit, f"Read it in {unit}: {size}", wide=True) for unit, size in others.items()
    )
    # The sentence names the command-line option for each unit; here a button replaces it.
    said = doubt.partition(";")[0] if others else doubt
    return markup('{}<div class="sm-project"><p class="trouble">{}.</p>{}</div>', STYLE, _sentence(said), buttons)


def recent_list(projects: list[RecentProject], present: Path, doomed: Path | None) -> Markup:
    """Return for each recent project except the present one a button that opens it and a button that deletes it.

    Args:
        projects: the projects; ``data-value`` of a button is the place of its project in this list.
        present: folder of the present project.
        doomed: folder of the project for which the page asks whether to delete it; None without a question.
    """
    buttons = joined(
        _question(number, one) if one.folder == doomed else _recent(number, one)
        for number, one in enumerate(projects)
        if one.folder != present
    )
    others = buttons or markup("<p>No other project was open yet.</p>")
    return markup('{}<div class="sm-project">{}</div>', STYLE, others)


def _recent(number: int, one: RecentProject) -> Markup:
    picture = markup(
        '<svg viewBox="-4 -4 108 108" width="44" height="44" aria-hidden="true">'
        '<path d="{}" stroke="currentColor" stroke-width="2" fill="none"/></svg>',
        one.outline,
    )
    content = markup(
        "{}<span>{}<br><small>{}<br>{}</small></span>",
        picture, one.name, f"{one.changed:%d %b %Y, %H:%M}", _short(one.folder),
    )
    return markup(
        '<div class="one">{}{}</div>',
        action_button("open", number, content, name=f"Open the project {one.name}", wide=True),
        action_button("delete", number, "Delete", name=f"Delete the project {one.name}"),
    )


def _question(number: int, one: RecentProject) -> Markup:
    return markup(
        '<div class="one" role="alert"><span>Delete <b>{}</b> for ever? </span>{}{}</div>',
        one.name, action_button("delete-now", number, "Delete it"), action_button("keep", number, "Keep it"),
    )


def _mesh(project: Project) -> str:
    if project.source is None:
        return "none yet: import one, or take an example"
    if project.mesh is None:
        return f"{project.source.name}, which holds stitches"
    turned = "" if project.up == Y else ", turned upright"
    return f"{project.source.name}, {project.mesh.face_count:,} faces, {extent(project.mesh.vertices)}{turned}"


def _rows(project: Project) -> str:
    labeling = project.labeling
    if labeling is None:
        return NOT_YET if project.fabric is None else "in the stitches"
    if project.shaping is not None:
        return "found on the mesh"
    if project.labeled is not None:
        return f"{labeling.row_count:,}"
    done = int(labeling.labeled.sum())
    return f"{labeling.row_count:,}; {done:,} of {labeling.mesh.face_count:,} faces" if done else NOT_YET


def _stitches(project: Project) -> str:
    return NOT_YET if project.fabric is None else f"{project.fabric.face_count:,}"


def _relaxed(project: Project) -> str:
    report = project.report or {}
    if report.get("unfinished"):
        return "stopped before rest"
    return "at rest" if report.get("converged", True) else "not at rest"


def _taken(project: Project) -> list[str]:
    """Return the notes on the file, without the options of the command line, for which the page has choices."""
    if project.garment is None or project.source is None:
        return []
    doubt = doubt_of_unit(project.source.name, project.garment.mesh, project.source.reading.unit)
    return [note.rpartition(";")[0] for note in project.garment.notes if note != doubt]


def _sentence(clause: str) -> str:
    return clause[:1].upper() + clause[1:]


def _short(folder: Path) -> str:
    """Return a path, with ~ for the home."""
    home = Path.home()
    return f"~/{folder.relative_to(home)}" if folder.is_relative_to(home) and folder != home else str(folder)


SUFFIXES = (*MESH_FORMATS, ".h5", ".smobj", ".st")
"""Suffixes of the files that a project can start from."""
ALL_OBJECTS = "all that can be garments"
"""Entry of the list of a file's objects for no choice."""


@dataclass(frozen=True)
class ProjectPageState:
    """The user's choices on the page."""

    example: str
    """Name of the chosen example; empty if the program comes without examples."""
    unit: str = DEFAULT_UNIT
    """Unit of the next file."""
    new_name: str = "Garment"
    """Name of the next project."""
    doomed: Path | None = None
    """Folder of the project for which the page asks whether to delete it."""


class ProjectPage(Page):
    """Shows the project, and opens other projects."""

    name: ClassVar[str] = "Project"
    hint: ClassVar[str] = "Import a mesh, or drop its file here. Or take an example."

    def __init__(self, app: App) -> None:
        """Make the page."""
        super().__init__(app)
        names = example_names()
        self._state = ProjectPageState("hat" if "hat" in names else "".join(names[:1]))
        self._drawn: Mesh | None = None
        self._files: list[Export] = []

    def build(self) -> None:
        """Make the controls, and draw the content of the project."""
        remember(self.app.project)
        controls = self.app.controls
        self._summary = controls.html(Markup())
        self._offer = controls.html(Markup(), self._clicked)
        self._next = controls.button("Go on", "Open the page of the next step.", self._go_on, main=True)
        self._restore = controls.button("Bring back", "Return to what the last change dropped.", self._bring_back)
        with controls.group("Start from"):
            self._make_start()
        with controls.group("Download", opened=False):
            self._downloads = controls.html(Markup(), self._clicked)
        with controls.group("Projects", opened=False):
            controls.text("Name", "Name of this project.", self.app.project.name, self._rename)
            controls.text("New name", "Name of the new project.", self._state.new_name,
                          lambda name: self._choose(new_name=name))  # fmt: skip
            controls.button("New project", "Start an empty project; this one stays saved.", self._new_project)
            self._recent = controls.html(Markup(), self._clicked)
        self._drawn = None
        self.refresh()

    def refresh(self) -> None:
        """Show the project."""
        project = self.app.project
        self._summary.content = project_summary(project)
        self._offer.content = unit_offer(project)
        self._show_reading()
        self._next.visible = project.source is not None
        self._next.label = f"Go on: {next_page(project)}"
        restored = ", ".join(project.can_restore)
        self._restore.visible = bool(restored)
        self._restore.label = f"Bring back: {restored}"
        self._files = exports(project)
        self._downloads.content = download_list(self._files)
        self._recent.content = recent_list(recent_projects(), project.folder, self._state.doomed)
        self._draw()

    def import_file(self, name: str, content: bytes) -> None:
        """Start from a file: in this project if it is empty, otherwise in a new one.

        Raises:
            StitchMeshError: the file cannot be read; the projects stay as they are.
        """
        if self.app.project.source is None:
            self._import_here(name, content)
            return
        self._start_project(source_of(name, content, self._unit_of(name)))

    def _start_project(self, source: Source) -> None:
        """Start a new project from a file, and leave the present one."""
        title = title_of(source.name)
        project = Project.create(new_project_folder(title), title, source)
        self._change_to(project)
        self._say_repairs()
        self.app.notice(f"{project.name} is a new project; the project before is saved.")
        self._open_next()

    def _make_start(self) -> None:
        controls = self.app.controls
        self._unit_choice = controls.choice(
            "Unit", "Unit of the coordinates in the file, this one and the next; glTF is always in metres.",
            tuple(CENTIMETRES), self._state.unit, self._set_unit,
        )  # fmt: skip
        self._make_parts()
        self._up_choice = controls.choice(
            "Up in the file", "Direction in the file of the mesh that points up; found by the openings at an import.",
            tuple(AXES), next(iter(AXES)), lambda axis: self._read_again(up=AXES[axis]),
        )  # fmt: skip
        controls.upload("Import a mesh", "Choose a mesh of a garment, or stitches; or drop a file anywhere.", SUFFIXES,
                        self.import_file)  # fmt: skip
        names = example_names()
        if names:
            controls.choice("Example", "A garment that comes with the program.", names, self._state.example,
                            self._set_example)  # fmt: skip
            controls.button("Take the example", "Start from the chosen garment.", self._take_example)

    def _import_here(self, name: str, content: bytes) -> None:
        project = self.app.project
        project.import_mesh(name, content, self._unit_of(name))
        if project.name == project.folder.name:
            project.rename(title_of(name))
        self._say_repairs()
        self._open_next()

    def _say_repairs(self) -> None:
        if self.app.project.repairs:
            changes = " ".join(f"{action.text}." for action in self.app.project.repairs)
            self.app.notice(f"{changes} The page Rows knits the repaired mesh.", title="Repaired")

    def _open_next(self) -> None:
        """Open the page of the next step; keep this page if the unit of the mesh may be wrong."""
        project = self.app.project
        self.app.open_page(self.name if unit_offer(project) else next_page(project))

    def _take_example(self) -> None:
        unit = self._state.unit
        self._choose(unit=DEFAULT_UNIT)
        try:
            self.import_file(*read_example(self._state.example))
        finally:
            self._choose(unit=unit)

    def _unit_of(self, name: str) -> str:
        """Return the unit for reading a file: the chosen unit, unless the format fixes one."""
        return DEFAULT_UNIT if stated_unit(name) else self._state.unit

    def _set_unit(self, unit: str) -> None:
        """Choose the unit of the next file, and read the present mesh in it.

        The mesh stays in the same project while nothing was made from it; otherwise it goes to a new project.
        """
        self._choose(unit=unit)
        if self.app.project.source is not None:
            self._read_again(unit=self._unit_of(self.app.project.source.name))

    def _make_parts(self) -> None:
        """Make the choices of an object and of a layer, if the file has several."""
        garment, source = self.app.project.garment, self.app.project.source
        if garment is None or source is None:
            return
        if len(garment.objects) > 1:
            chosen = source.reading.objects[0] if len(source.reading.objects) == 1 else ALL_OBJECTS
            self.app.controls.choice(
                "Object", "Object of the file that is knitted, by its name in it.", (ALL_OBJECTS, *garment.objects),
                chosen, lambda name: self._read_again(objects=() if name == ALL_OBJECTS else (name,)),
            )  # fmt: skip
        if garment.has_layers:
            self.app.controls.choice(
                "Layer", "Layer of a garment with a thickness that is knitted.", get_args(Layer), source.reading.layer,
                lambda name: self._read_again(layer=name),
            )  # fmt: skip

    def _read_again(self, **reading: Any) -> None:
        """Read the file of the present mesh in another way; do nothing if it was read with these."""
        project, before = self.app.project, self.app.project.source
        if project.mesh is None or before is None:
            return
        source = replace(before, reading=replace(before.reading, **reading))
        if source.reading == before.reading:
            return
        if project.label_steps or project.fabric is not None:
            self._start_project(source)
        else:
            project.read_source(source)
            self.app.open_page(self.name)

    def _show_reading(self) -> None:
        """Show the unit and the upward direction of the present mesh, as they were read."""
        source = self.app.project.source
        if source is None or self.app.project.mesh is None:
            return
        if not stated_unit(source.name):
            self._choose(unit=source.reading.unit)
            self._unit_choice.value = source.reading.unit
        self._up_choice.value = next((axis for axis, up in AXES.items() if up == self.app.project.up), "+y")

    def _set_example(self, name: str) -> None:
        self._choose(example=name)
        self._draw()

    def _choose(self, **values: Any) -> None:
        self._state = replace(self._state, **values)

    def _rename(self, name: str) -> None:
        self.app.project.rename(name)
        remember(self.app.project)

    def _new_project(self) -> None:
        self._change_to(Project.create(new_project_folder(self._state.new_name), self._state.new_name.strip()))

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
            send_file(self.app, self._files, value)
        elif action == "open":
            self._change_to(Project.open(_recent_folder(value)))
        elif action == "delete-now":
            folder = self._state.doomed
            self._choose(doomed=None)
            if folder is not None and folder != self.app.project.folder:
                Project.delete(folder)
            self.refresh()
        elif action in ("delete", "keep"):
            self._choose(doomed=_recent_folder(value) if action == "delete" else None)
            self.refresh()
        elif action == "unit" and value in CENTIMETRES:
            self._set_unit(value)

    def _draw(self) -> None:
        """Draw the newest stitches or the mesh; in an empty project, draw the chosen example in pale colours."""
        project = self.app.project
        mesh = project.evened or project.fabric or project.mesh
        opacity = 1.0
        if mesh is None and self._state.example:
            mesh, opacity = _example_mesh(self._state.example), 0.5  # an example that the user only looks at
        if mesh is None or mesh is self._drawn:
            return
        self._drawn = mesh
        draw_plainly(self.app.scene, mesh, opacity)


def _recent_folder(place: str) -> Path:
    """Return the folder of a project by its place in the list.

    Raises:
        ParameterError: the project does not exist any more.
    """
    projects = recent_projects()
    if not place.isdecimal() or int(place) >= len(projects):
        raise ParameterError("projects: the list has changed; look at it again")
    return projects[int(place)].folder


@cache
def _example_mesh(name: str) -> Mesh | None:
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
