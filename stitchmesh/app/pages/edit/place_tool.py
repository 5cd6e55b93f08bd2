# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tools without a brush: edits at a click or at each place of the selection, cables, whole fabrics, and looking."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar, Literal

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.field_panel import Field, FieldPanel, Number, same_words
from stitchmesh.app.controls.html_pieces import paragraph
from stitchmesh.app.pages.edit.edit_session import EditSession
from stitchmesh.app.pages.edit.tool import Tool
from stitchmesh.app.scene.scene import Pick, Stroke
from stitchmesh.errors import ParameterError
from stitchmesh.markup import Markup, markup
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.mesh.courses import course_through, top_sides
from stitchmesh.mesh.picking import PickedPlace

PlaceKind = Literal["face", "selection", "course side", "wale side", "top side"]
"""The place of an edit: a stitch, the selected stitches, or the nearest side of a kind."""


@dataclass(frozen=True)
class PlaceArguments:
    """Arguments of the edits besides their place, as the user has set them."""

    twist: int = 1
    below: int = 1
    above: int = 1
    end: str = "top"
    direction: str = "left"
    courses: int | None = None
    stitch: str = "k"


@dataclass(frozen=True)
class PlaceEdit:
    """An edit at a place."""

    label: str
    hint: str
    edit: str
    """Name of the edit."""
    place: PlaceKind
    settings: tuple[Field, ...] = ()
    """The arguments of the edit, as fields of ``PlaceArguments``."""


TWIST = Field("twist", "Twist", "Which leg of the loop is in front",
              {"left leg in front": 1, "right leg in front": -1, "no twist": 0})  # fmt: skip
BELOW = Field("below", "Loops below, left part", "Loops of the row below that the left part takes", Number(0, 3, 1))
ABOVE = Field("above", "Loops above, left part", "Loops that the left part makes", Number(0, 3, 1))
END = Field("end", "End that moves", "Which end of the edge moves", same_words(("top", "bottom")))
DIRECTION = Field("direction", "Direction", "Where the end moves", same_words(("left", "right")))
COURSES = Field("courses", "Rows", "Number of rows upwards from the click; 0 for the whole column",
                Number(0, 999, 1, without=None))  # fmt: skip
STITCH = Field("stitch", "Stitch of the row", "Stitch of the new rows", {"knit": "k", "purl": "p"})

LOOP_EDITS = (
    PlaceEdit("Twist a loop", "Click near the top of a stitch: its loop gets half a turn.", "twist_loop", "top side",
              (TWIST,)),
    PlaceEdit("Split an edge", "Click a horizontal edge: the stitch below makes one loop more.", "split_course_edge",
              "course side"),
    PlaceEdit("Collapse an edge", "Click a horizontal edge between an increase and a decrease: it closes.",
              "collapse_course_edge", "course side"),
    PlaceEdit("Divide a stitch", "Click a wide stitch: it becomes two.", "add_wale_edge", "face", (BELOW, ABOVE)),
    PlaceEdit("Join two stitches", "Click the vertical edge between two stitches: they become one.",
              "remove_wale_edge", "wale side"),
    PlaceEdit("Shift an edge", "Click a vertical edge: one end moves by a loop.", "shift_wale_edge", "wale side",
              (END, DIRECTION)),
    PlaceEdit("Bobble", "Click a stitch: it becomes a bobble of three short rows.", "bobble", "face"),
)  # fmt: skip
"""Edits of loops and of the edges of stitches."""
ROW_EDITS = (
    PlaceEdit("Insert a row", "Click a stitch: a new row is knitted above its row.", "insert_row", "face", (STITCH,)),
    PlaceEdit("Short rows", "Select neighbouring stitches of a row, and press the button: two short rows are knitted "
              "above them.", "short_rows", "selection", (STITCH,)),
    PlaceEdit("Remove a row", "Click a stitch: its row is removed.", "remove_row", "face"),
    PlaceEdit("Flip a row", "Click a stitch: its row is knitted in the other direction.", "flip_row", "face"),
    PlaceEdit("Insert a wale", "Click a vertical edge: a column of stitches is inserted.", "insert_wale", "wale side",
              (COURSES,)),
    PlaceEdit("Remove a wale", "Click a stitch: its column is removed.", "remove_wale", "face", (COURSES,)),
    PlaceEdit("Separate two rows", "Click a horizontal edge: the two rows along it are separated.", "ungraft",
              "top side"),
)  # fmt: skip
"""Edits of rows and wales."""


