# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Rows: rows and stitches of a mesh without modelled rows, from marks of where knitting begins and ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.app.controls.field_panel import FieldPanel, Number, setting_field
from stitchmesh.app.controls.html_pieces import (
    LegendEntry,
    colour_bar,
    figures,
    legend,
    refusal,
    status_line,
)
from stitchmesh.app.controls.undo_row import UndoRow
from stitchmesh.app.pages.divide import legend_of_stitches
from stitchmesh.app.pages.gauge_panel import INCREASE, GaugePanel
from stitchmesh.app.pages.page import HAS_STITCHES, NO_MESH, Page
from stitchmesh.app.pages.rows.mark_panel import MarkPanel, border_list
from stitchmesh.app.pages.rows.rows_finder import FINDING_ROWS, FINDING_STITCHES, FoundRows, RowsFinder
from stitchmesh.app.pages.rows.rows_state import (
    BORDER,
    LINE,
    MOVE,
    ROWS,
    STITCHES,
    TIP,
    Marks,
    MeshBorders,
    RowsState,
    with_next_role,
    with_point,
)
from stitchmesh.app.pages.rows.rows_view import ROLE_COLOURS, TIME_COLOURS, RowsView, lines_every
from stitchmesh.app.pages.typed import AXES, three_numbers
from stitchmesh.app.project.shaping import Point, Shaping
from stitchmesh.app.scene.mesh_drawing import INK
from stitchmesh.app.scene.pointer import Pointer
from stitchmesh.app.scene.scene import Pick, Stroke
from stitchmesh.editing.undo_history import UndoHistory
from stitchmesh.errors import ParameterError
from stitchmesh.markup import Markup
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.mesh.picking import picking_table, side_near_ray
from stitchmesh.shaping.options import Placement, ShapingOptions
from stitchmesh.shaping.report import ShapingReport

if TYPE_CHECKING:
    from stitchmesh.app.application import App


ROLE_WORDS = {
    "begin": "knitting begins here", "end": "knitting ends here", "row": "a row runs along this line",
    "side": "rows end at this border", "plain": "no increases or decreases near here",
}  # fmt: skip
"""The meaning of each role, in words."""


def preview_figures(found: FoundRows, shaping: Shaping) -> Markup:
    """Return the figures that are known before there are stitches."""
    stitches = found.area / (shaping.stitch_width * shaping.height)
    return figures([
        ("Rows, one above the other", f"{found.rows:,}"),
        ("Stitches", f"about {stitches:,.0f}"),
    ])  # fmt: skip


def report_figures(report: ShapingReport) -> Markup:
    """Return the figures of the stitches."""
    return figures([
        ("Stitches", f"{report.stitches:,} in {report.rows:,} rows"),
        ("Increases and decreases", f"{report.irregular_per_thousand:.1f} in 1,000 stitches"),
        ("Short rows", f"{report.short_rows:,}"),
        ("Edges at grafts", f"{report.mismatched_edges:,}"),
        ("Distance from the mesh", f"{report.rms_distance:.3f} stitches, at most {report.largest_distance:.2f}"),
        ("Time to find them", f"{report.seconds:.1f} s"),
        *([("Lost", report.lost)] if report.lost else []),
    ])  # fmt: skip


def time_legend(found: FoundRows) -> Markup:
    """Return the legend of the colours and lines of the rows."""
    low, high = float(found.time.min()), float(found.time.max())
    marks = [f"{low:.0f} cm", f"{0.5 * (low + high):.0f}", f"{high:.0f} cm"]
    every = lines_every(found)
    entries = [LegendEntry("each row" if every == 1 else f"every {every} rows", (INK,), line=True)]
    roles = {place.role for place in found.places} | ({"side"} if len(found.side_edges) else set())
    entries += [LegendEntry(ROLE_WORDS[role], (colour,), line=True)
                for role, colour in ROLE_COLOURS.items() if role in roles]  # fmt: skip
    bar = colour_bar(TIME_COLOURS, marks, "Time: length of the fabric from where knitting begins")
    return bar + legend(entries)


class HandleDrag:
    """Shows the dragged point on its way, and moves it at the end of the drag."""

    def __init__(self, view: RowsView, pointer: Pointer, take: Callable[[RowsState], object]) -> None:
        """Begin without a drag; ``take`` is called with the state after each drag."""
        self._view, self._pointer, self._take = view, pointer, take
        self._held: tuple[int, int] | None = None
        self._client = -1
        self._moved: Marks | None = None

    def stroked(self, stroke: Stroke, state: RowsState) -> None:
        """Handle one moment of a drag; only the browser that began the drag can move the point."""
        place = self._pointer.place(stroke)
        if stroke.phase == "start":
            self._held = self._view.handles.under(stroke, None if place is None else place.depth)
            self._client, self._moved = stroke.client, None
            return
        if self._held is None or stroke.client != self._client:
            return
        number, point = self._held
        if place is not None and number < len(state.marks):
            self._moved = with_point(state.marks, number, point, as_point(place.point))
            self._view.show_marks(self._moved, self._held, state.line)
        if stroke.phase == "end":
            moved, self._held, self._moved = self._moved, None, None
            if moved is not None:
                self._take(state.choosing(number, point).with_marks(moved, number))


