# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Label: the rows of the mesh, found by clicks or all at once (Yuksel et al. 2012, section 5.1)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.app.controls.html_pieces import PLAIN_TEXT, LegendEntry, legend, list_button
from stitchmesh.app.controls.undo_row import UndoRow
from stitchmesh.app.pages.page import NO_MESH, Page
from stitchmesh.app.scene.drawing import Colour, Labels
from stitchmesh.app.scene.mesh_drawing import INK, MeshDrawing, VertexNumbers
from stitchmesh.app.scene.scene import Pick, ViewName
from stitchmesh.errors import ParameterError
from stitchmesh.labeling import LabelingFault, PartialLabeling
from stitchmesh.labeling.faults import triangles_message
from stitchmesh.labeling.growth import COURSE
from stitchmesh.labeling.seeds import candidate_seeds, side_of
from stitchmesh.labeling.steps import LabelStep, free_border_sides, pointed_step
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.mesh.orientation import is_inside_out
from stitchmesh.mesh.picking import pick as pick_place
from stitchmesh.mesh.picking import picking_table, side_near_ray
from stitchmesh.mesh.polygon_mesh import outline_sides
from stitchmesh.render.labeling_drawing import (
    FAULT_COLOUR,
    MISMATCH_COLOUR,
    UNLABELED_COLOUR,
    faces_at_fault,
    labeling_arrowheads,
    labeling_colours,
)
from stitchmesh.tessellate.edge_file import parse_edge
from stitchmesh.yarn.colours import row_colours

if TYPE_CHECKING:
    from stitchmesh.app.application import App

START_COLOUR: Colour = (232, 140, 20)
"""Colour of borders at which a row can start."""
MOST_FAULTS = 5
"""Number of faults that are listed."""


def labeling_status(labeling: PartialLabeling, inside_out: bool) -> Markup:
    """The numbers in one or two lines."""
    done, faces = int(labeling.labeled.sum()), labeling.mesh.face_count
    rows = labeling.row_count
    first = markup("<strong>{} row{}</strong>, {} of {} faces labeled", rows, "s" * (rows != 1), done, faces)
    lines: list[str] = [first]
    seams = len(labeling.mismatched_sides())
    if seams:
        lines.append(
            f"At {seams} edge{'s' * (seams != 1)} the arrows of two rows do not match. Flip one of the rows, or keep "
            "it: small rings of yarn will join them."
        )
    if triangles_message(labeling.mesh):
        lines.append(triangles_message(labeling.mesh))
    if inside_out:
        hint = "The mesh seems to be inside out: its purl side would be outside. See <em>Whole mesh</em>."
        lines.append(markup(hint))
    return joined(markup('<p role="status" style="margin:0 0 .3em;font-size:.92em">{}</p>', line) for line in lines)


def legend_entries(labeling: PartialLabeling) -> list[LegendEntry]:
    """Return the legend of the visible things."""
    entries = []
    if labeling.row_count:
        rows = [tuple(colour) for colour in row_colours(np.arange(6)).tolist()]
        entries.append(LegendEntry("rows; arrows along the wales", tuple(rows)))
    if not labeling.labeled.all():
        entries.append(LegendEntry("no row yet", (UNLABELED_COLOUR,)))
    if len(free_border_sides(labeling)):
        entries.append(LegendEntry("border: click it to start a row", (START_COLOUR,), line=True))
    if labeling.row_count:
        entries.append(LegendEntry("course edge, between rows", (INK,), line=True))
    if len(labeling.mismatched_sides()):
        entries.append(LegendEntry("seam where arrows do not match", (MISMATCH_COLOUR,), line=True))
    if labeling.faults:
        entries.append(LegendEntry("cannot be labeled: crossed out, with a number", (FAULT_COLOUR,)))
    return entries


def fault_list(faults: tuple[LabelingFault, ...]) -> Markup:
    """Return the reasons why faces cannot be labeled, each as a button that shows its faces."""
    if not faults:
        return Markup()
    items = joined(
        markup("<li>{}</li>", list_button("fault", number, fault.reason, f"rgb{FAULT_COLOUR!r}", hint="Show the faces"))
        for number, fault in enumerate(faults[:MOST_FAULTS])
    )
    more = len(faults) - MOST_FAULTS
    rest = markup('<p style="{}">and {} more</p>', PLAIN_TEXT, more) if more > 0 else Markup()
    return (
        markup(
            '<p style="margin:.3em 0 0;font-size:.92em"><strong>Faces that cannot be labeled</strong></p>'
            '<ol style="margin:0;padding-left:1.4em;font-size:.86em">{}</ol>{}',
            items, rest,
        )
    )


