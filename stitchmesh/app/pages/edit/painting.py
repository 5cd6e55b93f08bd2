# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tools that paint: stitches and yarns of stitches, rows, wales and rectangles."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.pages.edit.brush_tool import BrushTool
from stitchmesh.app.pages.edit.edit_session import NO_FACES
from stitchmesh.app.pages.edit.stitch_palette import name_of
from stitchmesh.app.scene.scene import Pick
from stitchmesh.editing.stitch_marks import faces_for_stitch
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import IntArray
from stitchmesh.mesh.change import Marks, apply_change


class Painting(BrushTool):
    """A tool that gives all faces under a brush the same number. A drag is painted at once and is one edit."""

    kind: ClassVar[str]
    """What is painted, for labels: ``stitch`` or ``yarn``."""

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
        super().build(controls)
        fill = f"Fill the selection with the {self.kind}"
        controls.button(fill, f"Give all selected stitches the chosen {self.kind}", self.fill_selection)

    def fill_selection(self) -> None:
        """Paint the selected faces."""
        self.paint(self.session.on_selection(), self.session.state.selection.faces)

    def boxed(self, faces: IntArray) -> None:
        """Paint the faces in a rectangle on the screen."""
        self._paint_faces(faces)

    def take(self, path: list[int], pick: Pick) -> None:
        """Paint what the brush covers; a refusal marks the faces of the path."""
        try:
            faces = self.covered(path)
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

    def preview(self, path: list[int]) -> None:
        """Show the painted faces before the edit is made."""
        fabric = self.session.fabric
        try:
            faces = self.can_take(self.covered(path))
        except StitchMeshError:
            faces = NO_FACES  # A rectangle that does not exist yet; the end of the drag says so.
        marks = Marks(self.kind, faces, np.full(len(faces), self.number()))
        self.session.view.show(apply_change(fabric, marks) if len(faces) else fabric)


class PaintStitches(Painting):
    """Paints the chosen stitch."""

    name, key, kind, brush_label = "Paint stitches", "P", "stitch", "Brush"
    hint = "Choose a stitch on the left, then click or drag on the fabric; shift+drag paints a rectangle of the screen."

    def number(self) -> int:
        """Return the code of the chosen stitch."""
        return int(self.session.state.stitch)

    def can_take(self, faces: IntArray) -> IntArray:
        """Return the faces with the loops that the stitch needs."""
        return faces_for_stitch(self.session.fabric, faces, name_of(self.session.state.stitch))

    def paint(self, arguments: dict[str, object], at: IntArray) -> bool:
        """Make the edit."""
        return self.session.edit("change_stitch", {**arguments, "stitch": name_of(self.session.state.stitch)}, at)


class PaintYarns(Painting):
    """Paints the chosen yarn."""

    name, key, kind, brush_label = "Paint yarns", "Y", "yarn", "Yarn brush"
    hint = "Choose a yarn on the left, then click or drag on the fabric; shift+drag paints a rectangle of the screen."

    def build(self, controls: Controls) -> None:
        """Make the choice of the brush, the button that fills the selection, and the stripes."""
        super().build(controls)
        self._bands = controls.text("Stripes", "Rows and colour of each stripe from the bottom up; they repeat",
                                    "4 cream, 2 navy", lambda bands: None)  # fmt: skip
        controls.button("Knit stripes", "Knit the selection in these stripes, or the whole fabric without a selection",
                        self.knit_stripes)  # fmt: skip

    def knit_stripes(self) -> None:
        """Knit the selected stitches, or all, in stripes."""
        faces = self.session.state.selection.faces
        where = self.session.on_selection() if len(faces) else {}
        self.session.edit("stripes", {"bands": str(self._bands.value), **where}, faces)

    def taken_up(self) -> None:
        """Show the colours of the yarns."""
        super().taken_up()
        self.session.colour_by("yarn")

    def number(self) -> int:
        """Return the number of the chosen yarn."""
        return self.session.state.yarn

    def can_take(self, faces: IntArray) -> IntArray:
        """Return all faces: every stitch can be knitted with every yarn."""
        return faces

    def paint(self, arguments: dict[str, object], at: IntArray) -> bool:
        """Make the edit."""
        return self.session.edit("stripe", {**arguments, "yarn": self.session.state.yarn}, at)
