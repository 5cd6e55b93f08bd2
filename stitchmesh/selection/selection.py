# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Selections of faces as values, which exist before any fabric is given.

A selection is a frozen dataclass. ``parse_selection`` reads its text, ``str(selection)``. The operators ``&``, ``|``
and ``~`` combine selections.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import ParameterError

BORDER_NAMES = ("hem", "cuffs", "neck", "armholes", "tips", "border")
"""Names of borders; ``border`` is followed by the number of a border."""
PLACES = ("front", "back", "left", "right", "sleeves", "body")
"""Names of the parts of a garment."""
SIDED = {"cuffs": "cuff", "armholes": "armhole", "sleeves": "sleeve"}
"""Names of parts that exist on the left and on the right, and their singular forms."""
STITCH_GROUPS = ("increases", "decreases", "cables", "twists", "cast-on", "draw-through")
"""Words for groups of stitches. Cables and twists are the stitches whose loops are crossed or twisted."""

Hand = Literal["left", "right"]
Direction = Literal["both", "up", "down"]


@dataclass(frozen=True)
class Span:
    """Some of the numbers of a sequence: a first and a last number, and groups of numbers in between.

    Raises:
        ParameterError: a number is negative, the last number is below the first, or the groups overlap.
    """

    first: int
    """First number."""
    last: int | None = None
    """Last number; None for the end of the sequence."""
    step: int = 1
    """Distance from the first number of a group to the first number of the next group."""
    height: int = 1
    """Numbers in each group."""

    def __post_init__(self) -> None:
        if self.first < 0 or (self.last is not None and self.last < self.first):
            raise ParameterError(f"selection: got {self}; expected numbers from low to high, such as 10-20")
        if self.step < 1 or not 1 <= self.height <= self.step:
            raise ParameterError(f"selection: got {self}; expected a step of 1 or more and a height from 1 to the step")

    def __str__(self) -> str:
        text = str(self.first)
        if self.last != self.first:
            text += "-" if self.last is None else f"-{self.last}"
        text += f" step {self.step}" if self.step > 1 else ""
        return text + (f" height {self.height}" if self.height > 1 else "")


Spans = tuple[Span, ...]


class Selection:
    """Base class of all selections."""

    binding = 3
    """How strongly the text of the selection binds: ``or`` 0, ``and`` 1, ``not`` 2, all others 3."""

    def __and__(self, other: Selection) -> Both:
        return Both(self, other)

    def __or__(self, other: Selection) -> Either:
        return Either(self, other)

    def __invert__(self) -> Without:
        return Without(self)


def _within(part: Selection, binding: int) -> str:
    """Return the text of a part, in parentheses if the part binds less strongly than the text around it."""
    return f"({part})" if part.binding < binding else str(part)


@dataclass(frozen=True)
class Either(Selection):
    """Faces of one selection or the other, or of both."""

    one: Selection
    other: Selection
    binding = 0

    def __str__(self) -> str:
        return f"{_within(self.one, 0)} or {_within(self.other, 1)}"


@dataclass(frozen=True)
class Both(Selection):
    """Faces that are in both selections."""

    one: Selection
    other: Selection
    binding = 1

    def __str__(self) -> str:
        return f"{_within(self.one, 1)} and {_within(self.other, 2)}"


@dataclass(frozen=True)
class Without(Selection):
    """All faces that are not in a selection."""

    part: Selection
    binding = 2

    def __str__(self) -> str:
        return f"not {_within(self.part, 2)}"


@dataclass(frozen=True)
class Everything(Selection):
    """All faces."""

    def __str__(self) -> str:
        return "all"


@dataclass(frozen=True)
class RowRange(Selection):
    """Whole rows by their numbers (``StitchMesh.row``), counted from 0."""

    spans: Spans

    def __str__(self) -> str:
        return f"rows {_listed(self.spans)}"


@dataclass(frozen=True)
class LastRows(Selection):
    """The rows with the highest numbers."""

    count: int

    def __str__(self) -> str:
        return f"last {self.count} rows"


@dataclass(frozen=True)
class AtBorder(Selection):
    """Bands along borders: faces by their distance from a border, which is 1 for a face that touches the border."""

    name: str
    """One of ``BORDER_NAMES``."""
    spans: Spans = (Span(1, 1),)
    """Distances; one number n stands for the distances 1 to n."""
    hand: Hand | None = None
    """The left or the right border that has this name; None for all."""
    number: int | None = None
    """Number of the border, for the name ``border``."""

    def __str__(self) -> str:
        name = self.name if self.hand is None else f"{self.hand} {SIDED[self.name]}"
        number = "" if self.number is None else f" {self.number}"
        if self.spans == (Span(1, 1),):
            return f"{name}{number}"
        only = self.spans[0]
        first = str(only.last) if len(self.spans) == 1 and only == Span(1, only.last) and only.last else None
        return f"{name}{number} {first or _listed(self.spans)}"


