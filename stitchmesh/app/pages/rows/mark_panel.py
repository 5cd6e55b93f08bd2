# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The list of the marks, and the controls of the chosen one."""

from __future__ import annotations

from collections.abc import Callable

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.field_panel import Field, FieldPanel, Number, TickBox
from stitchmesh.app.controls.html_pieces import BUTTON, PLAIN_TEXT, action_button, list_button, status_line
from stitchmesh.app.pages.rows.rows_finder import FoundRows
from stitchmesh.app.pages.rows.rows_state import (
    AUTOMATIC,
    Marks,
    MeshBorders,
    RowsState,
    with_border_role,
    with_mark,
    with_role,
    without_mark,
    without_point,
)
from stitchmesh.errors import ParameterError
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.shaping.marks import UNTIMED, TimeMark

KIND_WORDS = {"border": "border", "point": "tip", "stroke": "line"}
"""Words for the kinds of marks."""


def mark_list(marks: Marks, chosen: int | None, borders: MeshBorders) -> Markup:
    """Return for each mark a button that chooses it, and a button that removes it."""
    if not marks:
        return status_line("There are no marks: begins and ends are found automatically.")
    items = joined(_mark_item(number, mark, number == chosen, borders) for number, mark in enumerate(marks))
    return markup('<ul aria-label="Marks" style="list-style:none;margin:0;padding:0">{}</ul>', items)


def _mark_item(number: int, mark: TimeMark, chosen: bool, borders: MeshBorders) -> Markup:
    words = f"{number}: {mark_words(mark, borders)}"
    colour = "rgb(232,140,20)" if chosen else "var(--mantine-color-default-border)"
    narrow = f"{BUTTON} var(--mantine-color-default-border);width:2.2em;flex:none;text-align:center"
    return markup(
        '<li style="display:flex;gap:4px;align-items:stretch">{}{}</li>',
        list_button("choose", number, words, colour, hint="Choose this mark", pressed=chosen),
        action_button("remove", number, "✕", name=f"Remove mark {number}", hint="Remove this mark", style=narrow),
    )


def mark_words(mark: TimeMark, borders: MeshBorders) -> str:
    """Describe a mark by its kind, its role and its time."""
    what = KIND_WORDS[mark.kind]
    if mark.kind == "border":
        number = borders.nearest(mark.points[0])
        what = what if number is None else borders.words(number)
    elif mark.kind == "stroke":
        what = f"line of {len(mark.points)} points"
    time = "" if mark.time is None else f", {mark.time:g} cm"
    radius = "" if mark.radius is None else f", up to {mark.radius:g} cm"
    return f"{mark.role}, {what}{time}{radius}"


def border_list(borders: MeshBorders, marks: Marks) -> Markup:
    """Return for each border a button that gives it the next role."""
    if not borders.loops:
        return status_line("The mesh has no border.")
    heading = markup('<p style="{}">Give a border its next role:</p>', PLAIN_TEXT)
    buttons = joined(
        list_button("border", number, f"{borders.words(number)}: {borders.role_of(marks, number)}")
        for number in range(len(borders.loops))
    )
    return heading + buttons


BORDER_ROLES = (AUTOMATIC, "begin", "end", "row", "side", "plain")
"""Roles of a border."""
ROLES = ("begin", "end", "row", "plain")
"""Roles of a tip and of a line."""
LONGEST = 10_000.0
"""Largest time [cm]."""


