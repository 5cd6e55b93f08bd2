# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tables by which a budget chooses: time and error of each setting on swatches and garments, for this device.

Scenes that are measured replace those of the table of the device; all others stay. Without ``--tables`` the
file is that of the package, ``stitchmesh/budget/tables.json``. Each time is that of the whole function (``swatch``, or
``relax_yarns`` for a garment) with loaded kernels. Errors of the spacing are relative to the true rest:

- a free cell: the periods of the sampling of ``reference``, relaxed further to a residual and a remaining change of
  ``TRUE``. The error is the larger one of the two periods.
- a cell of a given size: its periods have no error. The error is the rms distance of corresponding places across the
  yarn to those of the true rest, over the wale spacing.
- a garment: its spacings in the true rest of the sampling of ``reference``, where the garment is small enough for one
  (``MOST_STITCHES``); a larger one has a time and no error.

The file is written after each scene; no further row begins after ``--most-seconds``.
"""

from __future__ import annotations

import datetime
import json
import re
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

import stitchmesh as sm
from benchmarks.measures.rest.tradeoff import difference
from benchmarks.scenes.garments import Garment
from benchmarks.table import Rows, note
from benchmarks.timing import LOADING, relaxed
from stitchmesh.budget.calibration import calibrate, device_title
from stitchmesh.budget.plan import SETTINGS
from stitchmesh.budget.tables import TABLES, Kind, MeasuredRelaxation, Table, read_tables
from stitchmesh.compute.device import device_named
from stitchmesh.errors import StitchMeshError
from stitchmesh.periodic.resolve_pattern import resolve_pattern, stitches_of
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.run import QUIET
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.state_difference import loops_of_fabric, places_of

PATTERNS = (
    "stockinette", "garter", "rib1x1", "seed", "rib2x2", "moss", "linen-stitch", "twisted-rib", "half-cardigan",
    "slip-stitch-rib", "rib3x3", "slip-stitch-honeycomb", "cartridge-belt-rib", "checks", "eyelet-lace", "plain",
)  # fmt: skip
"""Patterns and weaves, from small to large."""
GIVEN = ("stockinette", "garter", "rib2x2", "moss", "checks", "plain")
"""Patterns of cells of a given size."""
GARMENTS = ("swatch.obj:1.6", "tea_cozy.obj:1.6", "hat.obj:1.2", "tea_cozy.obj:0.8", "hat.obj:0.5", "sweater.obj:0.8")
"""Meshes and stitch widths [cm], from small to large."""
MOST_STITCHES = {"cpu": 200, "cuda": 8000}
"""Largest garment whose true rest is computed."""
TRUE = 1e-5
"""Residual and remaining change of the true rest."""
TRUE_ITERATIONS = {"cpu": 10000, "cuda": 10_000}
"""Largest number of iterations of a garment: those of its true rest, and of its settings."""
COARSE = ("draft", "standard")
"""Settings of garments without a true rest."""


def true_quality(quality: Quality, tolerance: float = TRUE) -> Quality:
    """Return a quality whose result is the true rest of its sampling."""
    return replace(quality, precision="float64", tolerance=tolerance, largest_change=TRUE, max_iterations=200_000)


def swatch_rows(kind: Kind, name: str, device: str) -> Iterator[MeasuredRelaxation]:
    """Measure each setting on a swatch."""
    free = kind == "free cell"

    def made_with(quality: Quality) -> sm.Swatch:
        return sm.swatch(
            name, quality=quality, relax_cell=free, relaxation="frictionless", device=device, progress=False
        )

    try:
        truth = made_with(true_quality(PRESETS["reference"]))
    except StitchMeshError as error:
        note(f"{kind} {name}: {error}")
        return
    for setting, quality in SETTINGS.items():
        if setting == "standard by dynamics" and (free or name != "stockinette"):
            continue
        try:
            made_with(replace(quality, max_iterations=LOADING))
            began = time.perf_counter()
            made = made_with(quality)
            seconds = time.perf_counter() - began
        except StitchMeshError as error:
            note(f"{kind} {name} {setting}: {error}")
            continue
        wrong = spacing_error(made.yarns, truth.yarns) if free else place_error(made, truth)
        yield MeasuredRelaxation(
            kind=kind, scene=resolve_pattern(name).name, setting=setting, stitches=stitches_of(resolve_pattern(name)),
            points=len(made.yarns.points), iterations=made.report["iterations"], seconds=seconds,
            error=wrong if truth.report["converged"] else None, converged=made.report["converged"],
        )  # fmt: skip


def spacing_error(yarns: YarnSet, truth: YarnSet) -> float:
    """Return the larger relative error of the two periods."""
    assert yarns.lattice is not None and truth.lattice is not None
    sizes = [np.linalg.norm(one.lattice.periods, axis=1) for one in (yarns, truth)]
    return float(np.abs(sizes[0] / sizes[1] - 1.0).max())


def place_error(made: sm.Swatch, truth: sm.Swatch) -> float:
    """Return the rms distance of corresponding places across the yarn over the wale spacing."""
    places = [places_of(one.yarns, 16) for one in (made, truth)]
    apart = places[0].points - places[1].points
    apart -= apart.mean(axis=0)
    along = np.concatenate([np.gradient(places[1].points[places[1].yarn == yarn], axis=0)
                            for yarn in np.unique(places[1].yarn)])  # fmt: skip
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    apart -= (apart * along).sum(axis=1, keepdims=True) * along  # yarn that slides along itself has its shape
    rms = float(np.sqrt((apart**2).sum(axis=1).mean()))
    return rms / float(truth.report["wale_spacing"])


def garment_rows(name: str, device: str) -> Iterator[MeasuredRelaxation]:
    """Measure each setting on the yarns of a garment."""
    fabric = Garment.of(name).evened(device)
    kind = "cuda" if device_named(device).is_cuda else "cpu"
    truth = None
    if fabric.face_count <= MOST_STITCHES[kind]:
        tight = replace(true_quality(PRESETS["reference"], 1e-4), max_iterations=TRUE_ITERATIONS[kind])
        yarns = sm.generate_yarns(fabric, quality=tight)
        truth = relax_yarns(yarns, quality=tight, device=device, keep_shape=fabric, run=QUIET)
        note(f"{name}: true rest with a residual of {truth.report['residual']:.2g}")
    for setting, quality in SETTINGS.items():
        if setting not in COARSE and (truth is None or setting == "standard by dynamics"):
            continue
        limited = replace(quality, max_iterations=min(quality.max_iterations, TRUE_ITERATIONS[kind]))
        yarns = sm.generate_yarns(fabric, quality=limited)
        made, seconds = relaxed(yarns, limited, device=device, keep_shape=fabric, run=QUIET)
        yield MeasuredRelaxation(
            kind="garment", scene=name, setting=setting, stitches=fabric.face_count, points=len(yarns.points),
            iterations=made.report["iterations"], seconds=seconds,
            error=None if truth is None else garment_error(fabric, made.yarns, truth.yarns),
            converged=made.report["converged"],
        )  # fmt: skip


def garment_error(fabric: sm.StitchMesh, yarns: YarnSet, truth: YarnSet) -> float:
    """Return the larger relative error of the mean wale and course spacings of a garment."""
    places = [places_of(one, 16) for one in (yarns, truth)]
    found = difference(places[0], places[1], loops_of_fabric(fabric, places[1]), "none", float(yarns.radius.mean()))
    return max(abs(found.wale_error), abs(found.course_error))


def all_rows(given: Options) -> Iterator[MeasuredRelaxation]:
    """Measure swatches and garments in turn, from small to large."""
    for pattern, garment in zip_longest(given.patterns, given.garments):
        try:
            if pattern is not None:
                yield from swatch_rows("free cell", pattern, given.device)
            if pattern in GIVEN:
                yield from swatch_rows("given cell", pattern, given.device)
            if garment is not None:
                yield from garment_rows(garment, given.device)
        except StitchMeshError as error:
            note(f"{pattern}, {garment}: {error}")


@dataclass(frozen=True)
class Options:
    """What is measured."""

    device: str = "cpu"
    tables: Path = TABLES
    patterns: tuple[str, ...] = PATTERNS
    garments: tuple[str, ...] = GARMENTS
    most_seconds: float = float("inf")
    """begin no further row after this time"""
    join: Path | None = None
    """measure nothing, and add the tables of this file"""


def budget_tables(given: Options) -> Rows:
    """Measure, and write the table of the device."""
    if given.join is not None:
        for table in read_tables(given.join):
            write_tables(given.tables, table)
        return
    began, rows = time.perf_counter(), list[MeasuredRelaxation]()
    calibrate(given.device)  # loads kernels
    sm.swatch(
        "stockinette", quality="draft", relax_cell=True, relaxation="frictionless", device=given.device, progress=False
    )
    pace = min(calibrate(given.device) for _ in range(3))
    yield "kind", "scene", "setting", "stitches", "s", "iterations", "error %", ""
    for row in all_rows(given):
        wrong = "" if row.error is None else f"{100 * row.error:.3g}"
        rest = "" if row.converged else "not at rest"
        yield row.kind, row.scene, row.setting, row.stitches, f"{row.seconds:.3g}", row.iterations, wrong, rest
        rows.append(replace(row, seconds=_digits(row.seconds), error=None if row.error is None else _digits(row.error)))
        write_tables(given.tables, table_of(given.device, pace, rows))
        if time.perf_counter() - began > given.most_seconds:
            break


def table_of(device: str, pace: tuple[float, float], rows: list[MeasuredRelaxation]) -> Table:
    """Return the table of a device."""
    return Table(
        device=device_title(device), processor="cuda" if device_named(device).is_cuda else "cpu",
        date=datetime.date.today().isoformat(), version=sm.__version__,
        command=f"python benchmarks/run.py budget-tables --device {device}", pace=(_digits(pace[0]), _digits(pace[1])),
        measurements=tuple(rows),
    )  # fmt: skip


def table_entry(table: Table) -> dict[str, Any]:
    """Return the entry of a table in the file."""
    columns = list(MeasuredRelaxation.__dataclass_fields__)
    own = {name: getattr(table, name) for name in Table.__dataclass_fields__ if name != "measurements"}
    rows = [[getattr(one, name) for name in columns] for one in table.measurements]
    return own | {"columns": columns, "measurements": rows}


def write_tables(path: Path, table: Table) -> None:
    """Write a table into the file, in the place of the one of its device, whose other scenes stay."""
    read_tables.cache_clear()
    tables = read_tables(path) if path.exists() else ()
    others = [one for one in tables if one.device != table.device]
    measured = {(row.kind, row.scene) for row in table.measurements}
    kept = [row for one in tables if one.device == table.device for row in one.measurements
            if (row.kind, row.scene) not in measured]  # fmt: skip
    table = replace(table, measurements=(*kept, *table.measurements))
    path.parent.mkdir(parents=True, exist_ok=True)
    entries = [table_entry(one) for one in sorted([*others, table], key=lambda one: one.device)]
    text = re.sub(r"\[\s+([^][{}]+?)\s+\]", _on_one_line, json.dumps(entries, indent=1))
    path.write_text(text + "\n", encoding="utf-8")


def _on_one_line(found: re.Match[str]) -> str:
    """Return a list of numbers and names on a line of its own."""
    return "[" + " ".join(found[1].split()) + "]"


def _digits(value: float) -> float:
    """Return a value with three digits."""
    return float(f"{value:.3g}")
