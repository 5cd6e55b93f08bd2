# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The map of stability: stiffness over eight decades, the radius over four, in each preset.

Each case asks for its end state at once: a free cell of stockinette with loops of 4.17 cm, generated with yarn of
0.125 cm and relaxed in the default material, gets another stiffness or radius. Each case runs in a process with one
thread, and is a line of the file when it has ended; cases that the file holds are not run again. After ``SECONDS`` a
relaxation is stopped and says how far it is from rest. A process that takes ``GRACE`` times as long is ended.

A case is FAILED where a number is not finite, the linking of the yarns has changed, or an error is no StitchMesh error
of one line; the exit status is then 1.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from tyro.conf import Positional

from benchmarks.json_lines import append, read
from benchmarks.own_process import results_of
from benchmarks.table import Rows, note
from stitchmesh.errors import StitchMeshError
from stitchmesh.periodic.relaxation.prepared_swatch import prepare_swatch
from stitchmesh.periodic.relaxation.support import planes
from stitchmesh.run import QUIET
from stitchmesh.time_limit import TimeLimit, limited_to
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns

STIFFNESSES = ("k_len", "k_bend", "k_contact")
STIFFNESS_POWERS = tuple(range(-4, 5))
RADIUS_POWERS = tuple(power / 2 for power in range(-4, 5))
PRESETS = ("draft", "standard", "reference")
RADIUS = 0.125
"""Radius of the yarn with which the cell is generated [cm]."""
PRESSED = 0.5
"""Distance of axes over the radius below which the table names it: the yarns are one inside the other."""
SECONDS = 60.0
"""Limit of each relaxation [s]."""
GRACE = 3
"""Limit of a process over that of a relaxation: the processes also generate the cell and load kernels."""


@dataclass(frozen=True)
class Case:
    """One extreme value in one preset."""

    preset: str
    field: str
    """``radius``, or a stiffness."""
    power: float
    """Power of ten of the factor."""


def cases() -> list[Case]:
    """Return all cases, the fast presets first."""
    powers = [(field, power) for field in STIFFNESSES for power in STIFFNESS_POWERS]
    powers += [("radius", power) for power in RADIUS_POWERS]
    return [Case(preset, field, power) for preset in PRESETS for field, power in powers]


def outcome(case: Case) -> Iterator[dict[str, Any]]:
    """Relax a case within a time in this process, and yield its entry of the file."""
    began = time.perf_counter()
    try:
        report, points = relaxed(case)
        kind = "at rest" if report["converged"] else "not at rest"
        if not np.isfinite([report["residual"], report["energy"], *points.ravel()]).all():
            kind = "FAILED"
        found = {"kind": kind, **report}
    except StitchMeshError as error:
        words = str(error)
        found = {"kind": "FAILED" if "\n" in words else "refused", "words": words}
    except Exception as error:
        found = {"kind": "FAILED", "words": f"{type(error).__name__}: {error}"}
    yield {**asdict(case), **found, "process_seconds": round(time.perf_counter() - began, 2)}


def relaxed(case: Case) -> tuple[dict[str, Any], Any]:
    """Relax the cell of a case, and return its report and its points; ``relax_yarns`` checks the linking."""
    logging.getLogger("stitchmesh").setLevel(logging.ERROR)
    cell = prepare_swatch("stockinette", material=None, quality=case.preset, device="cpu", relax_cell=True,
                          relaxation="frictionless", yarn_radius=RADIUS, loop_length=4.17)  # fmt: skip
    factor, yarns, material, terms = 10.0**case.power, cell.yarns, YarnMaterial.named(), cell.terms
    if case.field == "radius":
        yarns, material = yarns.with_radius(factor * yarns.radius), material.scaled(factor)
        terms = planes(cell.options, cell.flat, yarns.radius)
    else:
        material = replace(material, **{case.field: factor * getattr(material, case.field)})
    with limited_to(TimeLimit(SECONDS)):
        made = relax_yarns(yarns, material=material, quality=cell.quality, device="cpu", cell=cell.cell, terms=terms,
                           run=QUIET)  # fmt: skip
    report = {name: value for name, value in made.report.items() if name not in ("energies", "device", "solver")}
    sizes = [float(sum(number**2 for number in period) ** 0.5) for period in made.yarns.lattice.periods]
    return report | {"periods": sizes}, made.yarns.points


def run_all(path: Path, wanted: list[Case], processes: int) -> None:
    """Run the cases that the file does not hold, and add a line for each."""
    held = {(entry["preset"], entry["field"], entry["power"]) for entry in read(path)}
    missing = [case for case in wanted if (case.preset, case.field, case.power) not in held]
    for case, entries, why in results_of(outcome, missing, processes=processes, limit=GRACE * SECONDS):
        entry = entries[0] if entries else {**asdict(case), "kind": "over time" if "after" in why else "FAILED"}
        append(path, [entry])
        note(f"{entry['preset']} {entry['field']} {entry['power']} {text_of(entry)}")


def text_of(entry: dict[str, Any]) -> str:
    """Return what the table says of a case."""
    if entry["kind"] == "at rest":
        steps = entry["load_steps"]
        pressed = entry["min_distance_over_radius"]
        notes = [] if steps is None else [f"{steps['steps']} steps"]
        notes += [f"axes {pressed:.2g} radii apart"] if pressed < PRESSED else []
        return ", ".join(["at rest", *notes])
    if entry["kind"] != "not at rest":
        return str(entry["kind"])
    left = entry["remaining_change"]
    return f"left {left['spacing']:.1g}" if left is not None else f"residual {entry['residual']:.1g}"


def tables(found: list[dict[str, Any]]) -> Rows:
    """Yield a table for each field."""
    for field in (*STIFFNESSES, "radius"):
        own = {(entry["preset"], entry["power"]): text_of(entry) for entry in found if entry["field"] == field}
        presets = [preset for preset in PRESETS if any(key[0] == preset for key in own)]
        yield ""
        yield field, *presets
        for power in sorted({power for _, power in own}):
            yield f"x {10.0**power:.2g}", *(own.get((preset, power), "") for preset in presets)


@dataclass(frozen=True)
class Options:
    """What is measured."""

    file: Positional[Path] = Path("map.jsonl")
    processes: int = 1


def stability_map(given: Options) -> Rows:
    """Run the map or print its table, and return 1 if a case failed."""
    run_all(given.file, cases(), given.processes)
    found = read(given.file)
    yield from tables(found)
    return int(any(entry["kind"] == "FAILED" for entry in found))