class MarkPanel:
    """The list of the marks, and below it the controls of the chosen mark."""

    def __init__(self, state: RowsState, controls: Controls, take: Callable[[RowsState], object]) -> None:
        """Make the controls; ``take`` is called with the state after each action."""
        self._state, self._take = state, take
        self._borders: MeshBorders | None = None
        self._found: FoundRows | None = None
        self._list = controls.html(Markup(), self._clicked)
        self._border_role = controls.choice(
            "Role of the border", "What happens at the chosen border; automatic removes the mark.", BORDER_ROLES,
            AUTOMATIC, self._set_border_role,
        )  # fmt: skip
        self._role = controls.choice("Role", "What happens at the chosen tip or line.", ROLES, ROLES[0], self._set_role)
        self._numbers = FieldPanel(controls, self._fields(), self._mark, self._take_mark)
        self._point = controls.number(
            "Point", "Number of a point of the chosen line, from 1; it can be moved and removed.", 1, self._set_point,
            least=1, most=10_000, step=1,
        )  # fmt: skip
        self._remove = controls.button("Remove the mark", "Remove the chosen mark (X).", self._remove_mark)
        self._remove_point = controls.button(
            "Remove the point", "Remove the chosen point of the line.", self._remove_chosen_point
        )
        controls.key("Remove the mark", "Remove the chosen mark.", "X", None, self._remove_mark)

    def show(self, state: RowsState, borders: MeshBorders, found: FoundRows | None) -> None:
        """Show the marks of a state; the rows that were found give a time to a mark without one."""
        self._state, self._borders, self._found = state, borders, found
        self._list.content = mark_list(state.marks, state.chosen, borders)
        mark = self._mark()
        is_border, is_line = mark is not None and mark.kind == "border", mark is not None and mark.kind == "stroke"
        self._border_role.visible, self._role.visible = is_border, mark is not None and not is_border
        self._numbers.show()
        self._point.visible = is_line
        self._remove.visible, self._remove_point.visible = mark is not None, is_line
        if mark is not None:
            (self._border_role if is_border else self._role).value = mark.role
            self._point.value = state.point + 1

    def _clicked(self, action: str, value: str) -> None:
        """Choose or remove a mark of the list.

        Raises:
            ParameterError: the list has changed.
        """
        if not value.isdecimal() or int(value) >= len(self._state.marks):
            raise ParameterError("mark: the list has changed; look at it again")
        if action == "choose":
            self._take(self._state.choosing(int(value)))
        else:
            self._take_marks(without_mark(self._state.marks, int(value)))

    def _take_marks(self, marks: Marks, chosen: int | None = None, what: str = "") -> None:
        self._take(self._state.with_marks(marks, chosen, what))

    def _set_border_role(self, role: str) -> None:
        number, mark = self._state.chosen_mark()
        assert self._borders is not None
        border = self._borders.nearest(mark.points[0])
        if border is not None:
            marks = with_border_role(self._state.marks, self._borders, border, role)
            self._take_marks(marks, None if role == AUTOMATIC else number)

    def _set_role(self, role: str) -> None:
        number, _ = self._state.chosen_mark()
        self._take_marks(with_role(self._state.marks, number, role), number)

    def _mark(self) -> TimeMark | None:
        return None if self._state.chosen is None else self._state.marks[self._state.chosen]

    def _time_now(self, mark: TimeMark) -> float:
        """Return the present time at the place of a mark [cm]."""
        return 0.0 if self._found is None else round(self._found.time_at(mark.points[0]), 1)

    def _fields(self) -> tuple[Field, ...]:
        hint = "Give the chosen mark a time, instead of the one that follows from the mesh."
        given = TickBox("Given time", hint, self._time_now, ticked_without=False)
        return (
            Field("time", "Time", "Length of the fabric from its begin to the chosen mark [cm].",
                  Number(-LONGEST, LONGEST, 0.1, without=None, box=given), lambda mark: mark.role not in UNTIMED),
            Field("radius", "Plain up to", "Distance from the mark without increases and decreases [cm]; 0 is three "
                  "stitch widths.", Number(0.0, LONGEST, 0.1, without=None), lambda mark: mark.role == "plain"),
        )  # fmt: skip

    def _take_mark(self, mark: TimeMark, name: str) -> None:
        """Take another time or radius; consecutive changes are undone together."""
        number, before = self._state.chosen_mark()
        typed = getattr(before, name) is not None and getattr(mark, name) is not None
        marks = with_mark(self._state.marks, number, mark)
        self._take_marks(marks, number, f"{name} of {number}" if typed else "")

    def _set_point(self, point: float) -> None:
        self._take(self._state.choosing(self._state.chosen, int(point) - 1))

    def _remove_chosen_point(self) -> None:
        number, _ = self._state.chosen_mark()
        self._take_marks(without_point(self._state.marks, number, self._state.point), number)

    def _remove_mark(self) -> None:
        number, _ = self._state.chosen_mark()
        self._take_marks(without_mark(self._state.marks, number))
