# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knitting patterns: rows of stitches that repeat to the right, and upwards where they close.

A pattern describes fabric, not the way to it: everything in it is seen from the right side, left to right, and rows
run from the bottom up, whatever side they were written from. Each row has three sections: a left border, the tile
that repeats, and a right border; borders stand once, at the edges of a panel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from stitchmesh.errors import PatternError, first_few
from stitchmesh.mesh.stitch import SIDE_COUNTS, VOCABULARY, Stitch

SECTIONS = ("left border", "tile", "right border")
"""The sections of a row, from left to right."""


@dataclass(frozen=True)
class Cell:
    """One stitch of a chart.

    Raises:
        PatternError: the stitch cannot stand in a chart, or it has a wrong number of twists, or a yarn below 0.
    """

    stitch: Stitch
    """What is worked; a stitch of ``VOCABULARY``."""
    twist: tuple[int, ...] = ()
    """Half turn of each loop on top, left to right: -1, 0 or 1 as in ``StitchMesh.twist``; all 0 where not given."""
    yarn: int = 0
    """Which yarn it is worked with, numbered like colours."""

    def __post_init__(self) -> None:
        if self.stitch not in VOCABULARY:
            raise PatternError(f"stitch {self.stitch!r}: cannot stand in a pattern; expected one of stitch.VOCABULARY")
        if not self.twist:
            object.__setattr__(self, "twist", (0,) * self.n_top)
        if len(self.twist) != self.n_top or any(twist not in (-1, 0, 1) for twist in self.twist):
            found = f"{self.stitch.name} has twists {self.twist}"
            raise PatternError(f"{found}; expected -1, 0 or 1 for each of its {self.n_top} loops on top")
        if self.yarn < 0:
            raise PatternError(f"{self.stitch.name}: got yarn {self.yarn}; yarns are numbered from 0")

    @property
    def n_bottom(self) -> int:
        """Number of loops it is worked on."""
        return SIDE_COUNTS[self.stitch][0]

    @property
    def n_top(self) -> int:
        """Number of loops it leaves."""
        return SIDE_COUNTS[self.stitch][1]


@dataclass(frozen=True)
class Loop:
    """How a loop of the row below is held when it is worked: moved by a cable, or entered through its back leg."""

    shift: int = 0
    """How many loops to the right it is moved before it is worked, as ``StitchMesh.cable_shift``."""
    layer: int = 0
    """Of loops that cross, the one of the higher number lies in front, as ``StitchMesh.cable_layer``; else 0."""
    twist: int = 0
    """Half turn that the stitch above gives it: -1 where it is worked through the back leg."""


