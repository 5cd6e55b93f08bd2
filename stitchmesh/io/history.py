# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The history of a relaxation (residual and energies against iterations) as a file of comma-separated values."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from os import fspath
from typing import TypedDict

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, read_lines

NUMBERS = ["iteration", "seconds", "residual"]
"""First columns of a table."""
UNIT = "_erg"
"""End of the names of the columns of energies."""


class HistoryEntry(TypedDict):
    """One assessment of a relaxation."""

    iteration: int
    """Number of iterations before the assessment."""
    seconds: float
    """Time since the start [s]."""
    residual: float
    """Relative force residual."""
    energies: Mapping[str, float]
    """Energy of each term [erg]."""


def energy_terms(history: Sequence[HistoryEntry]) -> list[str]:
    """Return the names of all energy terms in a history, in the order of their first entries."""
    return list(dict.fromkeys(term for entry in history for term in entry["energies"]))


def write_history(path: FilePath, history: Sequence[HistoryEntry]) -> None:
    """Write a history as a table: iteration, seconds, residual and one column for each energy term [erg].

    Numbers are written with all digits that are needed to read the same number again. The cell of a term that an entry
    does not contain is empty.

    Args:
        path: a ``.csv`` file; missing folders are made.
        history: the entries; without entries, only the header of the table is written.

    Raises:
        FileError: the file cannot be written.
    """
    terms = energy_terms(history)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow([*NUMBERS, *(f"{term}{UNIT}" for term in terms)])
    for entry in history:
        energies = [entry["energies"].get(term, "") for term in terms]
        table.writerow([entry["iteration"], entry["seconds"], entry["residual"], *energies])
    write_text(path, text.getvalue())


def read_history(path: FilePath) -> list[HistoryEntry]:
    """Read a history that ``write_history`` wrote.

    Raises:
        FileError: the file cannot be read, or a line is not a line of a history.
    """
    try:
        names, *rows = csv.reader(read_lines(path))
    except (csv.Error, ValueError) as error:
        raise FileError(f"{fspath(path)}: is no table of comma-separated values ({error})") from error
    if names[:3] != NUMBERS or not all(name.endswith(UNIT) for name in names[3:]):
        found = f"got columns {', '.join(names[:4])}"
        raise FileError(f"{fspath(path)}: {found}; expected the convergence of a relaxation: {', '.join(NUMBERS)} ...")
    return [_entry(f"{fspath(path)}, line {number}", names, row) for number, row in enumerate(rows, 2)]


def _entry(place: str, names: list[str], row: list[str]) -> HistoryEntry:
    try:
        energies = {name.removesuffix(UNIT): float(text) for name, text in zip(names[3:], row[3:], strict=True) if text}
        return HistoryEntry(iteration=int(row[0]), seconds=float(row[1]), residual=float(row[2]), energies=energies)
    except (ValueError, IndexError) as error:
        raise FileError(f"{place}: got {','.join(row)[:60]!r}; expected {len(names)} numbers") from error
