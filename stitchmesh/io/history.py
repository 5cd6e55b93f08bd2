# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How a relaxation went, entry by entry, as comma-separated values."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from typing import TypedDict

from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath


class HistoryEntry(TypedDict):
    """What was known of a relaxation after some iterations."""

    iteration: int
    """Iterations done."""
    seconds: float
    """Time since the start [s]."""
    residual: float
    """Relative force residual."""
    energies: Mapping[str, float]
    """Energy of each term [erg]."""


def energy_terms(history: Sequence[HistoryEntry]) -> list[str]:
    """Names of the energy terms that occur, in the order in which they first do."""
    return list(dict.fromkeys(term for entry in history for term in entry["energies"]))


def write_history(path: FilePath, history: Sequence[HistoryEntry]) -> None:
    """Write a history as a table: iteration, seconds, residual and one column for each energy term.

    Numbers are written so that they read back the same. A term that an entry lacks leaves its place empty.

    Args:
        path: a ``.csv`` file; missing folders are made.
        history: the entries; a table without rows where there are none.

    Raises:
        FileError: the file cannot be written.
    """
    terms = energy_terms(history)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["iteration", "seconds", "residual", *(f"{term}_erg" for term in terms)])
    for entry in history:
        energies = [entry["energies"].get(term, "") for term in terms]
        table.writerow([entry["iteration"], entry["seconds"], entry["residual"], *energies])
    write_text(path, text.getvalue())
