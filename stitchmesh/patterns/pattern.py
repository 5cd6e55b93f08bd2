# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knitting patterns: rows of stitches that repeat to the right, and upwards if the pattern closes.

A pattern describes the fabric, not the instructions that make it: all stitches are seen from the right side and listed
from left to right, and the rows are listed from the bottom up, whichever side the instructions were written for. Each
row has three sections: a left border, a tile, and a right border. The tile repeats across the row. Each border occurs
once, at the edge of a panel.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from stitchmesh.errors import PatternError, first_few
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.mesh.own_stitch import FIRST_OWN, OwnStitch, StitchType
from stitchmesh.mesh.stitch import VOCABULARY, Making

SECTIONS = ("left border", "tile", "right border")
"""The sections of a row, from left to right."""


@dataclass(frozen=True)
class Cell:
    """One stitch of a chart.

    Raises:
        PatternError: the stitch is not one of ``VOCABULARY``, the number of twists is wrong, or the yarn is negative.
    """

    stitch: StitchType
    """Type of the stitch, one of ``VOCABULARY``, or a stitch of the user's own."""
    twist: tuple[int, ...] = ()
    """Half turn of each top loop, left to right: -1, 0 or 1 as in ``StitchMesh.twist``; all 0 by default."""
    yarn: int = 0
    """Number of the yarn of the stitch, from 0."""

    def __post_init__(self) -> None:
        if not isinstance(self.stitch, OwnStitch) and self.stitch not in VOCABULARY:
            raise PatternError(f"stitch {self.stitch!r}: cannot occur in a pattern; expected one of stitch.VOCABULARY")
        if not self.twist:
            object.__setattr__(self, "twist", (0,) * self.n_top)
        if len(self.twist) != self.n_top or any(twist not in (-1, 0, 1) for twist in self.twist):
            found = f"{stitch_name(self.stitch)} has twists {self.twist}"
            raise PatternError(f"{found}; expected -1, 0 or 1 for each of its {self.n_top} loops on top")
        if self.yarn < 0:
            raise PatternError(f"{stitch_name(self.stitch)}: got yarn {self.yarn}; yarns are numbered from 0")

    @property
    def making(self) -> Making:
        """How the stitch is made."""
        return self.stitch.making if isinstance(self.stitch, OwnStitch) else VOCABULARY[self.stitch]

    @property
    def n_bottom(self) -> int:
        """Number of loops on which the stitch is worked."""
        return self.making.n_bottom

    @property
    def n_top(self) -> int:
        """Number of loops the stitch makes."""
        return self.making.n_top


@dataclass(frozen=True)
class Loop:
    """How a stitch holds a loop of the row below: the loop may be moved by a cable or worked through its back leg."""

    shift: int = 0
    """Number of places by which the loop is moved to the right before it is worked, as in
    ``StitchMesh.cable_shift``."""
    layer: int = 0
    """Layer of a loop that crosses others, as in ``StitchMesh.cable_layer``: the loop with the higher layer lies in
    front. A loop that crosses no other has layer 0."""
    twist: int = 0
    """Half turn that the stitch above gives to the loop: -1 if the stitch is worked through the back leg."""