def as_point(position: FloatArray) -> Point:
    """Return a position as numbers that a project keeps, rounded to a hundredth of a millimetre [cm]."""
    x, y, z = (round(float(number), 3) for number in position)
    return x, y, z


SHAPING_PARTS: dict[str, float | None] = {
    "as many as the mesh asks": None, **{f"1 in {count}": 1.0 / count for count in (2, 3, 4, 6, 8)},
}  # fmt: skip
"""Largest shares of the stitches of a row that are increases or decreases, by the words of the page."""
PLACEMENTS: dict[str, Placement] = {"spread over the row": "spread", "at seams and edges": "seams"}
"""The places of increases and decreases, by the words of the page."""
SHAPING_FIELDS = (
    setting_field(ShapingOptions, "up", "Knitted towards", AXES),
    setting_field(ShapingOptions, "multiple", "Multiple of", Number(1, 1000, 1)),
    setting_field(ShapingOptions, "short_rows", "Short rows"),
    setting_field(ShapingOptions, "most_shaping", "Increases in a row", SHAPING_PARTS),
    setting_field(ShapingOptions, "shaping", "Shaping", PLACEMENTS),
    INCREASE,
)  # fmt: skip
"""The fields of a shaping that the page shows."""


REACH = 0.008
"""Largest angle between a click and the border that it selects [rad], about nine pixels."""
MEANINGS = {
    BORDER: "Click a border: knitting begins there, ends there, rows end there, or it is automatic again.",
    TIP: "Click where a tip is: knitting ends there. Its role can be changed below.",
    LINE: "Click the points of a line along which a row runs, and press Finish the line (F).",
    MOVE: "Click the place to which the chosen point of a tip or a line goes.",
}
"""The meanings of a click, each with its hint."""


