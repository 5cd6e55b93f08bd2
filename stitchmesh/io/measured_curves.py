# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Load-extension curves of a fabric, as a laboratory measures them, and the tables in which they stand.

A table is a file of comma-separated values. Its head names the columns, with their units in brackets:

    # length: 100 mm              (of the free swatch between the clamps, for an extension)
    # width: 50 mm                (of the swatch across the pull, for a load in newtons)
    direction,other,extension [mm],load [N]
    wale,free,2.5,0.011

| column | holds |
|---|---|
| direction | ``course`` or ``wale``; a line ``# direction: wale`` states it for all rows |
| other | ``free`` or ``held``, the size across the pull; free without such a column |
| strain | a ratio, or ``[%]``; an ``extension`` with a unit of length needs the length |
| load | ``[N/m]`` of width or another tension; a force needs the width |

Each direction and state of the size across makes one curve. A curve counts up to its largest strain: the rows after it
belong to unloading, and are left out.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import fspath
from typing import Any, Literal, get_args

import numpy as np

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, read_lines
from stitchmesh.mesh import FloatArray
from stitchmesh.yarn.quantities import FORCE, LENGTH, TENSION, in_cgs

Along = Literal["course", "wale"]
Across = Literal["free", "held"]

MOST_STRAIN = 9.0
"""Largest strain, as in a stretch test."""
LEAST_STRAIN = 1e-4
"""Rows of a smaller strain say nothing, because the free fabric has no tension."""
LARGEST = 1e12
"""Bound of a number of a table."""
LOADS = ("load", "tension", "force")
"""Names of the column of the load."""
HEAD = re.compile(r"\s*([a-zA-Z]+)\s*(?:[\[(](.*)[\])])?\s*")
"""A name, and a unit in brackets."""
FORM = "direction,strain [%],load [N/m]"
"""The head of a usual table, for messages."""


@dataclass(frozen=True, eq=False)
class MeasuredCurve:
    """The load-extension curve of a fabric that is drawn along its courses or its wales.

    Raises:
        ParameterError: there is no such direction or state, the arrays differ in length, there is no positive strain,
            strains do not rise, or a number is out of bounds.
    """

    direction: Along
    """Direction of the pull."""
    strain: FloatArray
    """Extension over the length of the free fabric, rising, shape (n,)."""
    tension: FloatArray
    """Force over the width of the free fabric [dyn/cm], shape (n,); 1000 dyn/cm are 1 N/m."""
    other: Across = "free"
    """Whether the size across the pull is free, or held as in the free fabric."""

    def __post_init__(self) -> None:
        if self.direction not in get_args(Along) or self.other not in get_args(Across):
            found = f"got {self.direction!r} with the other size {self.other!r}"
            raise ParameterError(f"measured curve: {found}; expected course or wale, and free or held")
        what = f"measured curve along the {self.direction}s"
        for name in ("strain", "tension"):
            values = np.array(getattr(self, name), dtype=np.float64)
            if values.ndim != 1 or not np.isfinite(values).all():
                raise ParameterError(f"{what}: got {name}s that are no list of finite numbers; expected one")
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        if len(self.strain) != len(self.tension):
            found = f"got {len(self.strain)} strains and {len(self.tension)} tensions"
            raise ParameterError(f"{what}: {found}; expected as many of both")
        if len(self.strain) == 0 or self.strain[-1] < LEAST_STRAIN:
            raise ParameterError(f"{what}: got no strain above {LEAST_STRAIN:g}; expected at least one")
        if self.strain[-1] > MOST_STRAIN or (np.diff(self.strain) <= 0.0).any():
            found = f"got strains up to {self.strain[-1]:g}"
            raise ParameterError(f"{what}: {found}; expected ratios that rise, up to {MOST_STRAIN:g}")
        if not self.tension.max() > 0.0:
            raise ParameterError(f"{what}: got no positive tension; expected the force that draws the fabric")

    def __repr__(self) -> str:
        """Return one line: the direction, the number of rows, and the ends."""
        end = f"{100 * self.strain[-1]:.3g} % and {self.tension[-1]:.3g} dyn/cm"
        return f"MeasuredCurve({self.direction}, {len(self.strain)} rows to {end}, the other {self.other})"

    def thinned(self, count: int) -> MeasuredCurve:
        """Return a curve of at most ``count`` strains above zero, at equal distances if there are more rows.

        The tension at a strain is the value of the parabola that fits the rows within the distance best. A parabola
        keeps the bend of the curve, and smooths its noise.
        """
        counts = self.strain >= LEAST_STRAIN
        strain, tension = self.strain[counts], self.tension[counts]
        if len(strain) > count:
            wanted = np.linspace(strain[-1] / count, strain[-1], count)
            tension = np.array([_local_value(self.strain, self.tension, each, wanted[0]) for each in wanted])
            strain = wanted
        return MeasuredCurve(self.direction, strain, tension, self.other)