@dataclass(frozen=True)
class Row:
    """One row of a pattern.

    Raises:
        PatternError: the tile has no loops at its bottom or top, the borders are wider than the row, the number of
            loops differs from the number that the stitches take, or a cable crosses the limits of its section.
    """

    cells: tuple[Cell, ...]
    """Stitches of the row, left to right as seen from the right side."""
    loops: tuple[Loop, ...] = ()
    """How each loop of the row below is held, left to right before any crossing; all plain by default."""
    left: int = 0
    """Number of cells in the left border."""
    right: int = 0
    """Number of cells in the right border."""

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
        """Number of loops on which each section is worked."""
        left, tile, right = (sum(cell.n_bottom for cell in section) for section in self.sections)
        return left, tile, right

    @cached_property
    def tops(self) -> tuple[int, int, int]:
        """Number of loops each section makes."""
        left, tile, right = (sum(cell.n_top for cell in section) for section in self.sections)
        return left, tile, right

    @cached_property
    def made_twists(self) -> tuple[int, ...]:
        """Half turn with which each loop on top is made, left to right."""
        return tuple(twist for cell in self.cells for twist in cell.twist)

    @cached_property
    def held_twists(self) -> tuple[int, ...]:
        """Half turn that the stitches give to each loop below, left to right."""
        return tuple(loop.twist for loop in self.loops)

    @property
    def n_bottom(self) -> int:
        """Number of loops on which the row is worked, with the tile counted once."""
        return sum(self.bottoms)

    @property
    def n_top(self) -> int:
        """Number of loops that the row makes, with the tile counted once."""
        return sum(self.tops)


@dataclass(frozen=True)
class Pattern:
    """A knitting pattern: its rows from the bottom up.

    Raises:
        PatternError: there are no rows, the name or source holds quotes or line ends, the number of loops in a section
            differs between the top of a row and the bottom of the next row, or a loop is twisted twice.
    """

    name: str
    """The name knitters use for the pattern."""
    source: str
    """The publication or tradition from which the pattern comes."""
    rows: tuple[Row, ...]
    """Rows of the pattern, from the bottom up."""
    palette: tuple[tuple[int, int, int], ...] = ()
    """Colour of each yarn number (sRGB, 0 to 255); empty if the pattern numbers its yarns only."""

    def __post_init__(self) -> None:
        for text in (self.name, self.source):
            if '"' in text or any(not character.isprintable() for character in text):
                raise PatternError(f"pattern {text!r}: got quotes or line ends in its name or source; leave them out")
        if not self.rows:
            raise PatternError(f"pattern {self.name!r}: got no rows; expected at least one")
        fault = first_fault(self.rows)
        if fault:
            raise PatternError(f"pattern {self.name!r}, row {fault[0] + 1}: {fault[1]}")

    def __repr__(self) -> str:
        """Return one line: the name and the size."""
        return f"Pattern({self.name!r}, {self.width} loops x {self.height} rows)"

    @property
    def width(self) -> int:
        """Number of loops at the bottom of the tile."""
        return self.rows[0].bottoms[1]

    @property
    def height(self) -> int:
        """Number of rows."""
        return len(self.rows)

    @cached_property
    def closes(self) -> bool:
        """Whether the pattern repeats upwards: the last row makes the loops that the first needs, in each section."""
        return self.rows[-1].tops == self.rows[0].bottoms

    @property
    def yarn_count(self) -> int:
        """Number of yarns in the pattern: one more than the highest yarn number."""
        return 1 + max(cell.yarn for row in self.rows for cell in row.cells)

    @cached_property
    def ground(self) -> int:
        """Number of the yarn that most stitches have, the lowest of several: the yarn behind the motifs of a chart."""
        yarns = Counter(cell.yarn for row in self.rows for cell in row.cells)
        return min(yarns, key=lambda yarn: (-yarns[yarn], yarn))

    @cached_property
    def own_stitches(self) -> tuple[OwnStitch, ...]:
        """The stitches of the user's own, in the order of their first use."""
        cells = (cell.stitch for row in self.rows for cell in row.cells)
        return tuple(dict.fromkeys(stitch for stitch in cells if isinstance(stitch, OwnStitch)))

    def type_code(self, stitch: StitchType) -> int:
        """Return the type code of a stitch in a stitch mesh of the pattern."""
        return FIRST_OWN + self.own_stitches.index(stitch) if isinstance(stitch, OwnStitch) else int(stitch)

    def loops_above(self, row: int) -> tuple[Loop, ...]:
        """Return the marks of the loops on top of a row.

        A mark combines the twist from the stitches of this row with the way the next row holds the loop. The marks are
        ``twist``, ``cable_shift`` and ``cable_layer`` of the top sides of a stitch mesh, left to right, with the tile
        counted once. If the pattern closes, the first row follows the last row; otherwise the top loops of the last
        row are held plainly.

        Args:
            row: index of the row, from 0.
        """
        twists = [twist for cell in self.rows[row].cells for twist in cell.twist]
        last = row + 1 == self.height
        held = (Loop(),) * len(twists) if last and not self.closes else self.rows[(row + 1) % self.height].loops
        return tuple(Loop(loop.shift, loop.layer, loop.twist + twist) for loop, twist in zip(held, twists, strict=True))

    def without_borders(self) -> Pattern:
        """Return the pattern of the tile alone."""
        tile = SECTIONS.index("tile")
        rows = tuple(Row(row.sections[tile], row.loop_sections[tile]) for row in self.rows)
        return Pattern(self.name, self.source, rows, self.palette)


