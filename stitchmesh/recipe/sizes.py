# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sizes of a garment: a table of the user, or standard sizes of bodies.

A table is a CSV file. Its first column holds the names of the sizes, and each further column a measure with its unit:

    size,chest [cm],length [in]
    S,92,24
    M,100,24.5

Standard sizes (``body_sizes.csv``) are measures of bodies without ease, in centimetres. The tables ``women``, ``men``
and ``children`` hold what the standards and guidelines of the Craft Yarn Council state as body measurements, in inches
there: ``chest`` is the middle of the range of a size, and ``sleeve length`` the arm length to the underarm. All are
rounded to half a centimetre. ``heads`` and ``feet`` are not from these tables, but round figures: the heads of babies
and toddlers are near the medians of the WHO's growth standards at 6 and 24 months, and those of older children and of
adults, and all feet, are usual ones in shops. A cell is empty where a table does not state a measure.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import fspath
from pathlib import Path

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.hand_knitting.sizes import MOST_SIZES, check_size_name
from stitchmesh.io.contents import FilePath, read_lines
from stitchmesh.io.units import CENTIMETRES

BODY_SIZES = Path(__file__).parent / "body_sizes.csv"
"""The file of the standard sizes."""
TABLE = ".csv"
"""Suffix of a table of sizes."""
UNITS = {**CENTIMETRES, "in": CENTIMETRES["inch"]}
"""Centimetres in each unit of a table."""
SHORTEST, LONGEST = 1.0, 1000.0
"""Bounds of a measure [cm]."""
_HEAD = re.compile(r"\s*([^\[\]]+?)\s*(?:\[\s*([^\[\]]*?)\s*\]|\(\s*([^()]*?)\s*\))?\s*")
_EASE = re.compile(r"\s*([^=]+?)\s*=\s*([-+]?[0-9.]+)\s*(%|[a-z]*)\s*")


@dataclass(frozen=True)
class GarmentSize:
    """One size of a garment.

    Raises:
        ParameterError: the name is not possible, there is no measure, or a measure is out of bounds.
    """

    name: str
    """Name, such as ``M``."""
    measures: Mapping[str, float]
    """Length of each measure [cm], such as ``chest``."""

    def __post_init__(self) -> None:
        check_size_name(self.name)
        if not self.measures:
            raise ParameterError(f"size {self.name}: got no measure; expected at least one, such as chest [cm]")
        for measure, value in self.measures.items():
            if not (isinstance(value, int | float) and math.isfinite(value) and SHORTEST <= value <= LONGEST):
                found = f"{value:g} cm" if isinstance(value, int | float) else repr(value)
                raise ParameterError(
                    f"size {self.name}: {measure}: got {found}; expected {SHORTEST:g} to {LONGEST:g} cm"
                )


@dataclass(frozen=True)
class Ease:
    """By how much a garment is larger than the body, or smaller."""

    measure: str
    """Name of the measure."""
    length: float = 0.0
    """Addition [cm]."""
    part: float = 0.0
    """Addition as a part of the measure."""

    def added(self, size: GarmentSize) -> GarmentSize:
        """Return a size with the ease."""
        values = dict(size.measures)
        if self.measure in values:
            values[self.measure] = values[self.measure] * (1.0 + self.part) + self.length
        return GarmentSize(size.name, values)


def read_sizes(path: FilePath) -> tuple[GarmentSize, ...]:
    """Read a table of sizes from a CSV file.

    Raises:
        FileError: the file cannot be read, a column has no unit or an unknown one, a value is no length, or a size or a
            column occurs twice; the message names the line.
    """
    rows = _rows(path)
    name = fspath(path)
    measures = [_measure(cell, name) for cell in rows[0][1][1:]]
    titles = [title for title, _ in measures]
    twice = next((title for title in titles if titles.count(title) > 1), None)
    if twice is not None or not titles:
        found = f"the column {twice!r} twice" if titles else "no measures"
        raise FileError(f"{name}: line {rows[0][0]}: got {found}; expected a head such as 'size,chest [cm]'")
    sizes: list[GarmentSize] = []
    for number, cells in rows[1:]:
        where = f"{name}: line {number}"
        if len(cells) != len(titles) + 1:
            raise FileError(f"{where}: got {len(cells)} cells; expected {len(titles) + 1} as in the head")
        values = {
            title: _length(cell, centimetres, f"{where}: {title}")
            for (title, centimetres), cell in zip(measures, cells[1:], strict=True)
        }
        try:
            sizes.append(GarmentSize(cells[0].strip(), values))
        except ParameterError as error:
            raise FileError(f"{where}: {error}") from error
    try:
        return checked_sizes(sizes)
    except ParameterError as error:
        raise FileError(f"{name}: {error}") from error


