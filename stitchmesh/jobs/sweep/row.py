# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The row of a job: its inputs and its measures under short names, as plain numbers, texts and lists of numbers.

An input has the name of its key in a job file, such as ``swatch.gamma``; a measure has its name in ``report.json``.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, fields, is_dataclass
from typing import Any

from stitchmesh.jobs.job import SOURCES, Job

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