def _local_value(strain: FloatArray, tension: FloatArray, place: float, reach: float) -> float:
    """Return the value at a place of the parabola that fits the rows within ``reach`` best."""
    near = np.abs(strain - place) <= reach * (1.0 + 1e-9)
    if near.sum() < 4:
        return float(np.interp(place, strain, tension))
    return float(np.polynomial.Polynomial.fit(strain[near], tension[near], 2)(place))


def read_measured_curves(path: FilePath) -> tuple[MeasuredCurve, ...]:
    """Read the curves of a table.

    Raises:
        FileError: the file cannot be read, a column is missing or has no unit that measures it, or a row is malformed.
    """
    name = fspath(path)
    stated, rows = _stated_and_rows(name, read_lines(path))
    if len(rows) < 2:
        raise FileError(f"{name}: has no rows of numbers; expected a head such as {FORM}, and rows below it")
    try:
        columns = _Columns.of(rows[0][1], stated)
    except ParameterError as error:
        raise FileError(f"{name}: {error}") from error
    found: dict[tuple[Along, Across], list[tuple[float, float]]] = {}
    for number, row in rows[1:]:
        try:
            key, strain, tension = columns.point(row)
        except ParameterError as error:
            raise FileError(f"{name}: line {number}: {error}") from error
        found.setdefault(key, []).append((strain, tension))
    try:
        return tuple(_loading(direction, other, rows) for (direction, other), rows in found.items())
    except ParameterError as error:
        raise FileError(f"{name}: {error}") from error


def _stated_and_rows(name: str, lines: Sequence[str]) -> tuple[dict[str, str], list[tuple[int, list[str]]]]:
    """Return what the lines ``# key: value`` state, and the other lines as cells with their numbers."""
    stated, rows = dict[str, str](), list[tuple[int, list[str]]]()
    for number, line in enumerate(lines, start=1):
        text = line.strip()
        if text.startswith("#"):
            key, colon, value = text.lstrip("# ").partition(":")
            if colon:
                stated[key.strip().lower()] = value.strip()
        elif text:
            try:
                rows += [(number, cells) for cells in csv.reader([text])]
            except csv.Error as error:
                raise FileError(f"{name}: line {number}: {error}; expected comma-separated values") from error
    return stated, rows


@dataclass(frozen=True)
class _Columns:
    """Where the values of a row stand, and their factors to ratios and dyn/cm."""

    strain: int
    load: int
    strain_factor: float
    load_factor: float
    direction: int | Along
    """The column of the direction, or the direction of all rows."""
    other: int | Across
    """The column of the state across, or the state of all rows."""

    @classmethod
    def of(cls, head: Sequence[str], stated: Mapping[str, str]) -> _Columns:
        """Read the head of a table.

        Raises:
            ParameterError: a column is missing, a unit does not measure it, or a length that the unit needs is missing.
        """
        columns = dict[str, tuple[int, str | None]]()
        for place, cell in enumerate(head):
            match = HEAD.fullmatch(cell)
            if match:
                columns.setdefault(match[1].lower(), (place, match[2]))
        load = next((word for word in LOADS if word in columns), None)
        extension = next((word for word in ("strain", "extension") if word in columns), None)
        if load is None or extension is None:
            raise ParameterError(f"head: got {','.join(head)[:60]!r}; expected columns such as {FORM}")
        return cls(
            columns[extension][0], columns[load][0], _strain_factor(extension, columns[extension][1], stated),
            _load_factor(load, columns[load][1], stated), _column_or_word(columns, stated, "direction"),
            _column_or_word(columns, stated, "other"),
        )  # fmt: skip

    def point(self, row: Sequence[str]) -> tuple[tuple[Along, Across], float, float]:
        """Return the direction and the state across, the strain, and the tension [dyn/cm] of a row.

        Raises:
            ParameterError: a cell is missing or malformed.
        """
        direction = _word(_cell(row, self.direction) if isinstance(self.direction, int) else self.direction, Along)
        other = _word(_cell(row, self.other) if isinstance(self.other, int) else self.other, Across)
        strain = _number(_cell(row, self.strain)) * self.strain_factor
        return (direction, other), strain, _number(_cell(row, self.load)) * self.load_factor