class RowsPage(Page):
    """Finds rows and stitches on the mesh of the project."""

    name = "Rows"
    hint = "For a mesh without modelled rows. Click a border: knitting begins or ends there. Drag a mark to move it."

    def __init__(self, app: App) -> None:
        """Make the page."""
        super().__init__(app)
        self._state = RowsState(UndoHistory(Shaping()))
        self._finder = RowsFinder(app.tasks, self._take_found)

    def unavailable(self) -> str | None:
        """Return what is missing before rows can be found."""
        if self.app.project.mesh is not None:
            return None
        if self.app.project.fabric is not None:
            return HAS_STITCHES
        return NO_MESH

    def build(self) -> None:
        """Make the controls, and draw the mesh."""
        project = self.app.project
        kept = project.settings(self.name)
        if kept.get("draft") != self._state.table:
            kept_state = RowsState.of_settings(kept, project.shaping or Shaping())
            self._state = replace(kept_state, meaning=self._state.meaning, shown=self._state.shown)
        self._make_main_controls()
        self._marks = MarkPanel(self._state, self.app.controls, self._take)
        shaping = self._state.shaping
        self._gauge = GaugePanel(
            project, self.app.controls, shaping.stitch_width, shaping.stitch_height, self._take_size
        )  # fmt: skip
        self._sizes = FieldPanel(
            self.app.controls, SHAPING_FIELDS, lambda: self._state.shaping, self._take_shaping,
            group="How rows are found",
        )  # fmt: skip
        self._make_other_controls()
        self._drawn: Mesh | None = None
        self.refresh()
        self._view.look()

    def _make_main_controls(self) -> None:
        controls = self.app.controls
        self._find = controls.button(
            "Find the stitches", "Find stitches of the full size along these rows.", self._find_stitches, main=True
        )
        self._knit = controls.button(
            "Knit these rows", "Take these stitches into the project.", self._knit_rows, main=True
        )
        self._go_on = controls.button(
            "Go on: edit the stitches", "The stitches are in the project. Open the page Edit.",
            lambda: self.app.open_page("Edit"), main=True,
        )  # fmt: skip
        self._stop = controls.button("Stop", "End the search for stitches.", self._finder.stop)
        self._again = controls.button("Find the rows", "Find the rows, now that nothing else runs.", self._find_rows)
        self._status = controls.html(Markup())
        self._choice = controls.choice(
            "Show", "Whether the rows or the stitches are shown.", (ROWS, STITCHES), self._state.shown,
            lambda shown: self._take(replace(self._state, shown=shown)),
        )  # fmt: skip
        self._legend = controls.html(Markup())
        self._click = controls.choice(
            "A click", "What a click on the mesh does.", tuple(MEANINGS), self._state.meaning, self._mean
        )
        self._click_hint = controls.html(Markup())
        self._finish = controls.button(
            "Finish the line", "Make a mark of the points that were clicked (F).", self._finish_line
        )
        self._changes = UndoRow(controls, self._undo, self._redo)

    def _make_other_controls(self) -> None:
        """Make the controls that replace the mouse, and the keys."""
        controls = self.app.controls
        with controls.group("Without the mouse", opened=False):
            self._borders_list = controls.html(Markup(), self._clicked_border)
            self._place = controls.text("Place", "A place on the mesh, such as 3, 20.5, 8 [cm].", "")
            controls.button("Act at this place", "Do there what a click does.", self._act_at_typed_place)
        controls.key("Finish the line", "Make a mark of the points that were clicked.", "F", None, self._finish_line)

    def refresh(self) -> None:
        """Show the rows of the project's mesh after its repair."""
        mesh = self.app.project.surface
        assert mesh is not None
        self._finder.take_mesh(mesh)
        if mesh is not self._drawn:
            self._take_mesh(mesh)
        if not self._finder.knows(self._state.shaping) and self._finder.running is None:
            self._finder.find_rows(self._state.shaping)
        self._show_all()

    def leave(self) -> None:
        """End the search for rows, because it would hold up other pages; a search for stitches goes on unseen."""
        if self._finder.running == FINDING_ROWS:
            self._finder.stop()

    def picked(self, pick: Pick) -> None:
        """Do what a click means; a click at a point of a mark chooses this mark."""
        place = self._pointer.place(pick)
        handle = self._view.handles.under(pick, None if place is None else place.depth)
        if handle is not None and not self._state.aims:
            self._take(self._state.choosing(*handle))
        elif self._state.meaning == BORDER:
            side = side_near_ray(self._table, self._borders.sides, pick.ray_origin, pick.ray_direction, REACH)
            if side is not None:
                self._next_role(self._borders.of_side(side))
        elif place is not None:
            self._act_at(as_point(place.point))

    def stroked(self, stroke: Stroke) -> None:
        """Drag a point of a mark."""
        self._drag.stroked(stroke, self._state)

    def _take_mesh(self, mesh: Mesh) -> None:
        self._drawn, self._table = mesh, picking_table(mesh)
        self._borders, self._pointer = MeshBorders(mesh), Pointer(mesh)
        self._view = RowsView(self.app.scene, self._borders, self._table)
        self._drag = HandleDrag(self._view, self._pointer, self._take)

    def _take(self, state: RowsState) -> None:
        """Take another state and show it; another shaping is saved, and its rows are found."""
        changed = state.shaping != self._state.shaping
        self._state = replace(state, shown=ROWS) if changed else state
        if changed:
            self.app.project.set_settings(self.name, {"draft": state.table})
            self._finder.find_rows(state.shaping)
        self._show_all()

    def _take_shaping(self, shaping: Shaping, name: str) -> None:
        """Take another shaping; consecutive changes of a number are undone together."""
        self._take(self._state.with_shaping(shaping, "multiple" if name == "multiple" else ""))

    def _take_size(self, width: float, height: float | None, what: str) -> None:
        shaping = replace(self._state.shaping, stitch_width=width, stitch_height=height)
        self._take(self._state.with_shaping(shaping, what))

    def _act_at(self, point: Point) -> None:
        state = self._state
        if state.meaning == BORDER:
            border = self._borders.nearest(point)
            if border is not None:
                self._next_role(border)
        elif state.meaning == TIP:
            self._take(state.with_tip(point))
        elif state.meaning == LINE:
            self._take(state.with_line_point(point))
        else:
            number, _ = state.chosen_mark()
            self._take(state.with_marks(with_point(state.marks, number, state.point, point), number))

    def _next_role(self, border: int) -> None:
        marks = with_next_role(self._state.marks, self._borders, border)
        self._take(self._state.with_marks(marks, self._borders.mark_of(marks, border)))

    def _clicked_border(self, action: str, value: str) -> None:
        if value.isdecimal() and int(value) < len(self._borders.loops):
            self._next_role(int(value))

    def _act_at_typed_place(self) -> None:
        """Do what a click means, at the vertex or the place of the mesh nearest to the typed place."""
        self._act_at(as_point(self._nearest_place(three_numbers("place", self._place.value))))

    def _nearest_place(self, point: Point) -> np.ndarray:
        """Return the corner or the middle of a face that is nearest to a point [cm]."""
        places = np.concatenate([self._table.mesh.vertices, self._table.centre])
        nearest: np.ndarray = places[np.linalg.norm(places - np.array(point), axis=1).argmin()]
        return nearest

    def _finish_line(self) -> None:
        self._take(self._state.with_finished_line())

    def _undo(self) -> None:
        self._take(self._state.undone())

    def _redo(self) -> None:
        self._take(self._state.redone())

    def _mean(self, meaning: str) -> None:
        """Take the meaning of clicks; an unfinished line is dropped."""
        self._take(replace(self._state, meaning=meaning, line=()))

    def _find_rows(self) -> None:
        self._finder.find_rows(self._state.shaping)
        self._show_all()

    def _find_stitches(self) -> None:
        self._finder.find_stitches(self._state.shaping)
        self._show_all()

    def _take_found(self, new_stitches: bool) -> None:
        """Show the result of a search, if the page is still open on its project."""
        if self.app.page is self and self.app.project.surface is self._finder.mesh:
            self._take(replace(self._state, shown=STITCHES) if new_stitches else self._state)

    def _knit_rows(self) -> None:
        shaping = self._state.shaping
        shaped = self._finder.shaped(shaping)
        if shaped is None:
            raise ParameterError("knit: the marks have changed; find the stitches anew first")
        lost = self.app.project.shape(shaping, shaped.fabric)
        if lost:
            self.app.notice(f"Other stitches need other edits and yarns. Removed: {', '.join(lost)}.")
        self.app.refresh()

    def _fabric(self) -> StitchMesh | None:
        """The stitches for the present marks; None before they are found."""
        project, shaping = self.app.project, self._state.shaping
        if project.shaping == shaping:
            return project.fabric
        shaped = self._finder.shaped(shaping)
        return None if shaped is None else shaped.fabric

    def _show_all(self) -> None:
        """Show the buttons, the figures, the marks and the drawing."""
        fabric = self._fabric()
        if fabric is None:
            self._state = replace(self._state, shown=ROWS)
        state = self._state
        knitted = fabric is not None and self.app.project.shaping == state.shaping
        self._go_on.visible, self._knit.visible = knitted, fabric is not None and not knitted
        self._find.visible = fabric is None
        self._choice.visible = fabric is not None
        self._choice.value = state.shown
        self._finish.visible = bool(state.line)
        self._changes.show(state.history, unfinished=bool(state.line))
        self._click_hint.content = status_line(self._words_of_click())
        self._marks.show(state, self._borders, self._finder.found)
        self._gauge.show(state.shaping.stitch_width, state.shaping.stitch_height)
        self._sizes.show()
        self._borders_list.content = border_list(self._borders, state.marks)
        self._show_status()
        self._draw(fabric)

    def _words_of_click(self) -> str:
        points = len(self._state.line)
        begun = f"The line has {points} point{'s' * (points != 1)}. " if points else ""
        return begun + MEANINGS[LINE if points else self._state.meaning]

    def _show_status(self) -> None:
        """Show the running work, the figures, or the reason why there are no rows."""
        finder = self._finder
        finds, blocked = finder.running == FINDING_STITCHES, finder.blocked_by is not None
        self._find.disabled = finds or blocked or bool(finder.error)
        self._stop.visible = finds
        self._again.visible = finder.running is None and not blocked and not finder.knows(self._state.shaping)
        self._status.content = self._status_html()

    def _status_html(self) -> Markup:
        finder, shaping = self._finder, self._state.shaping
        if finder.blocked_by is not None:
            return status_line(f"The rows can be found when the program has ended {finder.blocked_by}.")
        if finder.running == FINDING_STITCHES:
            return status_line("Finding the stitches; the more there are, the longer it takes.")
        if finder.error and finder.running is None:
            return refusal(finder.error)
        if finder.found is None:
            return status_line("Finding the rows.")
        shaped = finder.shaped(shaping)
        return preview_figures(finder.found, shaping) if shaped is None else report_figures(shaped.report)

    def _draw(self, fabric: StitchMesh | None) -> None:
        state = self._state
        if fabric is not None and state.shown == STITCHES:
            self._view.show_stitches(fabric)
            self._legend.content = legend(legend_of_stitches(fabric))
        elif self._finder.found is not None:
            self._view.show_found(self._finder.found)
            self._legend.content = time_legend(self._finder.found)
        else:
            self._view.show_bare()
            self._legend.content = Markup()
        self._view.show_marks(state.marks, state.handle, state.line)
