# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Measured tables: what relaxations cost, and how wrong their spacings are, for each device.

``benchmarks/run.py budget-tables`` writes ``tables.json`` beside this file, and says how each figure is measured.
"""

from __future__ import annotations

import functools
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from stitchmesh.errors import FileError

TABLES = Path(__file__).parent / "tables.json"
"""The file of the package."""
Kind = Literal["free cell", "given cell", "garment"]
"""What is relaxed: a swatch that finds its size, a swatch of a given size, or yarns that keep the shape of a fabric."""
Processor = Literal["cpu", "cuda"]


@dataclass(frozen=True, kw_only=True)
class MeasuredRelaxation:
    """One relaxation."""

    kind: Kind
    """What was relaxed."""
    scene: str
    """Name of the pattern or of the mesh."""
    setting: str
    """Name of the setting (``settings``)."""
    stitches: int
    """Number of stitches, or of crossings of a weave."""
    points: int
    """Number of control points."""
    iterations: int
    """Number of iterations."""
    seconds: float
    """Time with loaded kernels, from the pattern or from the generated yarns to the result [s]."""
    error: float | None
    """Relative error of the spacing; None if there is no true state to compare with."""
    converged: bool
    """Whether the relaxation came to rest."""


@dataclass(frozen=True, kw_only=True)
class Table:
    """The measurements on one device."""

    device: str
    """Name of the device, with its number of threads if it is a CPU."""
    processor: Processor
    """Kind of the device."""
    date: str
    """Day of the measurements."""
    version: str
    """Version of the program."""
    command: str
    """Command that measured."""
    pace: tuple[float, float]
    """Times of the small and of the large scene of ``calibration`` [s]."""
    measurements: tuple[MeasuredRelaxation, ...]
    """The relaxations."""

    def of(self, kind: Kind) -> list[MeasuredRelaxation]:
        """Return the measurements of one kind."""
        return [one for one in self.measurements if one.kind == kind]

    @property
    def title(self) -> str:
        """Return the device and the day, for messages."""
        return f"{self.device}, {self.date}"


@functools.cache
def read_tables(path: Path = TABLES) -> tuple[Table, ...]:
    """Read the tables of all devices.

    Raises:
        FileError: the file cannot be read, or is malformed.
    """
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
        return tuple(_table(entry) for entry in entries)
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise FileError(f"{path}: tables of budgets cannot be read ({error}); install the program again") from error


def _table(entry: dict[str, Any]) -> Table:
    rows = [dict(zip(entry["columns"], row, strict=True)) for row in entry["measurements"]]
    if not all(row["kind"] in get_args(Kind) for row in rows):
        raise ValueError(f"a kind is none of {', '.join(get_args(Kind))}")
    own = {name: value for name, value in entry.items() if name not in ("columns", "measurements", "pace")}
    return Table(**own, pace=tuple(entry["pace"]), measurements=tuple(MeasuredRelaxation(**row) for row in rows))
