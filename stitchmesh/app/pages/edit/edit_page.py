# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Edit: stitches are painted, patterns laid, cables crossed, rows and wales inserted, with undo and redo."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.app.controls.controls import Control
from stitchmesh.app.controls.html_pieces import action_button, paragraph, status_line
from stitchmesh.app.controls.undo_row import UndoRow
from stitchmesh.app.pages.edit.brush_tools import PaintStitches, PaintYarns, SelectStitches
from stitchmesh.app.pages.edit.edit_session import NO_FACES, EditSession
from stitchmesh.app.pages.edit.laying import LayPatterns
from stitchmesh.app.pages.edit.palettes import Palettes
from stitchmesh.app.pages.edit.place_tool import ChangeFabric, ChangeLoops, ChangeRows, CrossCables, LookAround
from stitchmesh.app.pages.edit.selection_panel import SelectionPanel
from stitchmesh.app.pages.edit.tool import Tool
from stitchmesh.app.pages.page import NO_STITCHES, Page
from stitchmesh.app.scene.fabric_blocks import ColourBy
from stitchmesh.app.scene.pointer import visible_faces
from stitchmesh.app.scene.scene import Pick, ScreenBox, Stroke, ViewName
from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting.words import stitch_word
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import SIDE_COUNTS, VOCABULARY, Stitch

if TYPE_CHECKING:
    from stitchmesh.app.application import App

TOOLS: tuple[type[Tool], ...] = (
    PaintStitches, PaintYarns, SelectStitches, LayPatterns, CrossCables, ChangeLoops, ChangeRows, ChangeFabric,
    LookAround,
)  # fmt: skip
"""The tools in their order."""
COLOURS: dict[str, ColourBy] = {"Stitches": "stitch", "Yarns": "yarn", "Rows": "row"}
"""What the colours show, by the words of the page."""
VIEWS: dict[str, ViewName] = {"Front": "front", "Back": "back", "Left": "left", "Right": "right", "Top": "top"}
"""Views by the words of the page."""
TOOL_STYLE = markup("""<style>
.sm-tools{display:grid;grid-template-columns:1fr 1fr 1fr;gap:4px;margin:0 0 .4em}
.sm-tools button{font:inherit;font-size:.8em;line-height:1.2;padding:.45em .2em;border-radius:6px;cursor:pointer;
 border:1px solid var(--mantine-color-default-border);background:var(--mantine-color-default);
 color:var(--mantine-color-text)}
.sm-tools button[aria-pressed=true]{background:#1f5673;border-color:#1f5673;color:#fff;font-weight:600}
.sm-tools button:focus-visible{outline:3px solid #e08a1e;outline-offset:1px}
</style>""")


