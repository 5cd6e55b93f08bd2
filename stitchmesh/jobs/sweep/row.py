# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The row of a job: its inputs and its measures under short names, as plain numbers, texts and lists of numbers.

An input has the name of its key in a job file, such as ``swatch.gamma``; a measure has its name in ``report.json``.
The units of inputs are declared with the settings, and the units of measures stand here.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, fields, is_dataclass
from functools import cache
from typing import Any

from stitchmesh.jobs.job import SOURCES, Job
from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.recipe.sections import GarmentSettings
from stitchmesh.settings import SETTING, settings_of

ERROR, SECONDS, WORKER, PICTURE, YARNS = "error_text", "job_seconds", "worker", "picture_file", "yarns_file"
"""Columns of every row: the error or None, the time, the process, and the picture and yarn files or None."""
OUTPUTS = ("write_stitches", "write_yarns", "render")
"""Keys of a job that decide no measure."""
NOT_MEASURES = ("stitchmesh", "device", "quality", "options", "job", "budget", "history", "memory")
"""Entries of reports that are inputs, or that describe the work and not its result."""
Row = dict[str, Any]


def inputs_of(job: Job) -> Row:
    """Return the inputs of a job: all keys that a job of its kind has, including defaults."""
    left_out = (*OUTPUTS, "garment", *(name for name in SOURCES if getattr(job, name) is None))
    own = {part.name: _plain(getattr(job, part.name)) for part in fields(job) if part.name not in left_out}
    garment = {} if job.garment is None else asdict(job.garment)
    return dict(_flat(garment | own))


def _plain(value: Any) -> Any:
    """Return a table of a job as a dictionary."""
    return asdict(value) if is_dataclass(value) and not isinstance(value, type) else value


def measures_of(report: Mapping[str, Any]) -> Row:
    """Return the measures of a report."""
    return dict(_flat({name: value for name, value in report.items() if name not in NOT_MEASURES}))


def _flat(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the numbers and texts of nested tables; other values become JSON."""
    for key, value in table.items():
        name = f"{above}{key}"
        if isinstance(value, Mapping):
            yield from _flat(value, f"{name}.")
        elif value is None or isinstance(value, bool | int | float | str):
            yield name, value
        else:
            yield name, json.dumps(value, default=str)


UNITS = {
    **dict.fromkeys(("width", "height", "wale_spacing", "course_spacing", "thickness", "length_cm"), "cm"),
    **dict.fromkeys(("course_tension", "wale_tension", "shear_stress", "tension"), "dyn/cm"),
    **dict.fromkeys(("course_moment", "wale_moment"), "dyn"),
    **dict.fromkeys(("energy", "energy_per_stitch"), "erg"),
    "areal_density": "g/cm^2",
}  # fmt: skip
"""Units of measures by the last part of a name."""
OF_GROUPS = {"energies": "erg", "remaining_change": None, "gauge": "in 10 cm"}
"""Units of all columns of a group; the remaining change is relative."""


@cache
def _units_of_inputs() -> dict[str, str]:
    """Units of the inputs of garments and of swatches, by their names."""
    inputs = {"": GarmentSettings(), "swatch.": SwatchTable(pattern="stockinette")}
    units = {
        f"{above}{path}": part.metadata[SETTING].unit
        for above, settings in inputs.items()
        for path, part, _value in settings_of(settings)
    }
    return {name: unit for name, unit in units.items() if unit}


def unit_of(column: str) -> str | None:
    """Return the unit of a column; None if it has none."""
    if column in _units_of_inputs():
        return _units_of_inputs()[column]
    *groups, last = column.split(".")
    for group in groups:
        if group in OF_GROUPS:
            return OF_GROUPS[group]
    return "s" if last.endswith("seconds") else UNITS.get(last)


def titled(column: str) -> str:
    """Return the name of a column with its unit, such as ``wale_spacing [cm]``."""
    unit = unit_of(column)
    return column if unit is None else f"{column} [{unit}]"
