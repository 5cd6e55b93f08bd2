# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A drag that takes a point of a mark along the surface."""

from __future__ import annotations

from collections.abc import Callable

from stitchmesh.app.pages.rows.mark_edits import Marks, with_point
from stitchmesh.app.pages.rows.rows_state import RowsState
from stitchmesh.app.pages.rows.rows_view import RowsView
from stitchmesh.app.project.shaping import Point
from stitchmesh.app.scene.pointer import Pointer
from stitchmesh.app.scene.scene import Stroke
from stitchmesh.mesh import FloatArray


class HandleDrag:
    """Shows the point where it is dragged, and moves it at the end of the drag."""

    def __init__(self, view: RowsView, pointer: Pointer, take: Callable[[RowsState], object]) -> None:
        """Drag nothing yet; ``take`` is called with the state after each drag."""
        self._view, self._pointer, self._take = view, pointer, take
        self._held: tuple[int, int] | None = None
        self._client = -1
        self._moved: Marks | None = None

    def stroked(self, stroke: Stroke, state: RowsState) -> None:
        """Handle one moment of a drag; only the browser that began the drag moves the point."""
        place = self._pointer.place(stroke)
        if stroke.phase == "start":
            self._held = self._view.handles.under(stroke, None if place is None else place.depth)
            self._client, self._moved = stroke.client, None
            return
        if self._held is None or stroke.client != self._client:
            return
        number, point = self._held
        if place is not None and number < len(state.marks):
            self._moved = with_point(state.marks, number, point, as_point(place.point))
            self._view.show_marks(self._moved, self._held, state.line)
        if stroke.phase == "end":
            moved, self._held, self._moved = self._moved, None, None
            if moved is not None:
                self._take(state.choosing(number, point).with_marks(moved, number))


def as_point(position: FloatArray) -> Point:
    """Return a position as numbers that a project keeps, to the hundredth of a millimetre [cm]."""
    x, y, z = (round(float(number), 3) for number in position)
    return x, y, z
