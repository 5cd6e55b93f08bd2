# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of a sweep: a sortable table with pictures, and a plot of two columns, as HTML without a server.

The page holds the columns that differ from job to job. Plotly draws the plot; its script lies beside the page, so that
nothing is loaded from other hosts.
"""

from __future__ import annotations

import json
import re
from importlib.resources import files
from pathlib import Path
from typing import Any

from stitchmesh.io.atomic import write_text
from stitchmesh.io.path_kind import whole_path
from stitchmesh.jobs.sweep.result_table import JOB, KEY, read_table
from stitchmesh.jobs.sweep.row import ERROR, PICTURE, YARNS, titled
from stitchmesh.markup import Markup, joined, markup

PAGE, SCRIPT = "report.html", "plotly.min.js"
MOST_ROWS = 20_000
"""Largest number of rows of a page; the page of a larger sweep shows rows at even distances."""
FIRST = (JOB, PICTURE, ERROR)
"""Columns on the left of the page."""
DIGITS = 6
"""Digits of the numbers of a page; the table on disk has all of them."""


def write_report_page(folder: Path) -> Path:
    """Write the page of a sweep into its folder, and return its path.

    Raises:
        FileError: the folder holds no sweep, or the page cannot be written.
        ParameterError: pyarrow is not installed.
    """
    from plotly.offline import get_plotlyjs

    columns = read_table(folder)
    count = len(columns[JOB])
    shown = range(0, count, -(-count // MOST_ROWS) or 1)
    failed = sum(error is not None for error in columns[ERROR])
    same: dict[str, Any] = {name: values[0] for name, values in columns.items() if _is_constant(name, values, count)}
    content = {
        "columns": {
            titled(name): [_shortened(columns[name][k]) for k in shown]
            for name in (*FIRST, *(name for name in columns if name not in (*FIRST, KEY, *same)))
            if name in columns and name not in same
        },
        "picture": PICTURE, "yarns": YARNS, "error": ERROR, "job": JOB,
    }  # fmt: skip
    left_out = "" if len(shown) == count else f" The page shows {len(shown)} of them, at even distances."
    template = files(__package__).joinpath("page.html").read_text(encoding="utf-8")
    parts = {
        "title": markup("{}", whole_path(folder).name),
        "summary": markup("{}", f"{count} jobs, {failed} failed.{left_out}"),
        "same": joined(map(_same_row, same.items())),
        "content": json.dumps(content, separators=(",", ":")).replace("<", "\\u003c"),
    }
    write_text(folder / SCRIPT, get_plotlyjs())
    write_text(folder / PAGE, re.sub(r"\{\{(\w+)\}\}", lambda place: parts[place[1]], template))
    return folder / PAGE


def _is_constant(name: str, values: list[Any], count: int) -> bool:
    """Whether a column has one value in all rows, or no value in the only row."""
    return name != JOB and (count > 1 or values[0] is None) and all(value == values[0] for value in values)


def _same_row(pair: tuple[str, Any]) -> Markup:
    name, value = pair
    shown = "" if value is None else _shortened(value)
    return markup("<tr><th scope='row'>{}</th><td>{}</td></tr>", titled(name), shown)


def _shortened(value: Any) -> Any:
    """Return a value with as many digits as the page shows."""
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    return [_shortened(part) for part in value] if isinstance(value, list) else value
