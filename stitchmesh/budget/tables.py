# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Measured tables: what relaxations cost, and how wrong their spacings are, for each device.

``benchmarks/run.py budget-tables`` writes ``tables.json`` beside this file, and says how each figure is measured.

The table says what time and what error to expect from a setting on a scene.

If the table has the scene by name, its own measurements are expected again. Any other scene is compared with the
measured scenes of its kind that are nearest to its size. Their times are scaled by the numbers of stitches. The
expected time is the median of these times, and the allowed time is the largest of them. The expected error is the
largest error of the kind, because the error of an unknown pattern does not follow from its size. A setting that came to
rest in few of the scenes (``IN_MOST``) is left out, because these few would be the easy scenes.
"""

from __future__ import annotations

import functools
import json
import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from stitchmesh.errors import FileError

TABLES = Path(__file__).parent / "tables.json"
"""The file with the tables."""
Kind = Literal["free cell", "given cell", "garment"]
"""What is relaxed: a swatch that finds its size, a swatch of a given size, or yarns that keep the shape of a fabric."""
Processor = Literal["cpu", "cuda"]
NEAREST = 8
"""Number of measured scenes with which a new scene is compared."""
IN_MOST = 0.75
"""A setting must be at rest, with a known error, in this part of the scenes."""


@dataclass(frozen=True, kw_only=True)
class MeasuredRelaxation:
    """One relaxation."""

    kind: Kind
    """What was relaxed."""
    scene: str
    """Name of the pattern or of the mesh."""
    setting: str
    """Name of the setting (``plan``)."""
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
    """Version of the program that was measured."""
    command: str
    """Command that made the measurements."""
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


@dataclass(frozen=True, kw_only=True)
class BudgetScene:
    """What is to be relaxed."""

    kind: Kind
    """Kind of the scene."""
    stitches: int
    """Number of stitches, or of crossings of a weave."""
    name: str = ""
    """Name of the pattern or of the mesh, if there is one."""
    relaxations: int = 1
    """Number of relaxations, one after another."""


@dataclass(frozen=True, kw_only=True)
class Expectation:
    """Time and error of a setting on a scene."""

    setting: str
    """Name of the setting."""
    seconds: float
    """Expected time [s]."""
    most_seconds: float
    """Allowed time [s]."""
    error: float
    """Relative error of the spacing."""


def expectations(table: Table, scene: BudgetScene, slowness: float = 1.0) -> list[Expectation]:
    """Return what to expect from each setting that came to rest in a table, the cheapest setting first.

    Args:
        table: the table.
        scene: the scene.
        slowness: time of this device over the time of the table's device.
    """
    rows = [row for row in table.of(scene.kind) if row.converged]
    rows = [row for row in rows if row.scene == scene.name and row.error is not None] or rows
    needed = IN_MOST * len({row.scene for row in rows if row.error is not None})
    found = []
    for name in dict.fromkeys(row.setting for row in rows):
        own = [row for row in rows if row.setting == name]
        if sum(row.error is not None for row in own) >= max(needed, 1):
            found.append(_expectation(name, own, scene, slowness))
    return sorted(found, key=lambda one: one.most_seconds)


def _expectation(setting: str, rows: Sequence[MeasuredRelaxation], scene: BudgetScene, slowness: float) -> Expectation:
    errors = [row.error for row in rows if row.error is not None]
    near = sorted(rows, key=lambda row: abs(math.log(row.stitches / scene.stitches)))[:NEAREST]
    slowness *= scene.relaxations
    seconds = [slowness * row.seconds * scene.stitches / row.stitches for row in near]
    middle, most = statistics.median(seconds), max(seconds)
    return Expectation(setting=setting, seconds=middle, most_seconds=most, error=max(errors))
