# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The edits that are made by one click at a place, as data: what is clicked, and which settings they have."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from stitchmesh.app.controls.controls import Control, Controls

PlaceKind = Literal["face", "selection", "course side", "wale side", "top side"]
"""What an edit is made at: a stitch, the selected stitches, or the nearest side of a kind."""


@dataclass(frozen=True, eq=False)
class Setting:
    """A setting of an edit: words to choose from, or a whole number."""

    argument: str
    label: str
    hint: str
    words: Mapping[str, object] | None = None
    """Values by the words that the user chooses from; None for a number."""
    least: int = 0
    most: int = 0
    start: object = None
    """First value: a word, or a number."""
    none_at: int | None = None
    """Number that stands for no value."""


@dataclass(frozen=True)
class PlaceEdit:
    """An edit at a place."""

    label: str
    hint: str
    edit: str
    """Name of the edit."""
    place: PlaceKind
    settings: tuple[Setting, ...] = ()


TWIST = Setting(
    "twist", "Twist", "Which leg of the loop is in front",
    {"left leg in front": 1, "right leg in front": -1, "no twist": 0}, start="left leg in front",
)  # fmt: skip
BELOW = Setting("below", "Loops below, left part", "Loops of the row below that the left part takes", None, 0, 3, 1)
ABOVE = Setting("above", "Loops above, left part", "Loops that the left part makes", None, 0, 3, 1)
END = Setting("end", "End that moves", "Which end of the edge moves", {"top": "top", "bottom": "bottom"}, start="top")
DIRECTION = Setting(
    "direction", "Direction", "Where the end moves", {"left": "left", "right": "right"}, start="left"
)  # fmt: skip
COURSES = Setting(
    "courses", "Rows", "Number of rows upwards from the click; 0 for the whole column", None, 0, 999, 0, none_at=0
)  # fmt: skip
STITCH = Setting("stitch", "Stitch of the row", "Stitch of the new rows", {"knit": "k", "purl": "p"}, start="knit")

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


def value_of(setting: Setting, chosen: Any) -> object:
    """Return the argument for what the user has chosen."""
    if setting.words is not None:
        return setting.words[chosen]
    return None if int(chosen) == setting.none_at else int(chosen)


def add_setting(controls: Controls, setting: Setting, value: Any, changed: Callable[[Any], object]) -> Control:
    """Make the control of a setting; ``value`` is a word or a number."""
    if setting.words is not None:
        return controls.choice(setting.label, setting.hint, tuple(setting.words), str(value), changed)
    bounds = {"least": setting.least, "most": setting.most}
    return controls.number(setting.label, setting.hint, int(value), changed, **bounds, step=1)