class EditPage(Page):
    """The page Edit."""

    name = "Edit"
    needs = "Divide"
    hint = "Choose a tool, then click or drag on the stitches; every edit can be undone."
    left_title, left_width = "Stitches and yarns", 250

    def __init__(self, app: App) -> None:
        """Make the tools."""
        super().__init__(app)
        self.session = EditSession(app)
        self.tools = {tool.name: tool(self.session) for tool in TOOLS}
        self.tool: Tool = self.tools[PaintStitches.name]
        self._groups: dict[str, Control] = {}
        self._stroking = -1

    def unavailable(self) -> str | None:
        """Return what is missing while there are no stitches to edit."""
        return NO_STITCHES if self.app.project.fabric is None else None

    def build(self) -> None:
        """Make the controls, and draw the fabric."""
        self.session.view.forget()
        controls = self.app.controls
        self._history = UndoRow(controls, self.undo, self.redo, "the last edit")
        self._bar = controls.html(Markup(), lambda _, name: self.take_up(name))
        self._words = controls.html(Markup())
        for tool in self.tools.values():
            with controls.group(tool.name) as group:
                self._groups[tool.name] = group
                tool.build(controls)
        self._status = controls.html(Markup())
        self._selection = SelectionPanel(self.session, controls)
        self._build_view()
        controls.button("Go on: even out the stitches", "Open the next page", partial(self.app.open_page, "Even out"),
                        main=True)  # fmt: skip
        self._palettes = Palettes(self.session, self.app.left_controls, self._take_stitch, self._take_yarn,
                                  self.tools[LayPatterns.name])  # fmt: skip
        self._build_keys()
        self.session.on_colours = self._show_colours
        self._fit_view(self.session.fabric)
        self.session.show_fabric()
        self._begin(self.tool)
        self._show_state()

    def refresh(self) -> None:
        """Show the fabric after a change."""
        self.session.show_fabric()
        self.tool.refresh()
        self._show_state()

    def leave(self) -> None:
        """End the tool."""
        if self._groups:
            self.tool.laid_down()
            self._palettes.close()
        self._groups = {}

    def picked(self, pick: Pick) -> None:
        """Pass a click on the fabric to the tool; a click beside the fabric removes marks."""
        place = self.session.pointer.place(pick)
        self.session.view.unmark()
        if place is None:
            return
        self._say(place.face)
        self.tool.clicked(place, pick)
        self._selection.show()

    def stroked(self, stroke: Stroke) -> None:
        """Pass a drag on the fabric to the tool."""
        if stroke.phase == "start":
            self._stroking = stroke.client
            self.session.view.unmark()
        if stroke.client != self._stroking:
            return  # Another browser has begun a drag since then.
        self.tool.stroked(stroke)
        if stroke.phase == "end":
            self._selection.show()

    def boxed(self, box: ScreenBox) -> None:
        """Pass the stitches in a rectangle to the tool, if they face the camera."""
        faces = visible_faces(self.session.fabric, box)
        if len(faces):
            self.tool.boxed(faces)
        else:
            self.app.notice("The rectangle holds the middle of no stitch; draw a larger one.", "warning")
        self._selection.show()

    def take_up(self, name: str) -> None:
        """Take up another tool.

        Raises:
            ParameterError: there is no such tool.
        """
        if name not in self.tools:
            raise ParameterError(f"tool: got {name[:40]!r}; expected one of {', '.join(self.tools)}")
        if name == self.tool.name:
            return
        self.tool.laid_down()
        self._begin(self.tools[name])

    def undo(self) -> None:
        """Undo the last edit."""
        self.session.after_change(self.app.project.undo())

    def redo(self) -> None:
        """Make the last undone edit again."""
        self.session.after_change(self.app.project.redo())

    def _begin(self, tool: Tool) -> None:
        self.tool = tool
        view = self.session.view
        view.unmark()
        if view.takes_strokes != tool.takes_strokes:
            view.takes_strokes = tool.takes_strokes
            view.show(self.session.fabric)
        for name, group in self._groups.items():
            group.visible = name == tool.name and tool.name != LookAround.name
        self._bar.content = _tool_bar(tool.name)
        self._words.content = paragraph(tool.hint)
        self._palettes.show_for(tool.name)
        tool.taken_up()

    def _build_view(self) -> None:
        controls, view = self.app.controls, self.session.view
        with controls.group("View"):
            by = next(words for words, name in COLOURS.items() if name == view.colour_by)
            self._colours = controls.choice("Colours", "What decides the colours of the stitches", tuple(COLOURS), by,
                                            lambda words: self.session.colour_by(COLOURS[words]))  # fmt: skip
            controls.toggle("Outlines", "Draw a line around each stitch",
                            view.draws_edges(self.session.fabric), self._set_edges)  # fmt: skip
            controls.toggle("Row numbers", "Write the number of every fifth row on the fabric", view.row_numbers,
                            self._set_row_numbers)  # fmt: skip
            controls.buttons("Look from", "Show the whole fabric from this side", tuple(VIEWS), self._look_from)

    def _build_keys(self) -> None:
        controls = self.app.controls
        controls.key("Select nothing", "Empty the selection", "D", None, self._select_nothing)
        for name, tool in self.tools.items():
            controls.key(f"Tool: {name}", tool.hint, tool.key, None, partial(self.take_up, name))

    def _select_nothing(self) -> None:
        self.session.choose(NO_FACES)
        self._selection.show()

    def _take_stitch(self, stitch: Stitch) -> None:
        self.session.take(stitch=stitch)
        self.take_up(PaintStitches.name)

    def _take_yarn(self, yarn: int) -> None:
        self.session.take(yarn=yarn)
        self.take_up(PaintYarns.name)

    def _set_edges(self, edges: bool) -> None:
        self.session.view.edges = edges
        self.session.view.show(self.session.fabric)

    def _set_row_numbers(self, shown: bool) -> None:
        self.session.view.row_numbers = shown
        self.session.view.show(self.session.fabric)

    def _show_colours(self, by: ColourBy) -> None:
        self._colours.value = next(words for words, name in COLOURS.items() if name == by)

    def _look_from(self, words: str) -> None:
        self._fit_view(self.session.fabric, VIEWS[words])

    def _fit_view(self, fabric: StitchMesh, view: ViewName | None = None) -> None:
        self.app.scene.look_at(fabric.vertices.min(axis=0), fabric.vertices.max(axis=0), view)

    def _show_state(self) -> None:
        """Show which steps can be undone, and the counts."""
        project, fabric = self.app.project, self.session.fabric
        self._history.show(project.edit_history)
        last = f"last edit: {project.edits[-1].name.replace('_', ' ')}" if project.edits else "no edits yet"
        counts = f"{fabric.face_count} stitches in {len(np.unique(fabric.row))} rows, {len(project.edits)} edits"
        self._status.content = status_line(f"{counts}; {last}")
        self._selection.show()
        self._palettes.refresh()

    def _say(self, face: int) -> None:
        self._status.content = status_line(_face_words(self.session.fabric, face))


def _face_words(fabric: StitchMesh, face: int) -> Markup:
    stitch = fabric.stitch_type(int(fabric.stitch[face]))
    name = "panel" if stitch == Stitch.PANEL else stitch_word(stitch, right_side=True)
    loops = f"{fabric.n_bottom[face]} below, {fabric.n_top[face]} above"
    sides = int(fabric.n_bottom[face]), int(fabric.n_top[face])
    fitting = [stitch_word(each, right_side=True) for each in VOCABULARY if SIDE_COUNTS[each] == sides]
    fits = markup("<br>Stitches with these loops: {}", ", ".join(fitting)) if fitting else Markup()
    place = f"row {fabric.row[face]}, loops {loops}, yarn {fabric.yarn[face]}"
    return markup("Stitch {}: <b>{}</b>, {}{}", face, name, place, fits)


def _tool_bar(chosen: str) -> Markup:
    buttons = joined(
        action_button(
            "tool", tool.name, tool.name, hint=f"{tool.hint} Key {tool.key}.", pressed=tool.name == chosen
        )
        for tool in TOOLS
    )
    return markup('{}<div class="sm-tools" role="group" aria-label="Tools">{}</div>', TOOL_STYLE, buttons)
