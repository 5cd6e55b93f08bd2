# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A tool of the page Edit: what a click, a drag and a rectangle on the fabric do."""

from __future__ import annotations

from typing import ClassVar

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.pages.edit.edit_session import EditSession
from stitchmesh.app.scene.scene import Pick, Stroke
from stitchmesh.mesh import IntArray
from stitchmesh.mesh.picking import PickedPlace


class Tool:
    """A tool. A rectangle on the screen selects stitches, unless a tool does something else with it."""

    name: ClassVar[str]
    """Name of the tool."""
    hint: ClassVar[str]
    """One line that says what to do with the mouse."""
    key: ClassVar[str]
    """Key that takes up the tool."""
    takes_strokes: ClassVar[bool] = True
    """Whether a drag on the fabric belongs to the tool; otherwise it turns the view."""

    def __init__(self, session: EditSession) -> None:
        """Keep what the tools share."""
        self.session = session

    def build(self, controls: Controls) -> None:
        """Make the controls of the tool."""

    def taken_up(self) -> None:
        """Begin, after the user has chosen the tool or the page was opened with it."""

    def laid_down(self) -> None:
        """End, before another tool is taken up or the page is left."""

    def refresh(self) -> None:
        """Show the fabric after it changed."""

    def clicked(self, place: PickedPlace, pick: Pick) -> None:
        """Handle a click on the fabric."""

    def stroked(self, stroke: Stroke) -> None:
        """Handle a moment of a drag on the fabric."""

    def boxed(self, faces: IntArray) -> None:
        """Handle the faces in a rectangle on the screen."""
        self.session.choose(faces)
