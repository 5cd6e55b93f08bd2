# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A tool with a brush: what the tools share that paint and select."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.pages.edit.brush import BRUSHES, covered_faces
from stitchmesh.app.pages.edit.edit_session import EditSession
from stitchmesh.app.pages.edit.tool import Tool
from stitchmesh.app.scene.pointer import DragPath
from stitchmesh.app.scene.scene import Pick, Stroke
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray
from stitchmesh.mesh.picking import PickedPlace


class BrushTool(Tool):
    """A tool that does something with the faces under a brush, by a click or at the end of a drag."""

    brush_label: ClassVar[str]
    """Label of the choice of the brush."""

    def __init__(self, session: EditSession) -> None:
        """Start with no drag."""
        super().__init__(session)
        self._drag = DragPath()

    @abstractmethod
    def take(self, path: list[int], pick: Pick) -> None:
        """Do it with what the brush covers along faces, after a click or at the end of a stroke."""

    @abstractmethod
    def preview(self, path: list[int]) -> None:
        """Show what a drag covers so far."""

    def build(self, controls: Controls) -> None:
        """Make the choice of the brush."""
        hint = "What one click covers; drag for more, or from corner to corner of a rectangle"
        self._brush = controls.choice(self.brush_label, hint, BRUSHES, self.session.state.brush, self._set_brush)

    def taken_up(self) -> None:
        """Show the brush that the tools share."""
        self._brush.value = self.session.state.brush

    def refresh(self) -> None:
        """Forget a drag over a fabric that has changed."""
        self._drag.clear()

    def clicked(self, place: PickedPlace, pick: Pick) -> None:
        """Take what the brush covers."""
        if self.session.state.brush == "Rectangle":
            raise ParameterError("rectangle: got one click; drag from one corner of the rectangle to the opposite one")
        self.take([place.face], pick)

    def stroked(self, stroke: Stroke) -> None:
        """Show what a drag has covered so far, and take it at the end."""
        path = [place.face for place in self._drag.follow(stroke, self.session.pointer)]
        if not path:
            return
        if stroke.phase == "end":
            self._drag.clear()
            self.take(path, stroke)
        else:
            self.preview(path)

    def covered(self, path: list[int]) -> IntArray:
        """Return the faces that the brush covers along faces.

        Raises:
            ParameterError: no rectangle has the first and the last face as its corners.
        """
        return covered_faces(self.session.fabric, self.session.state.brush, path)

    def _set_brush(self, brush: str) -> None:
        self.session.take(brush=next(known for known in BRUSHES if known == brush))