def start_list(mesh: Mesh) -> Markup:
    """Return buttons for the borders from which rows may start, best first."""
    buttons = []
    for chain in candidate_seeds(mesh)[:8]:
        length = float(mesh.side_length[chain].sum())
        height = float(mesh.corner_position[chain, 1].mean() - mesh.vertices[:, 1].min())
        words = f"Border of {length:.0f} cm at height {height:.0f} cm"
        buttons.append(list_button("start", chain[0], words))
    heading = markup('<p style="{}">Start the next row at a border:</p>', PLAIN_TEXT)
    without = markup("<p>The mesh has no border. Choose that a click starts at an inner edge.</p>")
    return heading + joined(buttons) if buttons else without


REACH = 0.008
"""Largest angle between a click and the border that it selects [rad], about nine pixels."""
ROWS, FLIP, INSIDE, WALE, COURSE_EDGE, CLEAR = (
    "makes a row", "flips a row", "starts at an inner edge", "sets a wale edge", "sets a course edge",
    "clears an edge",
)  # fmt: skip
MEANINGS = {
    ROWS: "Click an orange border for the first row, then click on for the next. Shift takes the border past corners.",
    FLIP: "Click a row to reverse its arrows.",
    INSIDE: "Click beside an inner edge: a row grows from its edge loop, on the side of the click.",
    WALE: "Click beside an edge to set it to wale: rows cross it.",
    COURSE_EDGE: "Click beside an edge to set it to course: it runs along rows.",
    CLEAR: "Click beside an edge that was set by hand to clear its label.",
}
"""The meanings of a click, each with its hint."""


@dataclass(frozen=True)
class LabelState:
    """The user's choices on the page."""

    meaning: str = ROWS
    """The meaning of a click."""
    flips_when_done: bool = True
    """Whether a click makes rows until all faces have rows, and then flips a row."""


