# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a measure yields, and its form on the terminal: tables of Markdown, which pages of the documentation take over.

A measure yields texts, and rows of cells. The first row after a text holds the titles of a table. A text
is a line of its own, and ends the table before it; an empty text ends a table without a line.
"""

from __future__ import annotations

import sys
from collections.abc import Generator, Sequence

Rows = Generator[str | Sequence[object], None, int | None]
"""Rows and texts of a measure; it may return an exit status, which is 0 if it returns none."""


def show(measured: Rows) -> int:
    """Print what a measure yields as soon as it is known, and return the exit status."""
    in_table = False
    while True:
        try:
            item = next(measured)
        except StopIteration as end:
            return int(end.value or 0)
        if isinstance(item, str):
            print(f"\n{item}" if in_table and item else item, flush=True)
            in_table = False
            continue
        print(row(item), flush=True)
        if not in_table:
            print("|" + "---|" * len(item), flush=True)
        in_table = True


def row(cells: Sequence[object]) -> str:
    """Return a row of a table."""
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def note(text: str) -> None:
    """Print how far a measure has come; what it finds, it yields."""
    print(text, file=sys.stderr, flush=True)