@dataclass(frozen=True)
class GarmentPart(Selection):
    """A part of a garment."""

    name: str
    """One of ``PLACES``."""
    hand: Hand | None = None
    """The left or the right sleeve, for the name ``sleeves``; None for both."""

    def __str__(self) -> str:
        return self.name if self.hand is None else f"{self.hand} {SIDED[self.name]}"


@dataclass(frozen=True)
class WalePanel(Selection):
    """Neighbouring wales in the middle of a side of the garment, from the first row upwards."""

    side: str
    """``front``, ``back``, ``left`` or ``right``."""
    width: int
    """Number of wales."""

    def __str__(self) -> str:
        return f"{self.side} panel {self.width}"


@dataclass(frozen=True)
class Stitches(Selection):
    """Faces that hold one type of stitch, or any type of a group."""

    name: str
    """Abbreviation or code of the stitch, or one of ``STITCH_GROUPS``."""

    def __str__(self) -> str:
        return self.name if self.name in STITCH_GROUPS else f"stitch {self.name}"


@dataclass(frozen=True)
class OfYarn(Selection):
    """Faces that are knitted with the yarns of some numbers."""

    spans: Spans

    def __str__(self) -> str:
        return f"yarn {_listed(self.spans)}"


@dataclass(frozen=True)
class Faces(Selection):
    """Single faces by number."""

    spans: Spans

    def __str__(self) -> str:
        return f"faces {_listed(self.spans)}"


@dataclass(frozen=True)
class FacesOfFile(Selection):
    """Faces whose numbers stand in a text file, separated by white space or commas; # begins a comment."""

    path: str

    def __str__(self) -> str:
        return f'file "{self.path}"'


@dataclass(frozen=True)
class Wale(Selection):
    """The column of stitches through a face, or above a course edge."""

    start: int
    """Number of the face, or of a side of the edge."""
    direction: Direction = "both"
    """Whether the column runs upwards from the face, downwards, or both ways."""
    count: int | None = None
    """Number of faces in each direction, the first face included; None for all."""
    from_side: bool = False
    """Whether ``start`` is a side; the column then runs upwards from the edge of the side."""

    def __str__(self) -> str:
        return f"wale {'side ' if self.from_side else ''}{self.start}{_run(self.direction, self.count)}"


@dataclass(frozen=True)
class Ring(Selection):
    """The row through a face, and rows above or below it."""

    face: int
    direction: Direction = "both"
    """Whether further rows are counted upwards, downwards, or both."""
    count: int = 1
    """Number of rows in each direction, the first row included."""

    def __str__(self) -> str:
        return f"ring {self.face}{_run(self.direction, self.count if self.count > 1 else None)}"


@dataclass(frozen=True)
class Rectangle(Selection):
    """A rectangle of rows and wales above and to the right of a face."""

    face: int
    """Lower left face."""
    width: int
    """Number of wales."""
    height: int
    """Number of rows."""

    def __str__(self) -> str:
        return f"rectangle {self.face} {self.width}x{self.height}"


@dataclass(frozen=True)
class RectangleBetween(Selection):
    """The rectangle of rows and wales between two opposite corner faces."""

    corner: int
    opposite: int

    def __str__(self) -> str:
        return f"rectangle {self.corner} to {self.opposite}"


def _listed(spans: Spans) -> str:
    return ", ".join(str(span) for span in spans)


def _run(direction: Direction, count: int | None) -> str:
    return ("" if direction == "both" else f" {direction}") + ("" if count is None else f" {count}")


def with_paths(selection: Selection, change: Callable[[str], str]) -> Selection:
    """Return a selection in which a function has changed the paths of files."""
    match selection:
        case FacesOfFile(path):
            return FacesOfFile(change(path))
        case Without(part):
            return Without(with_paths(part, change))
        case Either(one, other) | Both(one, other):
            return replace(selection, one=with_paths(one, change), other=with_paths(other, change))
    return selection


def selection_of_faces(faces: ArrayLike) -> Faces:
    """Return the selection of some faces by number, with neighbouring numbers as spans: ``faces 3-7, 12``.

    Args:
        faces: numbers of the faces, in any order, shape (n,), with n at least 1.

    Raises:
        ParameterError: there are no faces, or a number is negative.
    """
    numbers = np.unique(np.asarray(faces, dtype=np.int64))
    if not len(numbers):
        raise ParameterError("selection of faces: got none; expected at least one")
    breaks = np.flatnonzero(np.diff(numbers) != 1)
    first = numbers[np.concatenate([[0], breaks + 1])]
    last = numbers[np.concatenate([breaks, [len(numbers) - 1]])]
    return Faces(tuple(Span(one, other) for one, other in zip(first.tolist(), last.tolist(), strict=True)))