def checked_sizes(sizes: Sequence[GarmentSize]) -> tuple[GarmentSize, ...]:
    """Return sizes that can stand in one text.

    Raises:
        ParameterError: there is no size, there are too many, two have one name, or their measures differ.
    """
    if not 1 <= len(sizes) <= MOST_SIZES:
        raise ParameterError(f"sizes: got {len(sizes)}; expected 1 to {MOST_SIZES}")
    names = [size.name for size in sizes]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ParameterError(f"size {twice}: occurs twice; expected each name once")
    for size in sizes[1:]:
        if set(size.measures) != set(sizes[0].measures):
            both = f"{', '.join(size.measures)}, but size {names[0]} has {', '.join(sizes[0].measures)}"
            raise ParameterError(f"size {size.name}: has {both}; expected the same measures for all sizes")
    return tuple(sizes)


def standard_sizes(text: str, measures: Sequence[str]) -> tuple[GarmentSize, ...]:
    """Return standard sizes of bodies, such as ``women:S,M,L``; without names, all that have the measures.

    Args:
        text: name of a table, and names of sizes after a colon.
        measures: the measures that are taken; others of the table are left out.

    Raises:
        ParameterError: there is no such table or size, or the table states none of the measures for a size.
    """
    (_, head), *lines = _rows(BODY_SIZES)
    titles = [_measure(cell, BODY_SIZES.name)[0] for cell in head[2:]]
    tables: dict[str, dict[str, dict[str, float]]] = {}
    for _, (table, size, *cells) in lines:
        values = {title: float(cell) for title, cell in zip(titles, cells, strict=True) if cell and title in measures}
        tables.setdefault(table, {})[size] = values
    name, _, chosen = text.partition(":")
    if name not in tables:
        known_tables = ", ".join(tables)
        raise ParameterError(f"sizes {name[:60]!r}: is no table; expected a file such as sizes.csv, or {known_tables}")
    known = tables[name]
    names = [part.strip() for part in chosen.split(",")] if chosen else [size for size in known if known[size]]
    for size in names:
        if size not in known:
            raise ParameterError(f"size {size[:40]!r}: is not in the table {name}; expected one of {', '.join(known)}")
    common = [title for title in titles if names and all(title in known[size] for size in names)]
    if not common:
        raise ParameterError(
            f"sizes {text[:60]!r}: the table states none of the measures of this garment ({', '.join(measures)}) for "
            "all these sizes; write your own table, such as 'size,chest [cm]'"
        )
    return checked_sizes([GarmentSize(size, {title: known[size][title] for title in common}) for size in names])


def names_of_sizes_in(sizes: FilePath) -> tuple[str, ...]:
    """Return the names of the sizes of a table, or of all standard sizes that a text such as ``women`` can mean.

    Raises:
        FileError, ParameterError: as for ``read_sizes`` and ``standard_sizes``.
    """
    name = fspath(sizes)
    if name.lower().endswith(TABLE):
        return tuple(size.name for size in read_sizes(sizes))
    titles = [_measure(cell, BODY_SIZES.name)[0] for cell in _rows(BODY_SIZES)[0][1][2:]]
    return tuple(size.name for size in standard_sizes(name, titles))


def parse_ease(text: str) -> Ease:
    """Parse an ease as a user writes it: ``chest=8`` [cm], ``chest=3in`` or ``head=-6%``.

    Raises:
        ParameterError: the text has another form.
    """
    match = _EASE.fullmatch(text.lower())
    try:
        value = float(match[2]) if match else math.nan
    except ValueError:
        value = math.nan
    unit = (match[3] or "cm") if match else ""
    if match is None or not math.isfinite(value) or unit not in (*UNITS, "%"):
        raise ParameterError(f"ease: got {text[:60]!r}; expected a measure and a length or a part: chest=8, head=-6%")
    return Ease(match[1], part=value / 100.0) if unit == "%" else Ease(match[1], value * UNITS[unit])


def _rows(path: FilePath) -> list[tuple[int, list[str]]]:
    """Return the cells of each line that is not empty, with the number of the line, after the check of its first."""
    name = fspath(path)
    try:
        lines = list(csv.reader(read_lines(path)))
    except csv.Error as error:
        raise FileError(f"{name}: {error}; expected a table such as 'size,chest [cm]'") from error
    rows = [(number, cells) for number, cells in enumerate(lines, start=1) if any(cell.strip() for cell in cells)]
    if len(rows) < 2:
        raise FileError(f"{name}: got {len(rows)} lines; expected a head such as 'size,chest [cm]', and sizes below")
    return rows


def _measure(cell: str, name: str) -> tuple[str, float]:
    """Return the measure of a column, and the centimetres in its unit."""
    match = _HEAD.fullmatch(cell)
    unit = (match[2] or match[3] or "") if match else ""
    if match is None or unit.lower() not in UNITS:
        found = f"the unit {unit[:20]!r}" if unit else "no unit"
        units = ", ".join(UNITS)
        raise FileError(f"{name}: column {cell.strip()[:40]!r}: has {found}; expected one of {units}: 'chest [cm]'")
    return " ".join(match[1].lower().replace("_", " ").replace("-", " ").split()), UNITS[unit.lower()]


def _length(cell: str, centimetres: float, where: str) -> float:
    try:
        return float(cell) * centimetres
    except ValueError:
        raise FileError(f"{where}: got {cell[:40]!r}; expected a length, such as 96") from None
