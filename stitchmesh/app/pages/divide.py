# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Divide: how large the stitches are, and how many stand on single edges (Yuksel et al. 2012, section 5.2)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from stitchmesh.app.controls.legend import LegendEntry, legend
from stitchmesh.app.pages.divide_text import (
    CHOSEN_COLOUR,
    COUNTED_COLOUR,
    MARKED_COLOUR,
    edge_text,
    estimate_table,
    legend_of_stitches,
    refusal,
)
from stitchmesh.app.pages.label_text import INK
from stitchmesh.app.pages.page import Page
from stitchmesh.app.project.division import Division, division_of, division_table, with_known_edges
from stitchmesh.app.scene.drawing import Colour, Labels
from stitchmesh.app.scene.mesh_drawing import MeshDrawing
from stitchmesh.app.scene.scene import Pick
from stitchmesh.app.task import TaskControl
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.picking import pick as pick_place
from stitchmesh.mesh.picking import picking_table
from stitchmesh.quality import DEFAULT_QUALITY, PRESETS
from stitchmesh.recipe.estimate import GarmentEstimate, estimate_garment
from stitchmesh.render.palette import stitch_colours
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING
from stitchmesh.tessellate.counts import edge_named
from stitchmesh.tessellate.edge_file import (
    EdgeSettings,
    VertexPair,
    edge_settings_text,
    parse_edge_settings,
)
from stitchmesh.yarn.colours import row_colours
from stitchmesh.yarn.yarn_presets import Yarn, yarn_names

if TYPE_CHECKING:
    from stitchmesh.app.application import App

OWN_SIZE = "own size"
"""Choice of the yarn if the sizes are the user's own."""
SMALLEST_WIDTH, LARGEST_WIDTH = 0.1, 5.0
"""Bounds of the stitch width [cm]."""
MOST_COUNT = 10_000
"""Largest number of stitches on one edge."""
MOST_LABELED = 150
"""Number of edges whose numbers are shown in the scene."""
MOST_EDGES_DRAWN = 30_000
"""Number of stitches up to which the edges of stitches are drawn."""
STITCH_EDGE_COLOUR: Colour = (128, 120, 110)
"""Colour of the edges of stitches."""
MESH, STITCHES = "mesh", "stitches"


