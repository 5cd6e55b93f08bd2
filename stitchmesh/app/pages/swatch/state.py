# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The user's settings on the page: one or two designs, and their look. The project keeps them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from stitchmesh.app.controls.field_panel import Field, Number, same_words
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.io.checked import check_table, check_value
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.resolve_pattern import Source, resolve_pattern
from stitchmesh.periodic.swatch_design import SwatchDesign, design_table, read_design

FIRST_PATTERN = "rib2x2"
"""Pattern of a new project; its two kinds of stitches show at once what relaxation does."""
NAMES = ("A", "B")
"""Names of the variants."""
COLOURINGS = ("yarn", "stitch", "row", "strain")
"""The choices of what the colours show."""
SHOWN = (12, 16)
"""Numbers of wales and courses that a new pattern shows, in whole repeats; such a piece is roughly square."""
MOST_TILES = 12
"""Largest number of repeats in one direction."""


@dataclass(frozen=True)
class Look:
    """The look of the fabric.

    Raises:
        ParameterError: a value is out of bounds.
    """

    columns: int = 3
    """Number of repeats side by side."""
    rows: int = 3
    """Number of repeats one above another."""
    colour_by: str = "yarn"
    """What the colours show."""
    blend: float = 0.7
    """Weight of the colours of stitches or rows; 0 leaves the colours of the yarns."""

    def __post_init__(self) -> None:
        if not (1 <= self.columns <= MOST_TILES and 1 <= self.rows <= MOST_TILES):
            raise ParameterError(f"tiles: got {self.columns} x {self.rows}; expected 1 to {MOST_TILES}")
        if self.colour_by not in COLOURINGS:
            raise ParameterError(f"colour by: got {self.colour_by!r}; expected one of {', '.join(COLOURINGS)}")
        if not 0.0 <= self.blend <= 1.0:
            raise ParameterError(f"blend: got {self.blend:g}; expected 0 to 1")

    def fitted(self, source: Source) -> Look:
        """Return the look with the number of repeats of a pattern that shows about ``SHOWN`` wales and courses."""
        counts = zip(SHOWN, repeat_shape(source), strict=True)
        columns, rows = (min(max(round(shown / own), 1), MOST_TILES) for shown, own in counts)
        return replace(self, columns=columns, rows=rows)


@dataclass(frozen=True)
class SwatchState:
    """All that the page shows."""

    designs: tuple[SwatchDesign, ...]
    """One design, or two designs to compare."""
    edited: int = 0
    """Number of the design that the chart and the dials change."""
    look: Look = Look()
    iterations: int = 20
    """Number of iterations from one frame to the next."""
    charts: tuple[str, ...] = ()
    """The text of the chart of each design, valid or not; an empty text stands for the text of its pattern."""

    def __post_init__(self) -> None:
        charts = (*self.charts, *[""] * len(self.designs))[: len(self.designs)]
        object.__setattr__(self, "charts", charts)

    @property
    def design(self) -> SwatchDesign:
        """The design that the chart and the dials change."""
        return self.designs[self.edited]

    def with_design(self, design: SwatchDesign) -> SwatchState:
        """Return the state with another design in place of the edited one."""
        designs = list(self.designs)
        designs[self.edited] = design
        return replace(self, designs=tuple(designs))

    def with_chart(self, text: str) -> SwatchState:
        """Return the state with another chart text for the edited design."""
        charts = list(self.charts)
        charts[self.edited] = text
        return replace(self, charts=tuple(charts))

    def compared(self, compare: bool) -> SwatchState:
        """Return the state with a second variant, a copy of the first, or with only the edited design."""
        if compare == (len(self.designs) == 2):
            return self
        count, chart = (2 if compare else 1), self.charts[self.edited]
        return replace(self, designs=(self.design,) * count, charts=(chart,) * count, edited=count - 1)


def is_knit(state: SwatchState) -> bool:
    """Return whether the edited design is a knit, whose stitches and rows can have colours."""
    return isinstance(state.design.pattern, Pattern)


def has_strength(state: SwatchState) -> bool:
    """Return whether the colours of stitches or rows cover the colours of the yarns."""
    return is_knit(state) and state.look.colour_by in ("stitch", "row")


LOOK_FIELDS = (
    Field("look.columns", "Copies across", "Copies of the repeat side by side; they cost no computation",
          Number(1, MOST_TILES, 1)),
    Field("look.rows", "Copies upwards", "Copies of the repeat one above another; they cost no computation",
          Number(1, MOST_TILES, 1)),
    Field("look.colour_by", "Colour by", "Colours of the yarns, of their stitches or rows, or of stretch",
          same_words(COLOURINGS), is_knit),
    Field("look.blend", "Strength", "How much these colours cover those of the yarns; 0 shows the yarns alone",
          Number(0.0, 1.0, 0.05, slider=True), has_strength),
)  # fmt: skip
"""Fields for the look of the fabric; the design decides which of them are visible."""


def repeat_shape(source: Source) -> tuple[int, int]:
    """Return the numbers of wales and courses of a repeat, or of warps and wefts."""
    if isinstance(source, Pattern):
        return source.width, source.height
    return len(source.warps), len(source.wefts)


def first_state() -> SwatchState:
    """Return the state of a new project."""
    source = resolve_pattern(FIRST_PATTERN)
    return SwatchState((SwatchDesign(source),), look=Look().fitted(source))


def state_table(state: SwatchState) -> dict[str, Any]:
    """Return the state as a table for JSON."""
    look = {"columns": state.look.columns, "rows": state.look.rows, "colour_by": state.look.colour_by,
            "blend": state.look.blend}  # fmt: skip
    designs = [design_table(design) for design in state.designs]
    charts = list(state.charts)
    return {
        "designs": designs, "charts": charts, "edited": state.edited, "look": look, "iterations": state.iterations,
    }  # fmt: skip


def read_state(table: Mapping[str, Any]) -> SwatchState:
    """Return the state from a table of ``state_table``; the state of a new project if the table is empty.

    Raises:
        ParameterError: a key is missing, or a value is of another type or out of bounds.
        PatternError: a text does not describe a pattern.
    """
    if not table:
        return first_state()
    designs = tuple(read_design(each) for each in check_value(table.get("designs"), list[dict[str, Any]]))
    edited = check_value(table.get("edited", 0), int)
    if not (1 <= len(designs) <= len(NAMES) and 0 <= edited < len(designs)):
        raise ParameterError(f"swatch: got {len(designs)} designs, number {edited} edited; expected 1 or 2 designs")
    iterations = min(max(check_value(table.get("iterations", 20), int), 1), 200)
    charts = tuple(check_value(table.get("charts", []), list[str]))
    return SwatchState(designs, edited, check_table(table.get("look", {}), Look), iterations, charts)


def swatch_patterns(table: Mapping[str, Any]) -> dict[str, Pattern]:
    """Return the patterns of the page, by the names under which other pages list them, without weaves.

    Args:
        table: a table of ``state_table``; an empty or damaged one gives no patterns.
    """
    try:
        designs = read_state(table).designs if table else ()
    except StitchMeshError:
        return {}  # The page itself reports the damage.
    knits = [design.pattern for design in designs if isinstance(design.pattern, Pattern)]
    return {f"swatch {number}: {pattern.name or 'own chart'}": pattern for number, pattern in enumerate(knits, start=1)}
