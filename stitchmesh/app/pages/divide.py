# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Divide: the size of the stitches, and their numbers on edges (Yuksel et al. 2012, section 5.2)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from stitchmesh.app.controls.field_panel import FieldPanel
from stitchmesh.app.controls.html_pieces import LegendEntry, figures, legend, message, refusal
from stitchmesh.app.controls.undo_row import UndoRow
from stitchmesh.app.pages.gauge_panel import INCREASE, GaugePanel, drawn_height, gauge_words, yarn_of
from stitchmesh.app.pages.page import HAS_STITCHES, NO_MESH, Page
from stitchmesh.app.project.division import (
    Division,
    division_of,
    division_table,
    with_count,
    with_edges,
    with_known_edges,
    with_mark,
)
from stitchmesh.app.scene.drawing import Labels
from stitchmesh.app.scene.mesh_drawing import INK, STITCH_DRAWINGS, MeshDrawing, VertexNumbers, show_stitches
from stitchmesh.app.scene.scene import DrawingScene, Pick
from stitchmesh.app.task import TaskControl
from stitchmesh.editing.undo_history import UndoHistory
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.markup import Markup, markup
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.mesh.picking import pick as pick_place
from stitchmesh.mesh.picking import picking_table
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.quality import DEFAULT_QUALITY, PRESETS
from stitchmesh.recipe.estimate import GarmentEstimate, estimate_garment
from stitchmesh.render.palette import STITCH_COLOURS
from stitchmesh.tessellate.counts import edge_named, edges_with_one_count
from stitchmesh.tessellate.edge_file import EdgeSettings, VertexPair, edge_settings_text, parse_edge_settings
from stitchmesh.yarn.colours import row_colours
from stitchmesh.yarn.yarn_presets import Gauge, Yarn

if TYPE_CHECKING:
    from stitchmesh.app.application import App

STAGE_WORDS = {
    "tessellate": "divide", "meshrelax": "even out", "yarngen": "make yarns", "yarnrelax": "relax yarns",
}  # fmt: skip
"""Words for the stages of an estimate."""
KINDS = {
    "cast on": (Stitch.CAST_ON,),
    "knit": (Stitch.KNIT,),
    "increase": (Stitch.KY, Stitch.YK, Stitch.YKY, Stitch.KS, Stitch.SK, Stitch.KYK, Stitch.PK, Stitch.KPK),
    "decrease": (Stitch.D12K, Stitch.D21K, Stitch.D213K),
    "drawn through the last loops": (Stitch.DRAW_THROUGH,),
}
"""Stitches of a divided mesh, by their purpose."""


def estimate_table(estimate: GarmentEstimate, width: float, height: float, yarn: Yarn | None) -> Markup:
    """Return the estimate as a table; possible faults stand below it."""
    length = f"{estimate.yarn_length / 100.0:,.0f} m"
    if yarn is not None:
        length += f", about {estimate.yarn_length / 100.0 * yarn.grams_per_metre:,.0f} g"
    rows = {
        "Gauge": gauge_words(Gauge.of_stitch(width, height)),
        "Stitches": f"{estimate.stitches:,} in {estimate.rows:,} rows",
        "Yarn": length,
        "Control points": f"{estimate.control_points:,}",
        "Time": f"about {_time(estimate.seconds)}",
        "Memory": f"about {_memory(estimate.memory)}",
    }
    stages = ", ".join(f"{STAGE_WORDS[name]} {_time(cost.seconds)}" for name, cost in estimate.stages.items())
    doubt = message(f"Please note: {estimate.doubt}", "doubtful") if estimate.doubt else Markup()
    return markup(
        '{}<p style="margin:.2em 0 0;font-size:.8em">{}; half or twice that on other machines</p>{}',
        figures(rows.items()), stages, doubt,
    )