class DividePage(Page):
    """Divides the labeled mesh of the project into stitches."""

    name = "Divide"
    hint = "Choose a yarn or a stitch size, and press Divide into stitches. Click an edge to set its number."

    def __init__(self, app: App) -> None:
        """Make the page."""
        super().__init__(app)
        self._draft = Division()
        self._settings: dict[str, str] = {}
        self._labeled: StitchMesh | None = None
        self._undone: list[Division] = []
        self._done: list[Division] = []
        self._side: int | None = None
        self._shown = MESH

    def unavailable(self) -> str | None:
        """Say what is missing."""
        if self.app.project.labeled is not None:
            return None
        if self.app.project.labeling is None and self.app.project.fabric is not None:
            return "The imported file holds stitches already. Go on with Edit."
        if self.app.project.labeling is None:
            return "There is no mesh yet. Open the page Project and import one, or choose an example."
        return "Not all faces have rows yet. Go back to Label, and label all rows."

    def build(self) -> None:
        """Make the controls, and draw the mesh."""
        self._read_settings()
        controls = self.app.controls
        self._divide_button = controls.button(
            "Divide into stitches", "Divide the mesh into stitches of this size.", self._divide, main=True
        )
        self._go_on = controls.button(
            "Go on: edit the stitches", "The mesh is divided so. Open the page Edit.", self._edit, main=True
        )
        self._estimate = controls.html("")
        self._make_size_controls()
        self._make_edge_controls()
        self._show_choice = controls.choice(
            "Show", "Whether the mesh or the stitches are shown.", (MESH, STITCHES), self._shown, self._show
        )
        self._legend = controls.html("")
        controls.key("Undo the last change", "Undo the last change of the division.", "Z", "ctrl", self._undo)
        controls.key("Redo the change", "Make the change again.", "Y", "ctrl", self._redo)
        self._labeled = None
        self.refresh()
        self._drawing.look()

    def _make_size_controls(self) -> None:
        """Make the controls of the sizes."""
        controls, draft = self.app.controls, self._draft
        self._yarn = controls.choice(
            "Yarn", "A hand-knitting yarn at its usual gauge, or your own size.", (OWN_SIZE, *yarn_names()),
            self._settings["yarn"], self._take_yarn,
        )  # fmt: skip
        self._width = controls.slider(
            "Stitch width", "Width of a stitch in cm; type it for an exact one.", draft.stitch_width,
            lambda width: self._set_size(width=width), least=min(SMALLEST_WIDTH, draft.stitch_width),
            most=max(LARGEST_WIDTH, draft.stitch_width), step=0.01,
        )  # fmt: skip
        self._usual = controls.toggle(
            "Usual height", "The height of a stitch is 0.77 of its width, as in relaxed stockinette.",
            draft.stitch_height is None, self._set_usual,
        )  # fmt: skip
        self._height = controls.slider(
            "Stitch height", "Height of a stitch in cm.", _height(draft), lambda height: self._set_size(height=height),
            least=min(SMALLEST_WIDTH / 2, _height(draft)), most=max(LARGEST_WIDTH, _height(draft)), step=0.01,
        )  # fmt: skip
        self._quality = controls.choice(
            "Quality", "Quality of the yarns for which time and memory are estimated.", tuple(PRESETS),
            self._settings["quality"], lambda name: self._keep_setting("quality", name),
        )  # fmt: skip

    def _make_edge_controls(self) -> None:
        """Make the controls of the chosen edge, and the text of all edges."""
        controls = self.app.controls
        self._edge = controls.html("")
        self._count = controls.number(
            "Number", "Stitches on the chosen edge; on a wale edge, rows of its whole row of faces.", 1,
            self._set_count, least=1, most=MOST_COUNT, step=1,
        )  # fmt: skip
        self._mark = controls.toggle(
            "Marked edge", "All increases and decreases of the two faces stand at this edge.", False, self._set_mark
        )
        self._by_length = controls.button("Number by length", "Forget the number given by hand.", self._clear_count)
        with controls.group("Without the mouse", opened=False):
            self._text = controls.text(
                "Edges", "One edge in each line: V,W=COUNT for a number, V,W for a marked edge.", "", self._set_text,
                lines=4,
            )  # fmt: skip
            self._text_error = controls.html("")

    def refresh(self) -> None:
        """Show the division of the project and the draft."""
        labeled = self.app.project.labeled
        if labeled is None:
            return
        if labeled is not self._labeled:
            self._take_mesh(labeled)
        if self.app.project.fabric is None or self.app.project.division != self._draft:
            self._shown = MESH
        self._show_all()

    def picked(self, pick: Pick) -> None:
        """Choose the edge that is nearest to the click; a click beside the mesh chooses none."""
        place = pick_place(self._table, pick.ray_origin, pick.ray_direction)
        self._side = None if place is None else place.side
        self._show_all()

    def leave(self) -> None:
        """Forget the chosen edge."""
        self._side = None

    def _take_mesh(self, labeled: StitchMesh) -> None:
        """Prepare the drawing and the picking of a mesh."""
        self._labeled, self._side = labeled, None
        self._table = picking_table(labeled)
        self._drawing = MeshDrawing(self.app.scene, labeled)
        fitting = with_known_edges(self._draft, labeled)
        if fitting != self._draft:
            self.app.notice("Numbers and marks of edges that this mesh does not have were left out.", "warning")
            self._draft = fitting

    def _read_settings(self) -> None:
        """Read what was chosen on this page; a division of the project counts more."""
        kept: dict[str, Any] = {"yarn": OWN_SIZE, "quality": DEFAULT_QUALITY, **self.app.project.settings(self.name)}
        self._settings = {"yarn": kept["yarn"], "quality": kept["quality"]}
        self._draft = division_of(kept["draft"]) if "draft" in kept else Division()

    def _keep_setting(self, name: str, value: str) -> None:
        self._settings[name] = value
        self._keep()

    def _keep(self) -> None:
        """Save what was chosen, and show it."""
        self.app.project.set_settings(self.name, {**self._settings, "draft": division_table(self._draft)})
        self.refresh()

    def _change(self, draft: Division) -> None:
        """Take another division; it can be undone."""
        if draft != self._draft:
            self._done.append(self._draft)
            self._undone.clear()
        self._draft = draft
        self._keep()

    def _undo(self) -> None:
        self._step(self._done, self._undone, "undo")

    def _redo(self) -> None:
        self._step(self._undone, self._done, "redo")

    def _step(self, source: list[Division], target: list[Division], what: str) -> None:
        """Take the newest division of a list, and keep the present one in the other list."""
        if not source:
            raise ParameterError(f"{what}: there is no change of the division to {what}")
        target.append(self._draft)
        self._draft = source.pop()
        self._show_sizes()
        self._keep()

    def _take_yarn(self, name: str) -> None:
        """Take the usual gauge of a yarn."""
        self._settings["yarn"] = name
        if name != OWN_SIZE:
            gauge = Yarn.named(name).gauge
            self._change(replace(self._draft, stitch_width=gauge.stitch_width, stitch_height=gauge.stitch_height))
            self._show_sizes()
        else:
            self._keep()

    def _set_size(self, width: float | None = None, height: float | None = None) -> None:
        """Take a size that the user has chosen."""
        draft = self._draft
        width = draft.stitch_width if width is None else width
        height = draft.stitch_height if height is None else height
        self._settings["yarn"] = self._yarn.value = OWN_SIZE
        self._change(replace(draft, stitch_width=width, stitch_height=None if self._usual.value else height))

    def _set_usual(self, usual: bool) -> None:
        height = None if usual else round(_height(self._draft), 3)
        self._settings["yarn"] = self._yarn.value = OWN_SIZE
        self._change(replace(self._draft, stitch_height=height))
        self._show_sizes()

    def _show_sizes(self) -> None:
        """Show the sizes of the draft in their controls."""
        self._width.value = round(self._draft.stitch_width, 3)
        self._usual.value = self._draft.stitch_height is None
        self._height.value = round(_height(self._draft), 3)

    def _set_count(self, count: float) -> None:
        """Give the chosen edge a number."""
        edge = self._chosen()
        self._change(replace(self._draft, counts={**self._without(edge), edge: int(count)}))

    def _clear_count(self) -> None:
        self._change(replace(self._draft, counts=self._without(self._chosen())))

    def _set_mark(self, marked: bool) -> None:
        """Mark the chosen edge, or remove its mark."""
        edge = self._chosen()
        others = tuple(one for one in self._draft.marked if set(one) != set(edge))
        self._change(replace(self._draft, marked=(*others, edge) if marked else others))

    def _set_text(self, text: str) -> None:
        """Take the numbers and marks of a text; a text with an error changes nothing."""
        try:
            settings = parse_edge_settings(text.splitlines(), "line")
            draft = _with_edges(self._draft, settings)
            assert self._labeled is not None
            for edge in (*draft.counts, *draft.marked):
                edge_named(self._labeled, edge)
        except StitchMeshError as error:
            self._text_error.content = refusal(str(error))
            return
        self._change(draft)

    def _without(self, edge: VertexPair) -> dict[VertexPair, int]:
        """The numbers given by hand without that of an edge and, for a wale edge, of the other edges of its row."""
        labeled = self._labeled
        assert labeled is not None
        same = _edges_with_one_number(labeled, edge_named(labeled, edge))
        return {one: count for one, count in self._draft.counts.items() if edge_named(labeled, one) not in same}

    def _chosen(self) -> VertexPair:
        """The chosen edge by its two vertices.

        Raises:
            ParameterError: no edge is chosen.
        """
        if self._side is None or self._labeled is None:
            raise ParameterError("edge: none is chosen; click one first")
        return _ends(self._labeled, self._side)

    def _show(self, shown: str) -> None:
        """Show the mesh or the stitches."""
        self._shown = shown
        self._show_all()

    def _show_all(self) -> None:
        """Show the estimate, the buttons, the edges and the drawing."""
        project, estimate = self.app.project, self._estimated()
        ready = project.fabric is not None and project.division == self._draft
        self._go_on.visible, self._divide_button.visible = ready, not ready
        self._divide_button.disabled = estimate is None or self.app.tasks.running
        self._show_choice.visible = ready
        self._show_choice.value = self._shown
        self._height.visible = not self._usual.value
        self._show_edge(estimate)
        self._draw(estimate)

    def _estimated(self) -> GarmentEstimate | None:
        """Estimate what the garment costs, and show it; None if such stitches are not possible."""
        assert self._labeled is not None
        draft, yarn = self._draft, self._settings["yarn"]
        try:
            estimate = estimate_garment(
                self._labeled, stitch_width=draft.stitch_width, stitch_height=draft.stitch_height,
                counts=dict(draft.counts), marked=draft.marked, quality=self._settings["quality"],
            )  # fmt: skip
        except StitchMeshError as error:
            self._estimate.content = refusal(str(error))
            return None
        known = None if yarn == OWN_SIZE else Yarn.named(yarn)
        self._estimate.content = estimate_table(estimate, draft.stitch_width, _height(draft), known)
        return estimate

    def _show_edge(self, estimate: GarmentEstimate | None) -> None:
        """Show the chosen edge and its controls, and all edges as text."""
        self._text.value = edge_settings_text(EdgeSettings(dict(self._draft.counts), self._draft.marked))
        self._text_error.content = ""
        labeled, side = self._labeled, self._side
        chosen = side is not None and labeled is not None and estimate is not None
        by_hand = marked = False
        if side is not None and labeled is not None and estimate is not None:
            edge = int(labeled.side_edge[side])
            same = _edges_with_one_number(labeled, edge)
            by_hand = any(edge_named(labeled, one) in same for one in self._draft.counts)
            marked = any(edge_named(labeled, one) == edge for one in self._draft.marked)
            count = int(estimate.planned.along[edge])
            self._edge.content = edge_text(labeled, side, count, by_hand=by_hand, marked=marked)
            self._count.value, self._mark.value = count, marked
        else:
            self._edge.content = '<p style="margin:0;font-size:.88em">Click an edge to set its number of stitches.</p>'
        self._count.visible = chosen
        self._by_length.visible = chosen and by_hand
        self._mark.visible = chosen and bool(labeled is not None and side is not None and labeled.is_wale[side])

    def _draw(self, estimate: GarmentEstimate | None) -> None:
        """Draw the mesh or the stitches, and the edges with numbers or marks."""
        labeled, fabric = self._labeled, self.app.project.fabric
        assert labeled is not None
        entries = self._draw_stitches(fabric) if fabric is not None and self._shown == STITCHES else self._draw_mesh()
        drawing, draft = self._drawing, self._draft
        counted = np.array([edge_named(labeled, edge) for edge in draft.counts], dtype=np.int64)
        marked = np.array([edge_named(labeled, edge) for edge in draft.marked], dtype=np.int64)
        drawing.show_sides("counted", labeled.edge_side[counted], COUNTED_COLOUR, 6.0)
        drawing.show_sides("marked", labeled.edge_side[marked], MARKED_COLOUR, 6.0)
        chosen = np.array([] if self._side is None else [self._side], dtype=np.int64)
        drawing.show_sides("chosen", chosen, CHOSEN_COLOUR, 8.0)
        self._draw_numbers(estimate, np.concatenate([counted, labeled.side_edge[chosen]]))
        if len(counted):
            entries.append(LegendEntry("number given by hand", (COUNTED_COLOUR,), line=True))
        if len(marked):
            entries.append(LegendEntry("marked: increases and decreases stand here", (MARKED_COLOUR,), line=True))
        if len(chosen):
            entries.append(LegendEntry("chosen edge", (CHOSEN_COLOUR,), line=True))
        self._legend.content = legend(entries)

    def _draw_mesh(self) -> list[LegendEntry]:
        """Draw the faces of the mesh in the colours of their rows, and return the legend."""
        labeled, scene = self._labeled, self.app.scene
        assert labeled is not None
        for name in ("stitches", "stitch edges"):
            scene.remove(name)
        self._drawing.show_faces("faces", row_colours(labeled.row))
        self._drawing.show_sides("edges", labeled.edge_side, INK, 1.0)
        return [LegendEntry("rows of faces", tuple(_row_samples(labeled)))]

    def _draw_stitches(self, fabric: StitchMesh) -> list[LegendEntry]:
        """Draw the stitches, and return the legend."""
        for name in ("faces", "edges"):
            self.app.scene.remove(name)
        drawing = MeshDrawing(self.app.scene, fabric)
        drawing.show_faces("stitches", stitch_colours(fabric.stitch, fabric.row))
        if fabric.face_count <= MOST_EDGES_DRAWN:
            drawing.show_sides("stitch edges", fabric.edge_side, STITCH_EDGE_COLOUR, 1.0)
        return legend_of_stitches(fabric)

    def _draw_numbers(self, estimate: GarmentEstimate | None, edges: IntArray) -> None:
        """Write the numbers of some edges beside them."""
        edges = np.unique(edges)[:MOST_LABELED]
        labeled = self._labeled
        if estimate is None or labeled is None or not len(edges):
            self.app.scene.remove("numbers")
            return
        texts = tuple(str(count) for count in estimate.planned.along[edges].tolist())
        self.app.scene.show("numbers", Labels(_middles(labeled, labeled.edge_side[edges]), texts))

    def _divide(self) -> None:
        """Divide the mesh in a worker thread."""
        labeled, draft = self._labeled, self._draft
        assert labeled is not None
        self._divide_button.disabled = True

        def work(control: TaskControl) -> StitchMesh:
            control.progress("tessellate", 0.0, "dividing the mesh")
            return draft.divide(labeled)

        self.app.tasks.start("dividing the mesh", work, lambda fabric: self._take(draft, fabric), self._failed)

    def _take(self, draft: Division, fabric: StitchMesh) -> None:
        """Take the divided mesh into the project, unless the mesh has changed meanwhile."""
        if self.app.project.labeled is self._labeled:
            lost = self.app.project.divide(draft, fabric)
            if lost:
                self.app.notice(f"Other stitches need other edits and yarns. Removed: {', '.join(lost)}.")
            self._shown = STITCHES
        self.app.refresh()

    def _failed(self, error: Exception | None) -> None:
        self.app.refresh()

    def _edit(self) -> None:
        self.app.open_page("Edit")


