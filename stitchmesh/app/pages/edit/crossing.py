# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tool that crosses cables, by a drag along a row over the loops that shall cross."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.field_panel import Field, FieldPanel, Number
from stitchmesh.app.pages.edit.edit_session import EditSession
from stitchmesh.app.pages.edit.tool import Tool
from stitchmesh.app.scene.scene import Pick, Stroke
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.mesh.courses import course_through, top_sides
from stitchmesh.mesh.picking import PickedPlace


@dataclass(frozen=True)
class CableChoice:
    """The cable that the user wants."""

    front: str = "left"
    """Which loops lie in front: ``left`` or ``right``."""
    left: int = 2
    """Number of loops that a click moves from the left to the right."""
    right: int = 2
    """Number of loops that a click moves from the right to the left."""
    order: tuple[int, ...] = ()
    """New place of each loop, from 1 at the left; empty if two groups cross."""

    @property
    def count(self) -> int:
        """Number of loops that cross at a click."""
        return len(self.order) or self.left + self.right


FIELDS = (
    Field("front", "In front", "Which loops lie in front where they cross",
          {"the left loops": "left", "the right loops": "right"}),
    Field("left", "From the left", "Loops that a click moves from the left to the right", Number(1, 12, 1)),
    Field("right", "From the right", "Loops that a click moves from the right to the left", Number(1, 12, 1)),
)  # fmt: skip
"""The choices of a cable beside its order."""


class CrossCables(Tool):
    """Crosses the loops under a drag at its middle, or a given number of loops from a click to the right."""

    name, key = "Cross a cable", "C"
    hint = "Drag along a row over the loops that cross, or click the leftmost loop of the cable."

    def __init__(self, session: EditSession) -> None:
        """Start with two loops over two."""
        super().__init__(session)
        self.cable = CableChoice()
        self._first: int | None = None
        self._last = 0

    def build(self, controls: Controls) -> None:
        """Make the controls."""
        FieldPanel(controls, FIELDS, lambda: self.cable, self._take)
        controls.text("Order", "Place of each loop from the left, such as 3 1 2; empty: two groups cross",
                      " ".join(map(str, self.cable.order)), self._set_order)  # fmt: skip
        controls.button("Cross cables along the selection", "Cross loops side by side along each row of the selection",
                        self.on_selection)  # fmt: skip
        controls.button("Clear the cables of the selection", "Loops of cables within the selection go straight up",
                        self.clear_selection)  # fmt: skip

    def refresh(self) -> None:
        """Forget a drag if the fabric has changed."""
        self._first = None

    def clicked(self, place: PickedPlace, pick: Pick) -> None:
        """Cross loops from the clicked one to the right; with the control key, clear the clicked cable."""
        side = self.side_at(place, "top side")
        if side is None:
            return
        if pick.modifier == "ctrl":
            self.session.edit("clear_cable", {"side": side}, np.array([place.face]))
        else:
            self._cross(side, self.cable.count)

    def stroked(self, stroke: Stroke) -> None:
        """Mark the loops under a drag, and cross them at the end."""
        pointer = self.session.pointer
        if stroke.phase == "start":
            pointer.begin()
            self._first = None
        for place in pointer.places_along(stroke):
            self._first = place.face if self._first is None else self._first
            self._last = place.face
        if self._first is None:
            return
        fabric = self.session.fabric
        sides = loops_between(fabric, self._first, self._last)
        if stroke.phase != "end":
            self.session.view.mark_sides(fabric, sides)
            return
        self.session.view.unmark()
        if len(sides) < 2:
            reason = "cable: the drag covers no two loops of one row; drag along a row"
            self.session.refuse(np.unique([self._first, self._last]), reason)
            return
        self._cross(int(sides[0]), len(sides))

    def on_selection(self) -> None:
        """Cross cables side by side along each row of the selection."""
        name, arguments = self._edit_of(self.cable.count)
        self.session.edit(name, {**self.session.on_selection(), **arguments}, self.session.state.selection.faces)

    def clear_selection(self) -> None:
        """Clear the cables that lie within the selection."""
        self.session.edit("clear_cable", self.session.on_selection(), self.session.state.selection.faces)

    def _cross(self, side: int, count: int) -> None:
        name, arguments = self._edit_of(count)
        self.session.edit(name, {"side": side, **arguments}, self.session.fabric.side_face[np.array([side])])

    def _edit_of(self, count: int) -> tuple[str, dict[str, object]]:
        """Return the name and the arguments of the edit that crosses a number of loops.

        Raises:
            ParameterError: the order has another number of loops.
        """
        cable = self.cable
        if not cable.order:
            left = cable.left if count == cable.left + cable.right else count // 2
            return "cross_cable", {"left": left, "right": count - left, "front": cable.front}
        if len(cable.order) != count:
            found = f"an order of {len(cable.order)} loops for {count} loops"
            raise ParameterError(f"cable: got {found}; drag over as many loops, or empty the order")
        layers = range(count, 0, -1) if cable.front == "left" else range(1, count + 1)
        return "set_cable", {"destinations": [place - 1 for place in cable.order], "layers": list(layers)}

    def _take(self, cable: CableChoice, name: str) -> None:
        self.cable = cable

    def _set_order(self, text: str) -> None:
        """Take an order if it is complete; a half-typed order is not."""
        words = text.replace(",", " ").split()
        places = tuple(int(word) for word in words if word.isdecimal())
        whole = len(places) == len(words) and sorted(places) == list(range(1, len(places) + 1))
        self.cable = replace(self.cable, order=places if whole and len(places) > 1 else ())


def loops_between(fabric: StitchMesh, first: int, last: int) -> IntArray:
    """Return the top sides between two faces of a row, left to right; none if the rows are different.

    Around a closed row, the shorter way counts.
    """
    course = course_through(fabric, first)
    place = {face: number for number, face in enumerate(course.faces)}
    if last not in place:
        return np.zeros(0, dtype=np.int64)
    count, steps = len(course.faces), place[last] - place[first]
    if course.closed and abs(steps) * 2 > count:
        steps -= int(np.sign(steps)) * count
    start = place[first] + min(steps, 0)
    faces = [course.faces[(start + step) % count] for step in range(abs(steps) + 1)]
    return np.array(top_sides(fabric, faces), dtype=np.int64)
