# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a section of the published benchmark finds: figures beside published ones, curves, and rows of plain tables.

A figure has a published range, which is one value if both ends are equal. Its deviation is relative,

    deviation = (ours - the nearest end of the range) / |that end|, 0 inside the range

and the error of a section is the root of the mean square of the deviations of the figures that count.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

Sourcing = Literal["code", "page", "2nd", "derived"]
"""How sure a published value is: read in the source named (code, page), in a secondary text about it (2nd), or
arithmetic on other figures (derived)."""


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A quantity, published and ours."""

    quantity: str
    published: tuple[float, float]
    """The ends of the published range."""
    ours: float
    sure: Sourcing
    within: float = 0.0
    """Largest relative deviation that passes."""
    unit: str = ""
    counts: bool = True
    """Whether the figure counts in the error of its section."""

    @property
    def deviation(self) -> float:
        """Ours minus the nearest end of the range, over that end."""
        low, high = self.published
        end = min(max(self.ours, low), high)
        return (self.ours - end) / abs(end) if end else math.copysign(math.inf, self.ours) if self.ours else 0.0

    @property
    def passes(self) -> bool:
        """Whether ours is in the range or near enough."""
        return abs(self.deviation) <= self.within


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A sign, an order or a trend, published and ours."""

    quantity: str
    published: str
    ours: str
    passes: bool
    sure: Sourcing


@dataclass(frozen=True, kw_only=True)
class Curve:
    """A line of the picture of a section."""

    panel: str
    label: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    ours: bool = True
    """Whether it is ours; published curves are drawn in grey."""


@dataclass(frozen=True)
class Title:
    """The title of a table, by which the page names it."""

    text: str


Item: TypeAlias = Figure | Claim | Curve | Title | str | Sequence[object]
"""What a section yields; a text is a line, and a sequence is a row of a table, as ``benchmarks.table`` has them."""
Items: TypeAlias = Iterable[Item]


@dataclass(frozen=True, kw_only=True)
class Section:
    """A table of published measurements, or a check of the model."""

    name: str
    """Name on the command line and in the markers of the page: V1 to V11 for published tables."""
    title: str
    run: Callable[[], Items]
    """Makes what is kept."""
    accepted: str = ""
    """The error that the literature accepts, or the proposal for a pass."""
    verdict: str = ""
    """What is missed, and why."""
    picture: str = ""
    """Name of the picture in the folder of the pages; empty for none."""
    axes: tuple[str, str] = ("strain [%]", "tension [N/m]")
    draw: Callable[[Path], None] | None = None
    """Draws another picture than the curves, when the section runs."""


def error_of(items: Items) -> float | None:
    """Return the root of the mean square of the deviations that count; None if no figure counts."""
    found = [item.deviation for item in items if isinstance(item, Figure) and item.counts]
    return math.sqrt(sum(each**2 for each in found) / len(found)) if found else None


def passed(items: Items) -> tuple[int, int]:
    """Return how many figures and claims pass, and how many there are."""
    found = [item.passes for item in items if isinstance(item, Figure | Claim)]
    return sum(found), len(found)


KINDS: dict[str, Any] = {"figure": Figure, "claim": Claim, "curve": Curve}
"""Classes of the lines that are kept, by their keys."""


def kept(item: Item) -> dict[str, Any]:
    """Return the line of an item in the file of its section."""
    if isinstance(item, Title):
        return {"title": item.text}
    if isinstance(item, str):
        return {"text": item}
    for key, kind in KINDS.items():
        if isinstance(item, kind):
            return {key: asdict(item)}
    assert not isinstance(item, Figure | Claim | Curve)
    return {"row": [str(cell) for cell in item]}


def item_of(line: dict[str, Any]) -> Item:
    """Return the item of a line, the inverse of ``kept``."""
    ((key, value),) = line.items()
    if key == "title":
        return Title(value)
    if key in KINDS:
        sequences = {name: tuple(part) for name, part in value.items() if isinstance(part, list)}
        item: Item = KINDS[key](**value | sequences)
        return item
    plain: str | list[object] = value
    return plain


TITLES = ("quantity", "published", "source", "here", "off by", "")
"""Titles of a table of figures."""


def shown(item: Figure | Claim) -> list[str]:
    """Return the cells of a figure or a claim, under ``TITLES``."""
    mark = "pass" if item.passes else "**miss**"
    if isinstance(item, Claim):
        return [item.quantity, item.published, item.sure, item.ours, "", mark]
    low, high = item.published
    wanted = _number(low) if low == high else f"{_number(low)} to {_number(high)}"
    unit = f" {item.unit}" if item.unit else ""
    off = f"{100 * item.deviation:+.0f} %" if item.deviation else "0 %"
    return [item.quantity, wanted + unit, item.sure, _number(item.ours) + unit, off, mark]


def _number(value: float) -> str:
    """Return a number with three digits, and thousands without an exponent."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def cells_of(items: Items) -> list[str | Sequence[object]]:
    """Return the rows and texts of items, for ``benchmarks.table``; figures that follow one another are one table."""
    made: list[str | Sequence[object]] = []
    in_figures = False
    for item in (each for each in items if not isinstance(each, Curve)):
        figure = isinstance(item, Figure | Claim)
        if figure and not in_figures:
            made += ["", TITLES] if made else [TITLES]
        if in_figures and not figure:
            made.append("")
        in_figures = figure
        if isinstance(item, Figure | Claim):
            made.append(shown(item))
        elif isinstance(item, Title):
            made.append(f"### {item.text}")
        else:
            made.append(item)
    return made