def edge_text(labeled: StitchMesh, side: int, count: int, *, by_hand: bool, marked: bool) -> Markup:
    """Return a description of the chosen edge; the user has given its number by hand, or it follows from its length."""
    start, end = labeled.face_vertex[side], labeled.face_vertex[labeled.side_next[side]]
    length = float(labeled.side_length[side])
    origin = "given by hand" if by_hand else "by its length"
    if labeled.is_wale[side]:
        what = f"wale edge of row {labeled.row[labeled.side_face[side]] + 1}: {count} rows of stitches, {origin}"
        what += "; marked" if marked else ""
    else:
        what = f"course edge: {count} stitches, {origin}"
    return markup(
        '<p style="margin:0;font-size:.88em"><strong>Edge {},{}</strong>, {} cm, {}</p>',
        start, end, f"{length:.1f}", what,
    )


def legend_of_stitches(fabric: StitchMesh) -> list[LegendEntry]:
    """Return the legend of the colours of the stitches, with the number of stitches of each."""
    counts = np.bincount(fabric.stitch, minlength=max(Stitch) + 1)
    entries = []
    for words, codes in KINDS.items():
        present = [code for code in codes if counts[code]]
        if present:
            number = sum(int(counts[code]) for code in present)
            entries.append(LegendEntry(f"{words}: {number:,}", tuple(STITCH_COLOURS[code] for code in present)))
    return entries


def _time(seconds: float) -> str:
    """A duration in words."""
    if seconds < 1.0:
        return "1 s" if seconds >= 0.5 else "less than 1 s"
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{seconds / 3600.0:.1f} h"


def _memory(size: float) -> str:
    return f"{size / 1e9:.1f} GB" if size >= 1e9 else f"{size / 1e6:.0f} MB"


EDGE_MARKS = (
    ("counted", (31, 86, 115), 6.0, "number given by hand"),
    ("marked", (150, 40, 140), 6.0, "marked: increases and decreases stand here"),
    ("chosen", (232, 140, 20), 8.0, "chosen edge"),
)
"""Name, colour, width [pixels] and meaning of the lines along edges."""


class DivisionView:
    """Draws one labeled mesh and its divisions."""

    def __init__(self, scene: DrawingScene, labeled: StitchMesh) -> None:
        """Draw nothing yet."""
        self._scene, self._labeled = scene, labeled
        self._drawing = MeshDrawing(scene, labeled)
        self._colours = row_colours(labeled.row)
        self._shown: StitchMesh | None = None

    def look(self) -> None:
        """Show the whole mesh."""
        self._drawing.look()

    def show_mesh(self) -> list[LegendEntry]:
        """Draw the faces of the mesh in the colours of their rows, and return the legend."""
        if self._shown is not self._labeled:
            self._shown = self._labeled
            for name in STITCH_DRAWINGS:
                self._scene.remove(name)
            self._drawing.show_faces("faces", self._colours)
            self._drawing.show_sides("edges", self._labeled.edge_side, INK, 1.0)
        rows = np.unique(self._labeled.row, return_index=True)[1]
        samples = self._colours[rows[np.unique(np.linspace(0, len(rows) - 1, 6).astype(np.int64))]]
        return [LegendEntry("rows of faces", tuple((int(r), int(g), int(b)) for r, g, b in samples))]

    def show_stitches(self, fabric: StitchMesh) -> list[LegendEntry]:
        """Draw stitches in their colours, and return the legend."""
        if self._shown is not fabric:
            self._shown = fabric
            for name in ("faces", "edges"):
                self._scene.remove(name)
            show_stitches(self._scene, fabric)
        return legend_of_stitches(fabric)

    def show_edges(self, division: Division, chosen: int | None, along: IntArray | None) -> list[LegendEntry]:
        """Draw the edges with numbers or marks, and the chosen edge, and return the legend.

        Args:
            division: the division.
            chosen: a side of the chosen edge; None if there is none.
            along: number of stitches along each edge, shape (E,); None if such stitches are not possible.
        """
        labeled = self._labeled
        edges = {
            "counted": [edge_named(labeled, edge) for edge in division.counts],
            "marked": [edge_named(labeled, edge) for edge in division.marked],
            "chosen": [] if chosen is None else [int(labeled.side_edge[chosen])],
        }
        for name, colour, width, _ in EDGE_MARKS:
            self._drawing.show_sides(name, labeled.edge_side[edges[name]], colour, width)
        self._show_numbers(np.array(edges["counted"] + edges["chosen"], dtype=np.int64), along)
        return [LegendEntry(words, (colour,), line=True) for name, colour, _, words in EDGE_MARKS if edges[name]]

    def _show_numbers(self, edges: IntArray, along: IntArray | None) -> None:
        """Write the numbers of some edges beside them."""
        edges = np.unique(edges)[:150]  # more numbers would hide the mesh
        if along is None or not len(edges):
            self._scene.remove("numbers")
            return
        mesh, sides = self._labeled, self._labeled.edge_side[edges]
        middles = (mesh.corner_position[sides] + mesh.corner_position[mesh.side_next[sides]]) / 2
        self._scene.show("numbers", Labels(middles, tuple(str(count) for count in along[edges].tolist())))


