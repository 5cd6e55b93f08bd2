# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tools that paint: stitches and yarns of stitches, rows, wales and rectangles."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.pages.edit.brush import BRUSHES, covered_faces
from stitchmesh.app.pages.edit.edit_session import NO_FACES, EditSession
from stitchmesh.app.pages.edit.pointer import without_repeats
from stitchmesh.app.pages.edit.stitch_palette import name_of
from stitchmesh.app.pages.edit.tool import Tool
from stitchmesh.app.scene.scene import Pick, Stroke
from stitchmesh.editing.stitch_marks import faces_for_stitch
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.mesh import IntArray
from stitchmesh.mesh.change import Marks, apply_change
from stitchmesh.mesh.picking import PickedPlace

BRUSH_LABELS = {"stitch": "Brush", "yarn": "Yarn brush"}
"""Label of the choice of the brush, by what is painted."""


class Painting(Tool):
    """A tool that gives all faces under a brush the same number. A drag is painted at once and is one edit."""

    kind: ClassVar[str]
    """What is painted, for labels: ``stitch`` or ``yarn``."""

    def __init__(self, session: EditSession) -> None:
        """Start with nothing painted."""
        super().__init__(session)
        self._path: list[int] = []

    @abstractmethod
    def number(self) -> int:
        """Return the number that faces are given."""

    @abstractmethod
    def can_take(self, faces: IntArray) -> IntArray:
        """Return the faces that can take the number."""

    @abstractmethod
    def paint(self, arguments: dict[str, object], at: IntArray) -> bool:
        """Make the edit on faces, which the arguments name; say whether it was made."""

    def build(self, controls: Controls) -> None:
        """Make the choice of the brush, and the button that fills the selection."""
        hint = "What one click covers; drag for more, or from corner to corner of a rectangle"
        self._brush = controls.choice(BRUSH_LABELS[self.kind], hint, BRUSHES, self.session.brush, self._set_brush)
        fill = f"Fill the selection with the {self.kind}"
        controls.button(fill, f"Give all selected stitches the chosen {self.kind}", self.fill_selection)

    def taken_up(self) -> None:
        """Show the brush that the tools share."""
        self._brush.value = self.session.brush

    def fill_selection(self) -> None:
        """Paint the selected faces."""
        self.paint(self.session.on_selection(), self.session.selection.faces)

    def refresh(self) -> None:
        """Forget a drag over a fabric that has changed."""
        self._path = []

    def clicked(self, place: PickedPlace, pick: Pick) -> None:
        """Paint what the brush covers."""
        if self.session.brush == "Rectangle":
            raise ParameterError("rectangle: got one click; drag from one corner of the rectangle to the opposite one")
        self._paint_path([place.face])

    def stroked(self, stroke: Stroke) -> None:
        """Show what a drag has covered so far, and paint it at the end."""
        pointer = self.session.pointer
        if stroke.phase == "start":
            pointer.begin()
            self._path = []
        self._path = without_repeats([*self._path, *(place.face for place in pointer.places_along(stroke))])
        if not self._path:
            return
        if stroke.phase == "end":
            path, self._path = self._path, []
            self._paint_path(path)
        else:
            self._preview()

    def boxed(self, faces: IntArray) -> None:
        """Paint the faces in a rectangle on the screen."""
        self._paint_faces(faces)

    def _set_brush(self, brush: str) -> None:
        self.session.brush = next(known for known in BRUSHES if known == brush)

    def _paint_path(self, path: list[int]) -> None:
        try:
            faces = covered_faces(self.session.fabric, self.session.brush, path)
        except StitchMeshError as error:
            self.session.refuse(np.unique(path), str(error))
            return
        self._paint_faces(faces)

    def _paint_faces(self, faces: IntArray) -> None:
        """Paint the faces that can take the number; if there is none, the edit is tried on all, and refused."""
        fitting = self.can_take(faces)
        wanted = fitting if len(fitting) else faces
        if len(wanted) and self.paint({"faces": wanted.tolist()}, wanted) and len(fitting) < len(faces):
            left = len(faces) - len(fitting)
            self.session.app.notice(
                f"{len(fitting)} stitches changed; {left} kept their stitch, because they have other loops", "info"
            )

    def _preview(self) -> None:
        """Show the painted faces before the edit is made."""
        fabric = self.session.fabric
        try:
            faces = self.can_take(covered_faces(fabric, self.session.brush, self._path))
        except StitchMeshError:
            faces = NO_FACES  # A rectangle that does not exist yet; the end of the drag says so.
        marks = Marks(self.kind, faces, np.full(len(faces), self.number()))
        self.session.view.show(apply_change(fabric, marks) if len(faces) else fabric)


class PaintStitches(Painting):
    """Paints the chosen stitch."""

    name, key, kind = "Paint stitches", "P", "stitch"
    hint = "Choose a stitch on the left, then click or drag on the fabric; shift+drag paints a rectangle of the screen."

    def number(self) -> int:
        """Return the code of the chosen stitch."""
        return int(self.session.stitch)

    def can_take(self, faces: IntArray) -> IntArray:
        """Return the faces with the loops that the stitch needs."""
        return faces_for_stitch(self.session.fabric, faces, name_of(self.session.stitch))

    def paint(self, arguments: dict[str, object], at: IntArray) -> bool:
        """Make the edit."""
        return self.session.edit("change_stitch", {**arguments, "stitch": name_of(self.session.stitch)}, at)


class PaintYarns(Painting):
    """Paints the chosen yarn."""

    name, key, kind = "Paint yarns", "Y", "yarn"
    hint = "Choose a yarn on the left, then click or drag on the fabric; shift+drag paints a rectangle of the screen."

    def taken_up(self) -> None:
        """Show the colours of the yarns."""
        super().taken_up()
        self.session.colour_by("yarn")

    def number(self) -> int:
        """Return the number of the chosen yarn."""
        return self.session.yarn

    def can_take(self, faces: IntArray) -> IntArray:
        """Return all faces: every stitch can be knitted with every yarn."""
        return faces

    def paint(self, arguments: dict[str, object], at: IntArray) -> bool:
        """Make the edit."""
        return self.session.edit("stripe", {**arguments, "yarn": self.session.yarn}, at)
