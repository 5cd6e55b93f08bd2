# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tools that make an edit at the place of a click, or at each place of the selection."""

from __future__ import annotations

from functools import partial
from typing import Any, ClassVar

import numpy as np

from stitchmesh.app.controls.controls import Control, Controls
from stitchmesh.app.controls.html_pieces import paragraph
from stitchmesh.app.pages.edit.edit_session import EditSession
from stitchmesh.app.pages.edit.nearest_side import nearest_side
from stitchmesh.app.pages.edit.place_edits import LOOP_EDITS, ROW_EDITS, PlaceEdit, Setting, add_setting, value_of
from stitchmesh.app.pages.edit.tool import Tool
from stitchmesh.app.scene.scene import Pick
from stitchmesh.errors import StitchMeshError
from stitchmesh.markup import Markup
from stitchmesh.mesh.picking import PickedPlace


class PlaceTool(Tool):
    """Makes one of several edits at the place of a click."""

    edits: ClassVar[tuple[PlaceEdit, ...]]
    """The edits to choose from."""
    what: ClassVar[str]
    """What the edits change, for labels."""
    takes_strokes = False

    def __init__(self, session: EditSession) -> None:
        """Start with the first edit, and with the first value of each setting."""
        super().__init__(session)
        self.chosen = self.edits[0]
        self._values = {setting: setting.start for edit in self.edits for setting in edit.settings}
        self._shown: dict[Setting, Control] = {}

    def build(self, controls: Controls) -> None:
        """Make the choice of the edit, the settings of all edits, and the button for the selection."""
        labels = [edit.label for edit in self.edits]
        controls.choice(f"Edit of {self.what}", "What a click does", labels, self.chosen.label, self._choose)
        self._words = controls.html(Markup())
        self._shown = {}
        for setting, start in self._values.items():
            self._shown[setting] = add_setting(controls, setting, start, partial(self._set, setting))
        controls.button(f"Edit the selected {self.what}", "Make the chosen edit at each place of the selection",
                        self.on_selection)  # fmt: skip
        self._show_settings()

    def clicked(self, place: PickedPlace, pick: Pick) -> None:
        """Make the edit at the place."""
        fabric, edit = self.session.fabric, self.chosen
        at = np.array([place.face])
        if edit.place == "selection":
            self.session.refuse(at, f"{edit.label}: select the stitches first, then press the button of the tool")
            return
        if edit.place == "face":
            self.session.edit(edit.edit, {"face": place.face, **self._arguments()}, at)
            return
        try:
            side = nearest_side(fabric, place, edit.place)
        except StitchMeshError as error:
            self.session.refuse(at, str(error))
            return
        if not self.session.edit(edit.edit, {"side": side, **self._arguments()}, at):
            self.session.view.mark_sides(fabric, np.array([side]))

    def on_selection(self) -> None:
        """Make the edit at each place of the selection."""
        arguments = {**self.session.on_selection(), **self._arguments()}
        self.session.edit(self.chosen.edit, arguments, self.session.selection.faces)

    def _arguments(self) -> dict[str, object]:
        values = {each.argument: value_of(each, self._values[each]) for each in self.chosen.settings}
        return {name: value for name, value in values.items() if value is not None}

    def _choose(self, label: str) -> None:
        self.chosen = next(edit for edit in self.edits if edit.label == label)
        self.session.view.unmark()
        self._show_settings()

    def _set(self, setting: Setting, value: Any) -> None:
        self._values[setting] = value

    def _show_settings(self) -> None:
        self._words.content = paragraph(self.chosen.hint)
        for setting, control in self._shown.items():
            control.visible = setting in self.chosen.settings


class ChangeLoops(PlaceTool):
    """Edits of loops and edges."""

    name, key, what, edits = "Loops and edges", "L", "loops", LOOP_EDITS
    hint = "Choose an edit below, then click the stitch or the edge."


class ChangeRows(PlaceTool):
    """Edits of rows and wales."""

    name, key, what, edits = "Rows and wales", "R", "rows", ROW_EDITS
    hint = "Choose an edit below, then click the stitch or the edge."
