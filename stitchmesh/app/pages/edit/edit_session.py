# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The state that the tools of the page Edit share: fabric, selection, chosen stitch and yarn, and the edits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from stitchmesh.app.pages.chart_panel import OwnPatterns
from stitchmesh.app.pages.edit.fabric_view import FabricView
from stitchmesh.app.pages.edit.selection_panel import SavedSelections, faces_after
from stitchmesh.app.pages.typed import selected_by_words
from stitchmesh.app.scene.fabric_blocks import ColourBy
from stitchmesh.app.scene.pointer import Pointer
from stitchmesh.editing.edit import Edit
from stitchmesh.editing.on_selection import places_after
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.mesh.own_stitch import OwnStitch, StitchType
from stitchmesh.mesh.renumbering import REMOVED
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.selection.selection import selection_of_faces

if TYPE_CHECKING:
    from stitchmesh.app.application import App

NO_FACES = np.zeros(0, dtype=np.int64)
Brush = Literal["Stitch", "Row", "Wale", "Rectangle"]
"""The faces that one click paints or selects."""
BRUSHES: tuple[Brush, ...] = get_args(Brush)


@dataclass(frozen=True, eq=False)
class Chosen:
    """The selected faces."""

    faces: IntArray
    """Numbers of the faces, ascending, shape (n,)."""
    text: str = ""
    """Text of the selection language for exactly these faces; empty if the user chose the faces one by one."""

    @property
    def as_text(self) -> str:
        """A text that names the faces; empty if there are none."""
        return self.text or (str(selection_of_faces(self.faces)) if len(self.faces) else "")


NOTHING = Chosen(NO_FACES)


@dataclass(frozen=True, eq=False)
class EditState:
    """The user's choices on the page, for all tools."""

    selection: Chosen = NOTHING
    """The selected faces."""
    stitch: Stitch = Stitch.PURL
    """The stitch that is painted."""
    yarn: int = 1
    """Number of the yarn that is painted."""
    brush: Brush = "Stitch"
    """The faces that one click paints or selects."""


class EditSession:
    """The fabric of the page and its state; all tools use it."""

    def __init__(self, app: App) -> None:
        """Begin without a selection."""
        self.app, self.view = app, FabricView(app.scene)
        self.state = EditState()
        self.saved = SavedSelections(app)
        self.patterns = OwnPatterns(app)
        self.on_colours: Callable[[ColourBy], object] = lambda by: None
        """Called when a tool shows the fabric in other colours."""
        self._seen: StitchMesh | None = None
        self._pointer: Pointer | None = None

    @property
    def fabric(self) -> StitchMesh:
        """The fabric of the project, which exists while the page is open."""
        fabric = self.app.project.fabric
        assert fabric is not None
        return fabric

    @property
    def pointer(self) -> Pointer:
        """The object that finds places of the present fabric under the pointer."""
        if self._pointer is None or self._pointer.mesh is not self.fabric:
            self._pointer = Pointer(self.fabric)
        return self._pointer

    def edit(self, name: str, arguments: Mapping[str, object], at: IntArray = NO_FACES) -> bool:
        """Make an edit, and show the result; a refusal and its reason appear at the place of the edit.

        Args:
            name: name of the edit.
            arguments: its arguments.
            at: faces at which the edit is made or refused.

        Returns:
            Whether the edit was made.
        """
        try:
            dropped = self.app.project.apply_edit(Edit(name, arguments))
        except StitchMeshError as error:
            self.refuse(at, str(error))
            return False
        self.after_change(dropped)
        return True

    def refuse(self, at: IntArray, message: str) -> None:
        """Show the reason of a refusal at its place."""
        self.view.show(self.fabric)
        self.view.unmark()
        self.view.refuse(self.fabric, at[at < self.fabric.face_count], message)
        self.app.notice(message, "error")

    def after_change(self, dropped: tuple[str, ...]) -> None:
        """Show the project after an edit, undo or redo, and name the results that it dropped."""
        self.view.unmark()
        self.app.refresh()
        if dropped:
            self.app.notice(f"The edit made older results invalid: {', '.join(dropped)}. Make them again when you are "
                            "ready.", "warning")  # fmt: skip

    def show_fabric(self) -> None:
        """Draw the fabric of the project, and adapt the selection to the changes."""
        fabric = self.fabric
        if self._seen is not None and self._seen is not fabric:
            self._follow(self._seen)
        self._seen = fabric
        self.view.show(fabric)
        self.view.select(fabric, self.state.selection.faces)

    def take(self, **values: Any) -> None:
        """Take other values of the state."""
        self.state = replace(self.state, **values)

    def choose(self, faces: IntArray, text: str = "") -> None:
        """Select faces."""
        self.take(selection=Chosen(np.unique(faces), text))
        self.view.select(self.fabric, self.state.selection.faces)

    def choose_by_text(self, text: str) -> None:
        """Select the faces that a text names.

        Raises:
            ParameterError: an error of ``select``, or the text names a file.
        """
        self.choose(selected_by_words(self.fabric, text), text)

    def on_selection(self) -> dict[str, object]:
        """Return the argument that names the selection for an edit.

        Raises:
            ParameterError: nothing is selected.
        """
        if not len(self.state.selection.faces):
            raise ParameterError("selection: nothing is selected; select stitches first, or use the tool on the fabric")
        return {"on": self.state.selection.as_text}

    def colour_by(self, by: ColourBy) -> None:
        """Show the fabric in other colours."""
        if by != self.view.colour_by:
            self.view.colour_by = by
            self.on_colours(by)
            self.view.show(self.fabric)

    def _follow(self, before: StitchMesh) -> None:
        """Let all selections follow the last change; faces that are gone leave them."""
        numbers = places_after(np.arange(before.face_count), before.face_count, self.app.project.last_changes)
        if not _leads_to(before, self.fabric, numbers):
            self.take(selection=NOTHING)
            return
        self.saved.follow(before, numbers)
        faces = self.state.selection.faces
        after = faces_after(faces, numbers)
        if not np.array_equal(after, faces):
            self.take(selection=Chosen(after))


def name_of(stitch: StitchType) -> str:
    """Return the name that edits use for a stitch: its code, ``cast-on`` or ``draw-through``."""
    if isinstance(stitch, OwnStitch):
        return stitch.code
    return VOCABULARY[stitch].code if stitch in VOCABULARY else stitch_name(stitch)


def _leads_to(before: StitchMesh, after: StitchMesh, numbers: IntArray) -> bool:
    """Return whether the shared faces of two fabrics have the same sizes; if not, the fabric is another one."""
    kept = np.flatnonzero(numbers != REMOVED)
    if numbers.max(initial=REMOVED) >= after.face_count:
        return False
    sizes = np.diff(after.face_start)[numbers[kept]]
    return bool(np.array_equal(sizes, np.diff(before.face_start)[kept]))
