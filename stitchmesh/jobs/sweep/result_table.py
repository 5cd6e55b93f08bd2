# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The results of a sweep on disk: a file for each finished task, and one table of all rows.

``tasks/KEY.json`` holds the rows of a task by the keys of its jobs. It is written last, so that a task with this file
is certainly finished, even if its worker dies. ``rows.parquet`` has one row for each job of the sweep, in their order;
the metadata of its columns hold their units. ``rows.csv`` is the same table as text, with the units beside the names.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from stitchmesh.errors import FileError, ParameterError, StitchMeshError
from stitchmesh.io.atomic import atomic_path, write_json, write_text
from stitchmesh.io.checked import check_value, read_json
from stitchmesh.io.path_kind import is_file
from stitchmesh.jobs.sweep.parquet_columns import read_columns
from stitchmesh.jobs.sweep.row import ERROR, Row, titled, unit_of
from stitchmesh.jobs.sweep.task import SweepTask, SweptJob

TASKS, TABLE, TEXT_TABLE = "tasks", "rows.parquet", "rows.csv"
"""Folder of the files of finished tasks, and names of the table, in the folder of a sweep."""
UNIT = "unit"
"""Key of the unit in the metadata of a column."""
JOB, KEY = "job_number", "job_key"
"""The first two columns: the number of the job, from 0, and its key."""
REMEDY = "install it by `pip install stitchmesh[sweeps]`"


def task_path(folder: Path, task: SweepTask) -> Path:
    """Return the path of the file of a task."""
    return folder / TASKS / f"{task.key}.json"


def write_rows(folder: Path, task: SweepTask, rows: Mapping[str, Row]) -> None:
    """Write the rows of a finished task, by the keys of its jobs.

    Raises:
        FileError: the file cannot be written.
    """
    write_json(task_path(folder, task), rows)


def read_rows(folder: Path, task: SweepTask) -> dict[str, Row] | None:
    """Return the rows of a task; None if the task is not finished, or its file is damaged."""
    path = task_path(folder, task)
    if not is_file(path):
        return None
    try:
        rows = check_value(read_json(path), dict[str, dict[str, Any]])
    except StitchMeshError:
        return None
    return rows if rows.keys() == {one.key for one in task.jobs} else None


def write_table(folder: Path, jobs: Sequence[SweptJob], rows: Mapping[str, Row]) -> None:
    """Write the table of all present rows.

    A column holds numbers, texts, truth values or lists of numbers, which are JSON in the text. If a job does not have
    a measure, its cell is empty.

    Args:
        folder: folder of the sweep.
        jobs: the jobs, in their order.
        rows: the rows by the keys of the jobs.

    Raises:
        FileError: the table cannot be written.
        ParameterError: pyarrow is not installed.
    """
    import_pyarrow()
    import pyarrow
    from pyarrow import parquet

    full = [{JOB: number, KEY: one.key, **rows[one.key]} for number, one in enumerate(jobs) if one.key in rows]
    names = list(dict.fromkeys(name for row in full for name in row)) or [JOB, KEY, ERROR]
    columns = {name: _column([row.get(name) for row in full]) for name in names}
    table = pyarrow.table(columns)
    fields = [field.with_metadata({UNIT: unit_of(field.name) or ""}) for field in table.schema]
    with atomic_path(folder / TABLE) as temporary, temporary.open("wb") as file:  # its errors are errors of the system
        parquet.write_table(table.cast(pyarrow.schema(fields)), file)
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(map(titled, names))
    for values in zip(*columns.values(), strict=True):
        lines.writerow(["" if value is None else json.dumps(value) if isinstance(value, list) else value
                        for value in values])  # fmt: skip
    write_text(folder / TEXT_TABLE, text.getvalue())


def read_table(folder: Path) -> dict[str, list[Any]]:
    """Read the table of a sweep, by columns.

    Raises:
        FileError: the folder has no table, or the table is damaged.
        ParameterError: pyarrow is not installed.
    """
    import_pyarrow()
    path = folder / TABLE
    if not is_file(path):
        raise FileError(f"{folder}: holds no {TABLE}; expected the folder of a sweep, from `stitchmesh batch`")
    return read_columns(path)


def import_pyarrow() -> None:
    """Import pyarrow.

    Raises:
        ParameterError: pyarrow is not installed.
    """
    try:
        import pyarrow  # noqa: F401
    except ImportError as error:
        raise ParameterError(f"sweeps: the package pyarrow is missing; {REMEDY}") from error


def _column(values: Iterable[Any]) -> list[Any]:
    """Return the values of a column as one kind: whole numbers become numbers, and other mixtures become texts."""
    found = list(values)
    kinds = {type(value) for value in found if value is not None}
    if kinds == {int, float}:
        return [None if value is None else float(value) for value in found]
    if len(kinds) > 1:
        return [None if value is None else value if isinstance(value, str) else json.dumps(value) for value in found]
    return found