def check_closes(pattern: Pattern) -> None:
    """Check that a pattern repeats upwards: the last row makes the loops on which the first row is worked.

    Raises:
        PatternError: the numbers of loops differ. The message gives the section, both numbers and the rows that change
            the number of loops.
    """
    last, first = pattern.rows[-1], pattern.rows[0]
    for index, (made, worked) in enumerate(zip(last.tops, first.bottoms, strict=True)):
        if made == worked:
            continue
        changes = [(number, row.tops[index] - row.bottoms[index]) for number, row in enumerate(pattern.rows, start=1)]
        by_rows = first_few([f"row {number} by {change:+d}" for number, change in changes if change])
        where = f"pattern {pattern.name!r}, row {pattern.height}"
        found = f"its {SECTIONS[index]} leaves {made} loops, but row 1 is worked on {worked}"
        raise PatternError(f"{where}: {found}; to repeat upwards, correct the rows that change the count: {by_rows}")


def first_fault(rows: Sequence[Row]) -> tuple[int, str] | None:
    """Return the first row, numbered from 0, that does not fit the row below it, and the reason; None if all fit."""
    pairs = [(index, rows[index - 1], rows[index]) for index in range(1, len(rows))]
    if rows[-1].tops == rows[0].bottoms:
        pairs.append((0, rows[-1], rows[0]))
    for index, below, row in pairs:
        fault = _mismatch(below, row)
        if fault:
            return index, fault
    return None


def _mismatch(below: Row, row: Row) -> str | None:
    for section, made, worked in zip(SECTIONS, below.tops, row.bottoms, strict=True):
        if made != worked:
            found = f"its {section} is worked on {worked} loops, but the row below leaves {made}"
            return f"{found}; expected equal numbers"
    if not (any(below.made_twists) and any(row.held_twists)):
        return None
    for place, (made, held) in enumerate(zip(below.made_twists, row.held_twists, strict=True)):
        if abs(made + held) > 1:
            return f"loop {place + 1} from the left is twisted twice in one direction; expected one half turn at most"
    return None


def check_cables(loops: Sequence[Loop], widths: Sequence[int]) -> None:
    """Check that cables permute the loops of each section among themselves.

    Args:
        loops: the loops of all sections, left to right.
        widths: the number of loops of each section.

    Raises:
        PatternError: a loop leaves its section, two loops move to one place, or two loops that cross have one layer.
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
    """Return the loops with layer 0 where they cross no other loop, so that equal fabrics compare as equal."""
    if not any(loop.layer for loop in loops):
        return loops
    crossed = {place for cable in crossings(loops) for place in cable}
    return tuple(loop if place in crossed else Loop(twist=loop.twist) for place, loop in enumerate(loops))


def crossings(loops: Sequence[Loop]) -> list[range]:
    """Return the cables of a row: the smallest intervals of loops that are permuted among themselves."""
    found, start, reach = [], 0, -1
    for place, loop in enumerate(loops):
        reach = max(reach, place + loop.shift)
        if reach == place:
            if place > start:
                found.append(range(start, place + 1))
            start = place + 1
    return found
