# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The runner of measures: its tables, its exit status, and what it says of a name that it does not know."""

from __future__ import annotations

import pytest

from benchmarks.json_lines import append, read
from benchmarks.own_process import results_of
from benchmarks.run import main, named
from benchmarks.table import show


def measure(status=None):
    yield "first"
    yield "name", "value"
    yield "a", 1
    yield ["b", 2.5]
    yield ""
    yield "other", ""
    yield "last"
    return status


def test_rows_are_a_table_of_markdown_whose_first_row_holds_the_titles(capsys):
    assert show(measure()) == 0
    table = "| name | value |\n|---|---|\n| a | 1 |\n| b | 2.5 |\n"
    assert capsys.readouterr().out == f"first\n{table}\n| other |  |\n|---|---|\n\nlast\n"


def test_the_status_is_what_the_measure_returns():
    assert show(measure(1)) == 1


def test_a_measure_begins_when_its_first_row_is_taken():
    assert next(named(["latency", "captures"])).startswith("Python")


def test_an_unknown_name_is_refused_in_one_line():
    with pytest.raises(SystemExit, match=r"got .nothing.; expected a measure that `python benchmarks/run\.py --list`"):
        main(["nothing"])


def test_the_list_has_a_line_for_each_measure(capsys):
    assert main(["--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) > 40 and all(len(line.split()) > 3 for line in lines)


def parts(case):
    yield case
    raise ValueError(case)


def test_a_case_in_a_process_of_its_own_sends_its_parts_and_says_why_it_ended():
    assert list(results_of(parts, ["faulty"])) == [("faulty", ["faulty"], "status 1")]


def test_lines_are_added_to_a_file_and_read_from_several(tmp_path):
    append(tmp_path / "new" / "one.jsonl", [{"a": 1}, {"a": 2}])
    append(tmp_path / "new" / "one.jsonl", [{"a": 3}])
    assert read(tmp_path / "new" / "one.jsonl", tmp_path / "none.jsonl") == [{"a": 1}, {"a": 2}, {"a": 3}]