MESH, STITCHES = "mesh", "stitches"
"""The choices of what the page shows."""


@dataclass(frozen=True)
class DivideState:
    """The user's choices on the page."""

    history: UndoHistory[Division]
    """The division that the user prepares, with undo."""
    quality: str = DEFAULT_QUALITY
    """Quality of the yarns for the estimates of time and memory."""
    side: int | None = None
    """A side of the chosen edge; None if none is chosen."""
    shown: str = MESH
    """Whether the page shows the mesh or, where there are any, the stitches."""

    @property
    def division(self) -> Division:
        """The division."""
        return self.history.present

    @property
    def table(self) -> dict[str, Any]:
        """The part of the state that a project keeps."""
        return {"quality": self.quality, "draft": division_table(self.division)}


class DividePage(Page):
    """Divides the labeled mesh of the project into stitches."""

    name = "Divide"
    needs = "Label"
    hint = "Choose a yarn or a stitch size, and press Divide into stitches. Click an edge to set its number."

    def __init__(self, app: App) -> None:
        """Make the page."""
        super().__init__(app)
        self._state = DivideState(UndoHistory(Division()))
        self._labeled: StitchMesh | None = None
        self._typing = False

    def unavailable(self) -> str | None:
        """Return what is missing before the mesh can be divided."""
        if self.app.project.labeled is not None:
            return None
        if self.app.project.labeling is None and self.app.project.fabric is not None:
            return HAS_STITCHES
        if self.app.project.labeling is None:
            return NO_MESH
        return "Not all faces have rows yet. Go back to Label, and label all rows."

    def build(self) -> None:
        """Make the controls, and draw the mesh."""
        kept = self.app.project.settings(self.name)
        self._state = replace(self._state, quality=kept.get("quality", DEFAULT_QUALITY))
        if kept.get("draft") != self._state.table["draft"]:
            division = division_of(kept["draft"]) if "draft" in kept else self.app.project.division
            self._state = replace(self._state, history=UndoHistory(division or Division()))
        controls = self.app.controls
        self._divide_button = controls.button(
            "Divide into stitches", "Divide the mesh into stitches of this size.", self._divide, main=True
        )
        self._go_on = controls.button(
            "Go on: edit the stitches", "The mesh is divided so. Open the page Edit.",
            lambda: self.app.open_page("Edit"), main=True,
        )  # fmt: skip
        self._estimate = controls.html(Markup())
        self._make_size_controls()
        self._make_edge_controls()
        self._changes = UndoRow(controls, self._undo, self._redo)
        self._show_choice = controls.choice(
            "Show", "Whether the mesh or the stitches are shown.", (MESH, STITCHES), self._state.shown, self._show
        )
        self._legend = controls.html(Markup())
        self._labeled = None
        self.refresh()
        self._view.look()

    def _make_size_controls(self) -> None:
        controls, division = self.app.controls, self._state.division
        self._gauge = GaugePanel(
            self.app.project, controls, division.stitch_width, division.stitch_height, self._take_size
        )  # fmt: skip
        self._increase = FieldPanel(
            controls, (INCREASE,), lambda: self._state.division, lambda division, name: self._change(division)
        )
        self._quality = controls.choice(
            "Quality", "Quality of the yarns for which time and memory are estimated.", tuple(PRESETS),
            self._state.quality, lambda name: self._keep(quality=name),
        )  # fmt: skip

    def _make_edge_controls(self) -> None:
        """Make the controls of the chosen edge, and the text of all edges."""
        controls = self.app.controls
        self._edge = controls.html(Markup())
        self._count = controls.number(
            "Number", "Stitches on the chosen edge; on a wale edge, rows of its whole row of faces.", 1,
            self._set_count, least=1, most=10_000, step=1,
        )  # fmt: skip
        self._mark = controls.toggle(
            "Marked edge", "All increases and decreases of the two faces stand at this edge.", False, self._set_mark
        )
        self._by_length = controls.button("Number by length", "Forget the number given by hand.", self._clear_count)
        with controls.group("Without the mouse", opened=False):
            self._numbers = VertexNumbers(self.app.scene, controls)
            self._text = controls.text(
                "Edges", "One edge in each line: V,W=COUNT for a number, V,W for a marked edge.", "", self._set_text,
                lines=4,
            )  # fmt: skip
            self._text_error = controls.html(Markup())

    def refresh(self) -> None:
        """Show the division of the project and the draft."""
        labeled = self.app.project.labeled
        assert labeled is not None
        if labeled is not self._labeled:
            self._take_mesh(labeled)
        if self.app.project.fabric is None or self.app.project.division != self._state.division:
            self._state = replace(self._state, shown=MESH)
        self._show_all()

    def picked(self, pick: Pick) -> None:
        """Choose the edge that is nearest to the click; a click beside the mesh chooses none."""
        place = pick_place(self._table, pick.ray_origin, pick.ray_direction)
        self._state = replace(self._state, side=None if place is None else place.side)
        self._show_all()

    def camera_moved(self) -> None:
        """Show the numbers of the vertices that face the camera."""
        self._numbers.camera_moved()

    def leave(self) -> None:
        """Forget the chosen edge."""
        self._state = replace(self._state, side=None)

    def _take_mesh(self, labeled: StitchMesh) -> None:
        """Prepare the drawing and the picking of a mesh."""
        self._labeled, self._state = labeled, replace(self._state, side=None)
        self._table = picking_table(labeled)
        self._view = DivisionView(self.app.scene, labeled)
        self._numbers.show(labeled)
        fitting = with_known_edges(self._state.division, labeled)
        if fitting != self._state.division:
            self.app.notice("Numbers and marks of edges that this mesh does not have were left out.", "warning")
            self._state = replace(self._state, history=UndoHistory(fitting))

    def _keep(self, **values: Any) -> None:
        """Take and save what the user chose, and show it."""
        self._state = replace(self._state, **values)
        self.app.project.set_settings(self.name, self._state.table)
        self.refresh()

    def _change(self, division: Division, what: str = "") -> None:
        """Take another division; it is undone together with earlier changes of the same thing just before."""
        history = self._state.history
        self._keep(history=history if division == history.present else history.do(division, what))

    def _undo(self) -> None:
        self._keep(history=self._state.history.undo("undo: there is no change of the division to undo"))

    def _redo(self) -> None:
        self._keep(history=self._state.history.redo("redo: there is no change of the division to redo"))

    def _take_size(self, width: float, height: float | None, what: str) -> None:
        self._change(replace(self._state.division, stitch_width=width, stitch_height=height), what)

    def _set_count(self, count: float) -> None:
        labeled, _, edge = self._chosen()
        self._change(with_count(self._state.division, labeled, edge, int(count)), f"number {edge}")

    def _clear_count(self) -> None:
        labeled, _, edge = self._chosen()
        self._change(with_count(self._state.division, labeled, edge, None))

    def _set_mark(self, marked: bool) -> None:
        self._change(with_mark(self._state.division, self._chosen()[2], marked))

    def _set_text(self, text: str) -> None:
        """Take the numbers and marks from a text; a text with an error changes nothing."""
        assert self._labeled is not None
        try:
            settings = parse_edge_settings(text.splitlines(), "line")
            division = with_edges(self._state.division, settings, self._labeled)
        except StitchMeshError as error:
            self._text_error.content = refusal(str(error))
            return
        self._typing = True
        try:
            self._change(division, "text")
        finally:
            self._typing = False

    def _chosen(self) -> tuple[StitchMesh, int, VertexPair]:
        """Return the labeled mesh, a side of the chosen edge, and the two vertices of the edge.

        Raises:
            ParameterError: no edge is chosen.
        """
        labeled, side = self._labeled, self._state.side
        if side is None or labeled is None:
            raise ParameterError("edge: none is chosen; click one first")
        return labeled, side, (int(labeled.face_vertex[side]), int(labeled.face_vertex[labeled.side_next[side]]))

    def _show(self, shown: str) -> None:
        self._state = replace(self._state, shown=shown)
        self._show_all()

    def _show_all(self) -> None:
        """Show the estimate, the buttons, the edges and the drawing."""
        project, state, estimate = self.app.project, self._state, self._estimated()
        division = state.division
        ready = project.fabric is not None and project.division == division
        self._go_on.visible, self._divide_button.visible = ready, not ready
        self._divide_button.disabled = estimate is None or self.app.tasks.running
        self._show_choice.visible, self._show_choice.value = ready, state.shown
        self._gauge.show(division.stitch_width, division.stitch_height)
        self._changes.show(state.history)
        self._increase.show()
        self._show_chosen(estimate)
        if not self._typing:  # The text that the user types stays as it is.
            self._text.value = edge_settings_text(EdgeSettings(dict(division.counts), division.marked))
        self._text_error.content = Markup()
        fabric = project.fabric if state.shown == STITCHES else None
        entries = self._view.show_mesh() if fabric is None else self._view.show_stitches(fabric)
        along = None if estimate is None else estimate.planned.along
        self._legend.content = legend([*entries, *self._view.show_edges(division, state.side, along)])

    def _estimated(self) -> GarmentEstimate | None:
        """Estimate the cost of the garment, and show it; None if such stitches are not possible."""
        assert self._labeled is not None
        division = self._state.division
        try:
            estimate = estimate_garment(
                self._labeled, stitch_width=division.stitch_width, stitch_height=division.stitch_height,
                counts=dict(division.counts), marked=division.marked, quality=self._state.quality,
            )  # fmt: skip
        except StitchMeshError as error:
            self._estimate.content = refusal(str(error))
            return None
        height = drawn_height(division.stitch_width, division.stitch_height)
        self._estimate.content = estimate_table(
            estimate, division.stitch_width, height, yarn_of(self.app.project)
        )  # fmt: skip
        return estimate

    def _show_chosen(self, estimate: GarmentEstimate | None) -> None:
        """Show the chosen edge and its controls."""
        chosen = self._state.side is not None
        for control in (self._count, self._by_length, self._mark):
            control.visible = chosen
        if not chosen:
            hint = '<p style="margin:0;font-size:.88em">Click an edge to set its number of stitches.</p>'
            self._edge.content = markup(hint)
            return
        labeled, side, edge = self._chosen()
        number, division = edge_named(labeled, edge), self._state.division
        same = edges_with_one_count(labeled, number).tolist()
        by_hand = [count for one, count in division.counts.items() if edge_named(labeled, one) in same]
        marked = any(edge_named(labeled, one) == number for one in division.marked)
        count = by_hand[0] if estimate is None and by_hand else 1
        count = count if estimate is None else int(estimate.planned.along[number])
        self._edge.content = edge_text(labeled, side, count, by_hand=bool(by_hand), marked=marked)
        self._count.value, self._mark.value = count, marked
        self._by_length.visible, self._mark.visible = bool(by_hand), bool(labeled.is_wale[side])

    def _divide(self) -> None:
        """Divide the mesh in a worker thread."""
        labeled, division = self._labeled, self._state.division
        assert labeled is not None

        def work(control: TaskControl) -> StitchMesh:
            control.progress("tessellate", 0.0, "dividing the mesh")
            return division.divide(labeled)

        def failed(error: Exception | None) -> None:
            self.app.refresh()

        self.app.tasks.start("dividing the mesh", work, lambda fabric: self._take(division, fabric), failed)
        self._divide_button.disabled = True

    def _take(self, division: Division, fabric: StitchMesh) -> None:
        """Take the divided mesh into the project, unless the mesh of the project has changed since."""
        if self.app.project.labeled is self._labeled:
            lost = self.app.project.divide(division, fabric)
            if lost:
                self.app.notice(f"Other stitches need other edits and yarns. Removed: {', '.join(lost)}.")
            self._state = replace(self._state, shown=STITCHES)
        self.app.refresh()
