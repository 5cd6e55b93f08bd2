# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tool that selects stitches, rows, wales and rectangles."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.pages.edit.brush import BRUSHES, covered_faces
from stitchmesh.app.pages.edit.edit_session import NO_FACES, EditSession
from stitchmesh.app.pages.edit.pointer import without_repeats
from stitchmesh.app.pages.edit.tool import Tool
from stitchmesh.app.scene.scene import Pick, Stroke
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.mesh import IntArray
from stitchmesh.mesh.picking import PickedPlace


class SelectStitches(Tool):
    """Selects what the brush covers; with the control key held, adds to the selection or takes away from it."""

    name, key = "Select", "S"
    hint = "Click or drag to select; hold ctrl to add or take away; shift+drag selects a rectangle of the screen."

    def __init__(self, session: EditSession) -> None:
        """Start with no drag."""
        super().__init__(session)
        self._path: list[int] = []

    def build(self, controls: Controls) -> None:
        """Make the choice of the brush."""
        hint = "What one click covers; drag for more, or from corner to corner of a rectangle"
        self._brush = controls.choice("Selects", hint, BRUSHES, self.session.brush, self._set_brush)

    def taken_up(self) -> None:
        """Show the brush that the tools share."""
        self._brush.value = self.session.brush

    def refresh(self) -> None:
        """Forget a drag over a fabric that has changed."""
        self._path = []

    def clicked(self, place: PickedPlace, pick: Pick) -> None:
        """Select what the brush covers."""
        if self.session.brush == "Rectangle":
            raise ParameterError("rectangle: got one click; drag from one corner of the rectangle to the opposite one")
        faces = covered_faces(self.session.fabric, self.session.brush, [place.face])
        if pick.modifier == "ctrl":
            self._toggle(faces)
        else:
            self.session.choose(faces)

    def stroked(self, stroke: Stroke) -> None:
        """Mark what a drag covers, and select it at the end."""
        pointer = self.session.pointer
        if stroke.phase == "start":
            pointer.begin()
            self._path = []
        self._path = without_repeats([*self._path, *(place.face for place in pointer.places_along(stroke))])
        if not self._path:
            return
        faces = self._covered(final=stroke.phase == "end")
        self.session.view.mark_faces(self.session.fabric, faces)
        if stroke.phase == "end":
            self.session.view.unmark()
            keep = self.session.selection.faces if stroke.modifier == "ctrl" else NO_FACES
            if len(faces):
                self.session.choose(np.union1d(keep, faces))

    def _covered(self, *, final: bool) -> IntArray:
        try:
            return covered_faces(self.session.fabric, self.session.brush, self._path)
        except StitchMeshError:
            if final:
                raise
            return NO_FACES

    def _toggle(self, faces: IntArray) -> None:
        """Add faces to the selection; take them away if all of them are selected."""
        selected = self.session.selection.faces
        inside = np.isin(faces, selected).all()
        self.session.choose(np.setdiff1d(selected, faces) if inside else np.union1d(selected, faces))

    def _set_brush(self, brush: str) -> None:
        self.session.brush = next(known for known in BRUSHES if known == brush)