class PlaceTool(Tool):
    """Makes one of several edits at the place of a click."""

    edits: ClassVar[tuple[PlaceEdit, ...]]
    """The edits to choose from."""
    what: ClassVar[str]
    """Name of the things that the edits change, for labels."""
    takes_strokes = False

    def __init__(self, session: EditSession) -> None:
        """Begin with the first edit, and with the first value of each setting."""
        super().__init__(session)
        self.chosen = self.edits[0]
        self._values = PlaceArguments()

    def build(self, controls: Controls) -> None:
        """Make the choice of the edit, the settings of all edits, and the button for the selection."""
        labels = [edit.label for edit in self.edits]
        controls.choice(f"Edit of {self.what}", "What a click does", labels, self.chosen.label, self._choose)
        self._words = controls.html(Markup())
        settings = dict.fromkeys(setting for edit in self.edits for setting in edit.settings)
        fields = [replace(setting, shown=partial(self._is_needed, setting)) for setting in settings]
        self._settings = FieldPanel(controls, fields, lambda: self._values, self._take)
        controls.button(f"Edit the selected {self.what}", "Make the chosen edit at each place of the selection",
                        self.on_selection)  # fmt: skip
        self._show_settings()

    def clicked(self, place: PickedPlace, pick: Pick) -> None:
        """Make the edit at the place."""
        fabric, edit = self.session.fabric, self.chosen
        at = np.array([place.face])
        if edit.place == "selection":
            self.session.refuse(at, f"{edit.label}: select the stitches first, then press the button of the tool")
            return
        if edit.place == "face":
            self.session.edit(edit.edit, {"face": place.face, **self._arguments()}, at)
            return
        side = self.side_at(place, edit.place)
        if side is not None and not self.session.edit(edit.edit, {"side": side, **self._arguments()}, at):
            self.session.view.mark_sides(fabric, np.array([side]))

    def on_selection(self) -> None:
        """Make the edit at each place of the selection."""
        arguments = {**self.session.on_selection(), **self._arguments()}
        self.session.edit(self.chosen.edit, arguments, self.session.state.selection.faces)

    def _arguments(self) -> dict[str, object]:
        values = {setting.name: getattr(self._values, setting.name) for setting in self.chosen.settings}
        return {name: value for name, value in values.items() if value is not None}

    def _choose(self, label: str) -> None:
        self.chosen = next(edit for edit in self.edits if edit.label == label)
        self.session.view.unmark()
        self._show_settings()

    def _is_needed(self, setting: Field, values: PlaceArguments) -> bool:
        return setting in self.chosen.settings

    def _take(self, values: PlaceArguments, name: str) -> None:
        self._values = values

    def _show_settings(self) -> None:
        self._words.content = paragraph(self.chosen.hint)
        self._settings.show()


class ChangeLoops(PlaceTool):
    """Edits of loops and edges."""

    name, key, what, edits = "Loops and edges", "L", "loops", LOOP_EDITS
    hint = "Choose an edit below, then click the stitch or the edge."


class ChangeRows(PlaceTool):
    """Edits of rows and wales."""

    name, key, what, edits = "Rows and wales", "R", "rows", ROW_EDITS
    hint = "Choose an edit below, then click the stitch or the edge."


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
        side = self.side_at(place, "border side")
        if side is None:
            return
        if self._first is None:
            self._first = side
            self.session.view.mark_sides(self.session.fabric, np.array([side]))
            self._say()
            return
        first, self._first = self._first, None
        self._say()
        self.session.edit("graft", {"first_side": first, "second_side": side}, np.array([place.face]))

    def _say(self) -> None:
        step = "first border" if self._first is None else "second border"
        self._words.content = paragraph(markup("Graft: click a stitch at the <b>{}</b>.", step))


class LookAround(Tool):
    """Changes nothing: a drag turns the view, and a click describes a stitch."""

    name, key = "Look around", "V"
    hint = "Drag to turn the fabric, scroll to come closer; a click says what a stitch is."
    takes_strokes = False


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