def _height(division: Division) -> float:
    """Course spacing of a division [cm]."""
    if division.stitch_height is None:
        return COURSE_OVER_WALE_SPACING * division.stitch_width
    return division.stitch_height


def _with_edges(division: Division, settings: EdgeSettings) -> Division:
    """The division with the numbers and marks of some settings in place of its own."""
    counts = {edge: count for edge, count in settings.counts.items() if isinstance(edge, tuple)}
    return replace(division, counts=counts, marked=settings.marked)


def _edges_with_one_number(labeled: StitchMesh, edge: int) -> set[int]:
    """The edges that take one number: the wale edges of a row, or a course edge alone."""
    side = labeled.edge_side[edge]
    if not labeled.is_wale[side]:
        return {edge}
    in_row = labeled.is_wale & (labeled.row[labeled.side_face] == labeled.row[labeled.side_face[side]])
    return set(labeled.side_edge[in_row].tolist())


def _ends(labeled: StitchMesh, side: int) -> VertexPair:
    return int(labeled.face_vertex[side]), int(labeled.face_vertex[labeled.side_next[side]])


def _middles(labeled: StitchMesh, sides: IntArray) -> FloatArray:
    """The middles of sides [cm], shape (n, 3)."""
    middles: FloatArray = (labeled.corner_position[sides] + labeled.corner_position[labeled.side_next[sides]]) / 2
    return middles


def _row_samples(labeled: StitchMesh) -> list[tuple[int, int, int]]:
    """A few colours of rows, from the first to the last."""
    rows = np.unique(np.linspace(0, int(labeled.row.max()), 6).astype(np.int64))
    colours = row_colours(np.arange(int(labeled.row.max()) + 1))[rows]
    return [(int(red), int(green), int(blue)) for red, green, blue in colours]
