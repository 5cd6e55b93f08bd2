# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tools with a brush: they paint or select the stitches and yarns that a click or a drag covers."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.pages.edit.edit_session import BRUSHES, NO_FACES, Brush, EditSession, name_of
from stitchmesh.app.pages.edit.tool import Tool
from stitchmesh.app.scene.pointer import DragPath
from stitchmesh.app.scene.scene import Pick, Stroke
from stitchmesh.editing.marks import faces_for_stitch
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.mesh.change import Marks, apply_change
from stitchmesh.mesh.picking import PickedPlace
from stitchmesh.selection import select
from stitchmesh.selection.selection import RectangleBetween, Ring, Wale


def covered_faces(fabric: StitchMesh, brush: Brush, path: Sequence[int]) -> IntArray:
    """Return the faces that a brush covers, ascending.

    Args:
        fabric: the fabric.
        brush: ``Stitch``, or ``Row`` or ``Wale`` through each stitch, or ``Rectangle`` from the first stitch to the
            last one.
        path: faces under the pointer, at least one.

    Raises:
        ParameterError: no rectangle has the first and the last face as its corners.
    """
    if brush == "Rectangle":
        return select(fabric, RectangleBetween(path[0], path[-1]))
    if brush == "Stitch":
        return np.unique(np.asarray(path, dtype=np.int64))
    faces: set[int] = set()
    for face in path:
        if face not in faces:
            faces.update(select(fabric, Ring(face) if brush == "Row" else Wale(face)).tolist())
    return np.array(sorted(faces), dtype=np.int64)


class BrushTool(Tool):
    """A tool that acts on the faces under a brush, by a click or at the end of a drag."""

    brush_label: ClassVar[str]
    """Label of the choice of the brush."""

    def __init__(self, session: EditSession) -> None:
        """Begin without a drag."""
        super().__init__(session)
        self._drag = DragPath()

    @abstractmethod
    def take(self, path: list[int], pick: Pick) -> None:
        """Act on the faces that the brush covers along a path, after a click or at the end of a stroke."""

    @abstractmethod
    def preview(self, path: list[int]) -> None:
        """Show the faces that a drag covers so far."""

    def build(self, controls: Controls) -> None:
        """Make the choice of the brush."""
        hint = "What one click covers; drag for more, or from corner to corner of a rectangle"
        self._brush = controls.choice(self.brush_label, hint, BRUSHES, self.session.state.brush, self._set_brush)

    def taken_up(self) -> None:
        """Show the brush that the tools share."""
        self._brush.value = self.session.state.brush

    def refresh(self) -> None:
        """Forget a drag if the fabric has changed."""
        self._drag.clear()

    def clicked(self, place: PickedPlace, pick: Pick) -> None:
        """Take the faces that the brush covers."""
        if self.session.state.brush == "Rectangle":
            raise ParameterError("rectangle: got one click; drag from one corner of the rectangle to the opposite one")
        self.take([place.face], pick)

    def stroked(self, stroke: Stroke) -> None:
        """Show the faces that a drag has covered so far, and take them at the end."""
        path = [place.face for place in self._drag.follow(stroke, self.session.pointer)]
        if not path:
            return
        if stroke.phase == "end":
            self._drag.clear()
            self.take(path, stroke)
        else:
            self.preview(path)

    def covered(self, path: list[int]) -> IntArray:
        """Return the faces that the brush covers along a path.

        Raises:
            ParameterError: no rectangle has the first and the last face as its corners.
        """
        return covered_faces(self.session.fabric, self.session.state.brush, path)

    def covered_so_far(self, path: list[int]) -> IntArray:
        """Return the faces that the brush covers along an unfinished path; none while they form no rectangle."""
        try:
            return self.covered(path)
        except StitchMeshError:
            return NO_FACES

    def _set_brush(self, brush: str) -> None:
        self.session.take(brush=next(known for known in BRUSHES if known == brush))


class Painting(BrushTool):
    """A tool that gives the same number to all faces under a brush. A drag paints at once and is one edit."""

    kind: ClassVar[str]
    """The name of what it paints, for labels: ``stitch`` or ``yarn``."""

    @abstractmethod
    def number(self) -> int:
        """Return the number that the tool gives to faces."""

    @abstractmethod
    def can_take(self, faces: IntArray) -> IntArray:
        """Return the faces that can take the number."""

    @abstractmethod
    def paint(self, arguments: dict[str, object], at: IntArray) -> bool:
        """Make the edit on the faces that the arguments name; return whether it was made."""

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
        """Paint the faces that the brush covers; a refusal marks the faces of the path."""
        try:
            faces = self.covered(path)
        except StitchMeshError as error:
            self.session.refuse(np.unique(path), str(error))
            return
        self._paint_faces(faces)

    def _paint_faces(self, faces: IntArray) -> None:
        """Paint the faces that can take the number; if none can, try the edit on all faces, so that it is refused."""
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
        faces = self.can_take(self.covered_so_far(path))
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
        """Return the faces that have the loops of the stitch."""
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
        """Knit the selected stitches, or all stitches, in stripes."""
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


class SelectStitches(BrushTool):
    """Selects the faces under the brush; with the control key, adds them to the selection or removes them from it."""

    name, key, brush_label = "Select", "S", "Selects"
    hint = "Click or drag to select; hold ctrl to add or take away; shift+drag selects a rectangle of the screen."

    def take(self, path: list[int], pick: Pick) -> None:
        """Select the faces under the brush; with the control key, a click toggles them, and a drag adds them."""
        self.session.view.unmark()
        faces = self.covered(path)
        if pick.modifier != "ctrl":
            self.session.choose(faces)
        elif isinstance(pick, Stroke):
            self.session.choose(np.union1d(self.session.state.selection.faces, faces))
        else:
            self._toggle(faces)

    def preview(self, path: list[int]) -> None:
        """Mark the faces that a drag covers."""
        self.session.view.mark_faces(self.session.fabric, self.covered_so_far(path))

    def _toggle(self, faces: IntArray) -> None:
        """Add faces to the selection; if all of them are selected, remove them from it."""
        selected = self.session.state.selection.faces
        inside = np.isin(faces, selected).all()
        self.session.choose(np.setdiff1d(selected, faces) if inside else np.union1d(selected, faces))