@dataclass(frozen=True)
class Row:
    """One row of a pattern.

    Raises:
        PatternError: the tile has no loop below or on top, the borders are wider than the row, there are not as many
            loops as the stitches are worked on, or a cable does not stay within its section.
    """

    cells: tuple[Cell, ...]
    """Its stitches, left to right as seen from the right side."""
    loops: tuple[Loop, ...] = ()
    """How each loop of the row below is held, left to right as they come; all plain where not given."""
    left: int = 0
    """How many cells at the left are the left border."""
    right: int = 0
    """How many cells at the right are the right border."""

    def __post_init__(self) -> None:
        if self.left < 0 or self.right < 0 or self.left + self.right > len(self.cells):
            found = f"borders of {self.left} and {self.right} stitches in a row of {len(self.cells)}"
            raise PatternError(f"got {found}; expected them to leave a tile")
        if self.bottoms[1] < 1 or self.tops[1] < 1:
            found = f"a tile on {self.bottoms[1]} loops that leaves {self.tops[1]}"
            raise PatternError(f"got {found}; expected at least 1 of each")
        if not self.loops:
            object.__setattr__(self, "loops", (Loop(),) * self.n_bottom)
        if len(self.loops) != self.n_bottom:
            raise PatternError(f"got {len(self.loops)} loops; the stitches are worked on {self.n_bottom}")
        check_cables(self.loops, self.bottoms)
        object.__setattr__(self, "loops", _without_idle_layers(self.loops))

    @cached_property
    def sections(self) -> tuple[tuple[Cell, ...], tuple[Cell, ...], tuple[Cell, ...]]:
        """The cells of the left border, of the tile and of the right border."""
        end = len(self.cells) - self.right
        return self.cells[: self.left], self.cells[self.left : end], self.cells[end:]

    @property
    def loop_sections(self) -> tuple[tuple[Loop, ...], tuple[Loop, ...], tuple[Loop, ...]]:
        """The loops below the left border, the tile and the right border."""
        left, tile, _ = self.bottoms
        return self.loops[:left], self.loops[left : left + tile], self.loops[left + tile :]

    @cached_property
    def bottoms(self) -> tuple[int, int, int]:
        """How many loops each section is worked on."""
        left, tile, right = (sum(cell.n_bottom for cell in section) for section in self.sections)
        return left, tile, right

    @cached_property
    def tops(self) -> tuple[int, int, int]:
        """How many loops each section leaves."""
        left, tile, right = (sum(cell.n_top for cell in section) for section in self.sections)
        return left, tile, right

    @property
    def n_bottom(self) -> int:
        """How many loops the row is worked on, with the tile once."""
        return sum(self.bottoms)

    @property
    def n_top(self) -> int:
        """How many loops the row leaves, with the tile once."""
        return sum(self.tops)


@dataclass(frozen=True)
class Pattern:
    """A pattern: rows from the bottom up.

    Raises:
        PatternError: there are no rows, a name cannot be written down, the loops of a section do not carry over from
            one row to the next, or a loop is twisted twice.
    """

    name: str
    """What knitters call it."""
    source: str
    """Where it comes from."""
    rows: tuple[Row, ...]
    """Rows from the bottom up."""

    def __post_init__(self) -> None:
        for text in (self.name, self.source):
            if '"' in text or any(not character.isprintable() for character in text):
                raise PatternError(f"pattern {text!r}: got quotes or line ends in its name or source; leave them out")
        if not self.rows:
            raise PatternError(f"pattern {self.name!r}: got no rows; expected at least one")
        fault = first_fault(self.rows)
        if fault:
            raise PatternError(f"pattern {self.name!r}, row {fault[0] + 1}: {fault[1]}")

    @property
    def width(self) -> int:
        """Loops of the tile at the bottom."""
        return self.rows[0].bottoms[1]

    @property
    def height(self) -> int:
        """Number of rows."""
        return len(self.rows)

    @cached_property
    def closes(self) -> bool:
        """Whether the last row leaves as many loops in each section as the first is worked on: it repeats upwards."""
        return self.rows[-1].tops == self.rows[0].bottoms

    @property
    def yarn_count(self) -> int:
        """How many yarns it takes: one more than the highest number."""
        return 1 + max(cell.yarn for row in self.rows for cell in row.cells)

    def loops_above(self, row: int) -> tuple[Loop, ...]:
        """The marks of the loops on top of a row: its own twists and how the next row holds them.

        These are ``twist``, ``cable_shift`` and ``cable_layer`` of the top sides of a stitch mesh, left to right, the
        tile once. The row after the last is the first where the pattern closes; else the last loops are held plainly.
        """
        twists = [twist for cell in self.rows[row].cells for twist in cell.twist]
        last = row + 1 == self.height
        held = (Loop(),) * len(twists) if last and not self.closes else self.rows[(row + 1) % self.height].loops
        return tuple(
            Loop(loop.shift, loop.layer, loop.twist + twist) for loop, twist in zip(held, twists, strict=True)
        )


