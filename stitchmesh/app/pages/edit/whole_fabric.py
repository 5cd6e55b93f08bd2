# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tools without a drag: edits of the whole fabric, and looking around."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.html_pieces import paragraph
from stitchmesh.app.pages.edit.edit_session import EditSession
from stitchmesh.app.pages.edit.tool import Tool, nearest_side
from stitchmesh.app.scene.scene import Pick
from stitchmesh.errors import StitchMeshError
from stitchmesh.markup import Markup, markup
from stitchmesh.mesh.picking import PickedPlace


class ChangeFabric(Tool):
    """Turns rings into a spiral and back, and grafts two borders that the user clicks one after another."""

    name, key = "Whole fabric", "W"
    hint = "Press a button; to graft, click the two borders that are joined, one after the other."
    takes_strokes = False

    def __init__(self, session: EditSession) -> None:
        """Begin without a clicked border."""
        super().__init__(session)
        self._first: int | None = None

    def build(self, controls: Controls) -> None:
        """Make the controls."""
        controls.button("Rings to spiral", "Turn stacked rings into one row that climbs around the tube", self.spiral)
        controls.button("Spiral to rings", "Turn each spiral back into rings", self.unspiral)
        self._words = controls.html(Markup())
        self._say()

    def taken_up(self) -> None:
        """Begin without a clicked border."""
        self.refresh()

    def refresh(self) -> None:
        """Forget a clicked border if the fabric has changed."""
        self._first = None
        self._say()

    def spiral(self) -> None:
        """Make the edit."""
        self.session.edit("spiral", {})

    def unspiral(self) -> None:
        """Make the edit."""
        self.session.edit("unspiral", {})

    def clicked(self, place: PickedPlace, pick: Pick) -> None:
        """Keep the first border, and graft the second one to it."""
        fabric, at = self.session.fabric, np.array([place.face])
        try:
            side = nearest_side(fabric, place, "border side")
        except StitchMeshError as error:
            self.session.refuse(at, str(error))
            return
        if self._first is None:
            self._first = side
            self.session.view.mark_sides(fabric, np.array([side]))
            self._say()
            return
        first, self._first = self._first, None
        self._say()
        self.session.edit("graft", {"first_side": first, "second_side": side}, at)

    def _say(self) -> None:
        step = "first border" if self._first is None else "second border"
        self._words.content = paragraph(markup("Graft: click a stitch at the <b>{}</b>.", step))


class LookAround(Tool):
    """Changes nothing: a drag turns the view, and a click describes a stitch."""

    name, key = "Look around", "V"
    hint = "Drag to turn the fabric, scroll to come closer; a click says what a stitch is."
    takes_strokes = False