def _column_or_word(columns: Mapping[str, tuple[int, str | None]], stated: Mapping[str, str], name: str) -> Any:
    """Return the column of a name, or the word that the file states for all rows."""
    if name in columns:
        return columns[name][0]
    if name == "other":
        return _word(stated.get(name, "free"), Across)
    if name not in stated:
        raise ParameterError("direction: got none; expected a column, or a line such as # direction: wale")
    return _word(stated[name], Along)


def _word(text: str, kind: Any) -> Any:
    if text.strip().lower() not in get_args(kind):
        raise ParameterError(f"got {text[:40]!r}; expected {' or '.join(get_args(kind))}")
    return text.strip().lower()


def _cell(row: Sequence[str], place: int) -> str:
    if place >= len(row):
        raise ParameterError(f"got {len(row)} cells; expected a value in column {place + 1}")
    return row[place]


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not abs(value) < LARGEST:
        raise ParameterError(f"got {text[:40]!r}; expected a number of a size below {LARGEST:g}")
    return value


def _strain_factor(name: str, unit: str | None, stated: Mapping[str, str]) -> float:
    """Return what turns a number of the column into a ratio."""
    if unit is None or unit.strip() == "%":
        if name == "extension" and unit is None:
            raise ParameterError("extension: got no unit; expected one in the head, such as extension [mm]")
        return 1.0 if unit is None else 0.01
    return _unit(unit, LENGTH, name) / _stated_length("length", unit, stated)


def _load_factor(name: str, unit: str | None, stated: Mapping[str, str]) -> float:
    """Return what turns a number of the column into a tension [dyn/cm]."""
    if unit is None:
        raise ParameterError(f"{name}: got no unit; expected one in the head, such as {name} [N/m] or {name} [N]")
    if "/" in unit:
        return _unit(unit, TENSION, name)
    return _unit(unit, FORCE, name) / _stated_length("width", unit, stated)


def _unit(unit: str, kind: str, name: str) -> float:
    return in_cgs(f"1 {unit.strip()}", kind, f"unit of {name}")


def _stated_length(name: str, unit: str, stated: Mapping[str, str]) -> float:
    if name not in stated:
        raise ParameterError(f"{name}: got none for values in {unit}; expected a line such as # {name}: 50 mm")
    return in_cgs(stated[name], LENGTH, name)


def _loading(direction: Along, other: Across, rows: Sequence[tuple[float, float]]) -> MeasuredCurve:
    """Return the rows up to the largest strain, without rows that go back; equal strains have their mean tension."""
    end = max(range(len(rows)), key=lambda place: (rows[place][0], place))
    gathered: dict[float, list[float]] = {}
    most = -math.inf
    for strain, tension in rows[: end + 1]:
        if strain >= most:
            gathered.setdefault(strain, []).append(tension)
            most = strain
    tensions = [sum(each) / len(each) for each in gathered.values()]
    return MeasuredCurve(direction, np.array(list(gathered)), np.array(tensions), other)


def write_measured_curves(path: FilePath, curves: Sequence[MeasuredCurve]) -> None:
    """Write curves as a table that ``read_measured_curves`` reads, with strains [%] and loads [N/m].

    Args:
        path: a ``.csv`` file; missing folders are made.
        curves: the curves, no two of one direction and state across.

    Raises:
        FileError: the file cannot be written.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["direction", "other", "strain [%]", "load [N/m]"])
    for curve in curves:
        for strain, tension in zip(curve.strain.tolist(), curve.tension.tolist(), strict=True):
            table.writerow([curve.direction, curve.other, repr(100.0 * strain), repr(1e-3 * tension)])
    write_text(path, text.getvalue())