def check_closes(pattern: Pattern) -> None:
    """Check that a pattern repeats upwards: its last row leaves the loops that its first is worked on.

    Raises:
        PatternError: it does not; with the section, both counts, and the rows that change counts.
    """
    last, first = pattern.rows[-1], pattern.rows[0]
    for index, (left, worked) in enumerate(zip(last.tops, first.bottoms, strict=True)):
        if left == worked:
            continue
        changes = [(number, row.tops[index] - row.bottoms[index]) for number, row in enumerate(pattern.rows, start=1)]
        by_rows = first_few([f"row {number} by {change:+d}" for number, change in changes if change])
        where = f"pattern {pattern.name!r}, row {pattern.height}"
        found = f"its {SECTIONS[index]} leaves {left} loops, but row 1 is worked on {worked}"
        raise PatternError(f"{where}: {found}; to repeat upwards, mend what changes the count: {by_rows}")


def first_fault(rows: Sequence[Row]) -> tuple[int, str] | None:
    """The first row, numbered from 0, that does not fit on the row below, and why."""
    pairs = [(index, rows[index - 1], rows[index]) for index in range(1, len(rows))]
    if rows[-1].tops == rows[0].bottoms:
        pairs.append((0, rows[-1], rows[0]))
    for index, below, row in pairs:
        fault = _misfit(below, row)
        if fault:
            return index, fault
    return None


def _misfit(below: Row, row: Row) -> str | None:
    for section, made, worked in zip(SECTIONS, below.tops, row.bottoms, strict=True):
        if made != worked:
            return f"its {section} is worked on {worked} loops, but the row below leaves {made}; counts must carry over"
    twists = [twist for cell in below.cells for twist in cell.twist]
    for place, (twist, loop) in enumerate(zip(twists, row.loops, strict=True)):
        if abs(twist + loop.twist) > 1:
            return f"loop {place + 1} from the left is twisted twice the same way; expected one half turn at most"
    return None


def check_cables(loops: Sequence[Loop], widths: Sequence[int]) -> None:
    """Check that the loops of each section are reordered among themselves and never collide.

    Raises:
        PatternError: a loop leaves its section, two go to one place, or two that cross are in one layer.
    """
    start = 0
    for section, width in zip(SECTIONS, widths, strict=True):
        part = loops[start : start + width]
        _check_section(part, section)
        start += width


def _check_section(loops: Sequence[Loop], section: str) -> None:
    taken: dict[int, int] = {}
    for place, loop in enumerate(loops):
        where, end = f"loop {place + 1} of the {section}", place + loop.shift
        if not 0 <= end < len(loops):
            raise PatternError(f"{where} is crossed to place {end + 1} of {len(loops)}; a cable stays in its section")
        if end in taken:
            raise PatternError(f"{where} and loop {taken[end]} are crossed to one place; cables must not overlap")
        if loop.layer < 0 or loop.twist not in (-1, 0, 1):
            raise PatternError(f"{where}: got layer {loop.layer}, twist {loop.twist}; expected 0 or more, and -1 to 1")
        taken[end] = place + 1
    for cable in crossings(loops):
        _check_layers(loops, cable, section)


def _check_layers(loops: Sequence[Loop], cable: range, section: str) -> None:
    for right in cable:
        for left in range(cable.start, right):
            crossed = left + loops[left].shift > right + loops[right].shift
            if crossed and loops[left].layer == loops[right].layer:
                found = f"loops {left + 1} and {right + 1} of the {section} cross in one layer"
                raise PatternError(f"{found}; the higher layer lies in front, so they must differ")


def _without_idle_layers(loops: tuple[Loop, ...]) -> tuple[Loop, ...]:
    """The loops, at layer 0 where they cross no other: what means the same is the same."""
    if not any(loop.layer for loop in loops):
        return loops
    crossed = {place for cable in crossings(loops) for place in cable}
    return tuple(loop if place in crossed else Loop(twist=loop.twist) for place, loop in enumerate(loops))


def crossings(loops: Sequence[Loop]) -> list[range]:
    """The cables among loops that are reordered: the smallest intervals that keep their own loops."""
    found, start, reach = [], 0, -1
    for place, loop in enumerate(loops):
        reach = max(reach, place + loop.shift)
        if reach == place:
            if place > start:
                found.append(range(start, place + 1))
            start = place + 1
    return found
