# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The table and the page of a sweep: kinds of columns, what the page holds, and text that does no harm."""

from __future__ import annotations

import csv
import json
import math
import resource

import pytest
from pyarrow import parquet

from stitchmesh.cli.main import main
from stitchmesh.errors import FileError
from stitchmesh.jobs.job import Job
from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.jobs.sweep.report_page import MOST_ROWS, write_report_page
from stitchmesh.jobs.sweep.result_table import TABLE, TEXT_TABLE, UNIT, read_table, write_table
from stitchmesh.jobs.sweep.row import ERROR, titled, unit_of
from stitchmesh.jobs.sweep.task import SweptJob

HARM = "</script><script>alert(1)</script>"


def table_of(folder, rows):
    """Write a table with the given measures."""
    job = Job(swatch=SwatchTable(pattern="stockinette"))
    jobs = [SweptJob(f"key{number}", job) for number in range(len(rows))]
    write_table(folder, jobs, {one.key: {ERROR: None} | row for one, row in zip(jobs, rows, strict=True)})
    return folder


def content_of(page):
    """Return what the script of a page reads."""
    text = page.read_text()
    return json.loads(text.partition('id="content">')[2].partition("</script>")[0])


def test_columns_have_one_kind_each_and_what_a_job_does_not_have_is_missing(tmp_path):
    rows = [{"a": 1, "b": "free", "curve": [0.0, 1.0]}, {"a": 0.1 + 0.2, "b": 2.0}, {"c": True, ERROR: "Failed"}]
    table = read_table(table_of(tmp_path, rows))
    assert table["a"] == [1.0, 0.1 + 0.2, None] and table["b"] == ["free", "2.0", None]
    assert table["curve"] == [[0.0, 1.0], None, None] and table["c"] == [None, None, True]
    assert table["job_number"] == [0, 1, 2] and table[ERROR] == [None, None, "Failed"]


@pytest.mark.parametrize(
    ("column", "unit"),
    [
        ("swatch.yarn_radius", "cm"), ("stretch_course.tension", "dyn/cm"), ("energies.tension", "erg"),
        ("remaining_change.energy", None), ("gauge.rows", "in 10 cm"), ("solver_seconds", "s"), ("swatch.rows", None),
    ],
)  # fmt: skip
def test_a_column_has_the_unit_of_its_measure(column, unit):
    assert unit_of(column) == unit and titled(column) == (column if unit is None else f"{column} [{unit}]")


def test_units_are_in_both_tables_which_hold_the_same(tmp_path):
    rows = [{"width": 1 / 3, "curve": [0.5, 1.0], "shape": "flat"}, {"width": None, ERROR: "a, b"}]
    folder = table_of(tmp_path, rows)
    fields = {field.name: field.metadata[UNIT.encode()].decode() for field in parquet.read_schema(folder / TABLE)}
    assert fields == {name: unit_of(name) or "" for name in read_table(folder)}
    with (folder / TEXT_TABLE).open(newline="") as file:
        first, second = csv.DictReader(file)
    assert float(first["width [cm]"]) == 1 / 3 and json.loads(first["curve"]) == [0.5, 1.0]
    assert (second["width [cm]"], second["shape"], second[ERROR]) == ("", "", "a, b")


def test_a_table_that_the_disk_refuses_is_one_line_and_the_old_table_stays(tmp_path):
    """The limit on the size of a file stands for a full disk; `tests/crashes/refusals.py` fills one."""
    before = table_of(tmp_path, [{"a": 0.5}])
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2000, limits[1]))
    try:
        with pytest.raises(FileError, match=r"rows\.parquet: cannot be written \(File too large\); the") as told:
            table_of(tmp_path, [{"a": math.sin(k)} for k in range(1000)])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert len(str(told.value).splitlines()) == 1 and read_table(before)["a"] == [0.5]
    assert {path.name for path in tmp_path.iterdir()} == {TABLE, TEXT_TABLE}


def test_the_page_holds_what_differs_and_lists_what_does_not(tmp_path):
    page = write_report_page(table_of(tmp_path, [{"same": 7.5, "width": 1 / 3}, {"same": 7.5, "width": None}]))
    columns = content_of(page)["columns"]
    assert columns["width [cm]"] == [0.333333, None] and "same" not in columns and "7.5" in page.read_text()
    assert (tmp_path / "plotly.min.js").stat().st_size > 10**6
    assert "http" not in page.read_text().replace("http-equiv", "")


def test_text_of_jobs_cannot_become_a_script(tmp_path):
    page = write_report_page(table_of(tmp_path, [{"x": HARM, "y": HARM}, {"x": "other", "y": HARM}]))
    assert HARM not in page.read_text() and content_of(page)["columns"]["x"] == [HARM, "other"]


def test_a_page_of_a_large_sweep_shows_rows_at_even_distances(tmp_path):
    page = write_report_page(table_of(tmp_path, [{"width": float(k)} for k in range(2 * MOST_ROWS)]))
    assert content_of(page)["columns"]["width [cm]"] == [float(k) for k in range(0, 2 * MOST_ROWS, 2)]


def test_folders_without_a_sweep_and_damaged_tables_are_errors_of_one_line(tmp_path, capsys):
    with pytest.raises(FileError, match=r"holds no rows.parquet; expected the folder of a sweep"):
        read_table(tmp_path)
    (tmp_path / TABLE).write_bytes(b"PAR1 no table PAR1")
    assert main(["batch", "report", str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert main(["batch", "report"]) == 2
    assert "got no folder" in capsys.readouterr().err
