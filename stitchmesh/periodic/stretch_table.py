# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A stretch curve as a table of comma-separated values, with one line for each state."""

from __future__ import annotations

import csv
import io
from dataclasses import asdict

from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath
from stitchmesh.periodic.stretch import NEWTONS_PER_METRE, StretchCurve

UNITS = {"width": "cm", "height": "cm", "course_tension": "dyn_per_cm", "wale_tension": "dyn_per_cm",
         "energy": "erg_per_cm2"}  # fmt: skip
"""Units of the columns that have a unit."""
NEWTONS = ("course_tension", "wale_tension")
"""Columns that are also written in N/m."""


def write_stretch(path: FilePath, curve: StretchCurve) -> None:
    """Write a stretch curve as a table.

    The columns are the fields of ``StretchPoint`` with their units, the tensions in N/m, and whether the fabric snapped
    to another branch before the state.

    Args:
        path: a ``.csv`` file; missing folders are made.
        curve: the result of a stretch test.

    Raises:
        FileError: the file cannot be written.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    rows = [asdict(point) for point in curve.points]
    titles = [f"{name}_{UNITS[name]}" if name in UNITS else name for name in rows[0]]
    table.writerow([*titles, *(f"{name}_newton_per_metre" for name in NEWTONS), "snapped"])
    for number, row in enumerate(rows):
        newtons = [row[name] * NEWTONS_PER_METRE for name in NEWTONS]
        table.writerow([*row.values(), *newtons, number in curve.snaps])
    write_text(path, text.getvalue())