class LabelPage(Page):
    """Labels the mesh of the project."""

    name = "Label"
    hint = "Click an orange border: it becomes the first row. Click on for the next rows, or press Label all."

    def __init__(self, app: App) -> None:
        """Make the page."""
        super().__init__(app)
        self._state = LabelState()
        self._mesh: Mesh | None = None

    def unavailable(self) -> str | None:
        """Return what is missing before the mesh can be labeled."""
        if self.app.project.labeling is not None:
            return None
        if self.app.project.fabric is not None:
            return "The imported file holds stitches, which are labeled already. Go on with Edit."
        return NO_MESH

    def build(self) -> None:
        """Make the controls, and draw the mesh."""
        controls = self.app.controls
        self._status = controls.html(Markup())
        self._go_on = controls.button(
            "Go on: divide into stitches", "All faces have rows. Open the page Divide.",
            lambda: self.app.open_page("Divide"), main=True,
        )  # fmt: skip
        self._to_rows = controls.button(
            "Go to Rows", "This mesh consists of triangles, in which no rows are modelled; the page Rows finds them.",
            lambda: self.app.open_page("Rows"), main=True,
        )  # fmt: skip
        self._label_all = controls.button(
            "Label all", "Label all rows that can be labeled (L).", self._step("label_all"), main=True
        )
        controls.button("Next row", "Label one row more (N).", self._step("label_rows", count=1))
        self._steps = UndoRow(controls, self._undo, self._redo, "the last step")
        self._choice = controls.choice(
            "A click", "What a click on the mesh does.", tuple(MEANINGS), self._state.meaning, self._mean
        )
        self._meaning_hint = controls.html(Markup())
        self._legend = controls.html(Markup())
        self._faults = controls.html(Markup(), self._clicked)
        self._make_other_controls()
        self._mesh = None
        self.refresh()
        self._drawing.look()

    def _make_other_controls(self) -> None:
        """Make the controls that users need less often, and the keys."""
        controls = self.app.controls
        with controls.group("Without the mouse", opened=False):
            self._starts = controls.html(Markup(), self._clicked)
            self._row = controls.number(
                "Row", "Number of a row, counted from 1.", 1, lambda _: self._show_row(), least=1, most=10_000, step=1
            )
            controls.button("Flip this row", "Reverse the arrows of the row with this number.", self._flip_row)
            self._numbers = VertexNumbers(self.app.scene, controls)
            self._place = controls.text(
                "Edge", "Two vertices, such as 4,7: the face is on the left from 4 to 7.", ""
            )
            controls.button("Act at this edge", "Do there what a click does.", self._act_at_edge)
        with controls.group("Whole mesh", opened=False):
            controls.button("Start again", "Remove all labels; Undo brings them back.", self._step("clear_labels"))
            controls.button(
                "Turn inside out", "Make the other side of the mesh the outside, and remove all labels.",
                self._step("turn_inside_out"),
            )  # fmt: skip
        for label, key, run in (
            ("Label one row more", "N", self._step("label_rows", count=1)),
            ("Label all rows", "L", self._step("label_all")),
        ):
            controls.key(label, f"{label} of the labeling.", key, None, run)

    def refresh(self) -> None:
        """Show the labeling of the project."""
        labeling = self.app.project.labeling
        assert labeling is not None
        if labeling.mesh is not self._mesh:
            self._take_mesh(labeling.mesh)
        self._draw(labeling)
        self._describe(labeling)

    def picked(self, pick: Pick) -> None:
        """Take the step that a click means."""
        step = self._meant(pick)
        if step is not None:
            self._take(step)

    def camera_moved(self) -> None:
        """Show the numbers of the vertices that face the camera."""
        self._numbers.camera_moved()

    def _take_mesh(self, mesh: Mesh) -> None:
        """Prepare drawing and picking of a mesh."""
        self._mesh, self._table = mesh, picking_table(mesh)
        self._drawing = MeshDrawing(self.app.scene, mesh)
        self._drawing.show_sides("edges", mesh.edge_side, INK, 1.0)
        self._numbers.show(mesh)
        self._inside_out = is_inside_out(mesh)
        self._starts.content = start_list(mesh)
        self._to_rows.visible = bool(triangles_message(mesh))

    def _draw(self, labeling: PartialLabeling) -> None:
        drawing, mesh = self._drawing, labeling.mesh
        drawing.show_faces("faces", labeling_colours(labeling, faces_at_fault(labeling)))
        drawing.show_sides("courses", mesh.edge_side[labeling.edge_label == COURSE], INK, 3.0)
        drawing.show_sides("starts", free_border_sides(labeling), START_COLOUR, 6.0)
        drawing.show_sides("seams", labeling.mismatched_sides(), MISMATCH_COLOUR, 7.0)
        drawing.show_arrowheads("arrows", labeling_arrowheads(labeling), INK)
        self._draw_faults(labeling)
        self._show_row()

    def _draw_faults(self, labeling: PartialLabeling) -> None:
        """Cross out the faces of each listed fault, and write its number."""
        faults = labeling.faults[:MOST_FAULTS]
        mesh = labeling.mesh
        faces = np.array([face for fault in faults for face in fault.faces], dtype=np.int64)
        self._drawing.show_crosses("faults", faces, INK, 4.0)
        points = np.array([_centre(mesh, fault) for fault in faults]).reshape(-1, 3)
        self.app.scene.show("fault numbers", Labels(points, tuple(str(n) for n in range(1, len(faults) + 1))))

    def _show_row(self) -> None:
        """Draw the outline of the row with the typed number; none before the user has typed another than the first."""
        labeling = self.app.project.labeling
        faces = self._faces_of_typed_row(labeling)
        if labeling is None or self._row.value == 1 or not len(faces):
            self.app.scene.remove("row")
            return
        self._drawing.show_sides("row", outline_sides(labeling.mesh, faces), START_COLOUR, 5.0)

    def _faces_of_typed_row(self, labeling: PartialLabeling | None) -> IntArray:
        """Return the faces of the row with the typed number; a larger number means the last row."""
        if labeling is None or labeling.row_count == 0:
            return np.zeros(0, dtype=np.int64)
        return labeling.faces_of_row(min(int(self._row.value), labeling.row_count) - 1)

    def _describe(self, labeling: PartialLabeling) -> None:
        """Show the numbers, the legend and the faults as text."""
        done = bool(labeling.labeled.all())
        if self._state.flips_when_done:
            self._state = replace(self._state, meaning=FLIP if done else ROWS)
            self._choice.value = self._state.meaning
        self._go_on.visible, self._label_all.visible = done, not done
        self._steps.show(self.app.project.label_history)
        self._status.content = labeling_status(labeling, self._inside_out)
        self._meaning_hint.content = markup('<p style="{}">{}</p>', PLAIN_TEXT, MEANINGS[self._state.meaning])
        self._legend.content = legend(legend_entries(labeling))
        self._faults.content = fault_list(labeling.faults)

    def _meant(self, pick: Pick) -> LabelStep | None:
        """Return the step that a click means; None for a click beside the mesh."""
        labeling = self.app.project.labeling
        assert labeling is not None
        ray = pick.ray_origin, pick.ray_direction
        if self._state.meaning == ROWS:
            border = side_near_ray(self._table, free_border_sides(labeling), *ray, REACH)
            if border is not None:
                whole = pick.modifier == "shift"
                return LabelStep("start_at_border" if whole else "start_at_edge", {"edge": border})
        place = pick_place(self._table, *ray)
        return None if place is None else self._step_at(labeling, place.side)

    def _step_at(self, labeling: PartialLabeling, side: int) -> LabelStep:
        """Return the step that a click near a side of a face means."""
        face = int(labeling.mesh.side_face[side])
        steps: dict[str, Callable[[], LabelStep]] = {
            ROWS: lambda: pointed_step(labeling, side),
            FLIP: lambda: LabelStep("flip_row", {"face": face}),
            INSIDE: lambda: LabelStep("start_at_edge", {"edge": side}),
            WALE: lambda: LabelStep("set_edge", {"edge": side, "label": "wale"}),
            COURSE_EDGE: lambda: LabelStep("set_edge", {"edge": side, "label": "course"}),
            CLEAR: lambda: LabelStep("set_edge", {"edge": side, "label": None}),
        }
        return steps[self._state.meaning]()

    def _take(self, step: LabelStep) -> None:
        self._changed(self.app.project.apply_label_step(step))

    def _changed(self, lost: tuple[str, ...]) -> None:
        if lost:
            self.app.notice(f"Other rows need other stitches. Removed: {', '.join(lost)}. Undo brings them back.")
        self.app.refresh()

    def _step(self, name: str, **arguments: object) -> Callable[[], None]:
        return lambda: self._take(LabelStep(name, arguments))

    def _undo(self) -> None:
        self._changed(self.app.project.undo_label())

    def _redo(self) -> None:
        self._changed(self.app.project.redo_label())

    def _mean(self, meaning: str) -> None:
        """Take the meaning of clicks; with rows, a click flips a row once all faces have rows."""
        self._state = LabelState(meaning, flips_when_done=meaning in (ROWS, FLIP))
        self.refresh()

    def _flip_row(self) -> None:
        faces = self._faces_of_typed_row(self.app.project.labeling)
        if not len(faces):
            raise ParameterError("flip: there are no rows yet; label some first")
        self._take(LabelStep("flip_row", {"face": faces[0]}))

    def _act_at_edge(self) -> None:
        labeling = self.app.project.labeling
        assert labeling is not None
        self._take(self._step_at(labeling, side_of(labeling.mesh, parse_edge(self._place.value))))

    def _clicked(self, action: str, value: str) -> None:
        labeling = self.app.project.labeling
        assert labeling is not None
        if action == "start":
            self._take(LabelStep("start_at_edge", {"edge": int(value)}))
        elif action == "fault" and int(value) < len(labeling.faults):
            self._show_fault(labeling.mesh, labeling.faults[int(value)])

    def _show_fault(self, mesh: Mesh, fault: LabelingFault) -> None:
        faces = np.array(fault.faces, dtype=np.int64)
        points = mesh.corner_position[mesh.sides_of(faces)]
        middle, size = points.mean(axis=0), 2.0 * np.ptp(points, axis=0).max()
        self.app.scene.look_at(middle - size, middle + size, _view_of(mesh.face_vector_area[faces].sum(axis=0)))


def _centre(mesh: Mesh, fault: LabelingFault) -> FloatArray:
    position = mesh.corner_position[mesh.sides_of(np.array(fault.faces[:1], dtype=np.int64))]
    centre: FloatArray = position.mean(axis=0)
    return centre


def _view_of(normal: FloatArray) -> ViewName:
    """Return the view that shows a face with this normal best."""
    x, y, z = normal
    if y > max(abs(x), abs(z)):
        return "top"
    if abs(z) >= abs(x):
        return "front" if z >= 0.0 else "back"
    return "right" if x > 0.0 else "left"
