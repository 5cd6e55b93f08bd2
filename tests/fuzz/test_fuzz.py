# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Damaged files: each reader returns a value or raises one error of a line; the benchmark finds readers that do not.

``python -m tests.fuzz`` damages the files, with seeds, and counts as faults what docs/robustness.md lists.
"""

from __future__ import annotations

import ast
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from stitchmesh.errors import FileError
from tests.fuzz import SEED
from tests.fuzz import readers as fuzz_readers
from tests.fuzz import run as fuzz_run
from tests.gallery import ROOT

OFTEN = ["obj mesh", "ply", "vtp", "bcc", "pyp", "usda", "smobj", "checkpoint", "recipe", "pattern", "png chart"]
"""Readers of files that users exchange."""


def fuzzed(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run the benchmark in a process of its own, which has few modules."""
    command = [sys.executable, "-m", "tests.fuzz", *words, "-o", str(folder)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True)


def test_damaged_files_of_often_used_readers_cost_an_error_of_one_line(tmp_path):
    ended = fuzzed(tmp_path, *OFTEN, "--inputs", "20", "--seed", "2026")
    assert ended.returncode == 0, ended.stdout + ended.stderr[-2000:]
    assert ended.stdout.count("| 20 |") == len(OFTEN)


@pytest.mark.nightly
@pytest.mark.parametrize("reader", fuzz_readers.READERS)
def test_damaged_files_of_each_reader_cost_an_error_of_one_line_with_another_seed_each_day(tmp_path, reader):
    """35 s for each reader, so that all of them take 20 minutes on two cores."""
    ended = fuzzed(tmp_path, reader, "--inputs", str(10**9), "--seconds", "35", "--seed", SEED)
    assert ended.returncode == 0, ended.stdout + ended.stderr[-2000:]


def test_the_documentation_lists_every_reader_of_the_package_and_of_the_benchmark():
    page = (ROOT / "docs" / "robustness.md").read_text()
    for path in sorted((ROOT / "stitchmesh").rglob("*.py")):
        text = path.read_text()
        for node in ast.parse(text).body if "def read_" in text else []:
            if isinstance(node, ast.FunctionDef) and node.name.startswith("read_"):
                assert f"`{node.name}`" in page, f"{node.name} of {path.name} has no reader in the benchmark"
    assert [name for name in fuzz_readers.READERS if f"| {name} |" not in page] == []


def aborts(path: Path) -> None:
    if b"0" not in path.read_bytes():
        os.abort()


def fills_memory(path: Path) -> None:
    if b"0" not in path.read_bytes():
        bytearray(2**40)


def does_not_end(path: Path) -> None:
    while b"0" not in path.read_bytes():
        time.process_time()


def raises_another_error(path: Path) -> None:
    if b"0" not in path.read_bytes():
        raise KeyError("word")


def refuses_in_two_lines(path: Path) -> None:
    if b"0" not in path.read_bytes():
        error = FileError("one")
        error.args = ("one\ntwo",)
        raise error


@pytest.mark.parametrize(
    ("read", "fault"),
    [
        (aborts, "process: SIGABRT"),
        (fills_memory, "MemoryError"),
        (does_not_end, "process: no end"),
        (raises_another_error, "KeyError"),
        (refuses_in_two_lines, "FileError of 2 lines"),
    ],
)
def test_the_benchmark_finds_a_fault_goes_on_and_keeps_a_small_file(tmp_path, monkeypatch, read, fault):
    reader = fuzz_readers.Reader(".txt", read, lambda folder: [b"word 0 word\n" * 20, b"0 word"])
    monkeypatch.setitem(fuzz_readers.READERS, "broken", reader)
    count = 40
    if read is does_not_end:  # The other faults end by themselves, however busy the machine is.
        monkeypatch.setattr(fuzz_run, "CPU_SECONDS", 0.05)
        count = 10
    found = fuzz_run.fuzz("broken", count, seed=3, processes=2)
    assert found.inputs == count and set(found.outcomes) == {"value", "fault"}
    assert len(found.faults) == 1 and fault in next(iter(found.faults))
    (line,) = fuzz_run.keep_findings(tmp_path, found, 3)
    (kept,) = tmp_path.iterdir()
    assert kept.name in line and "\n" not in line
    assert fuzz_run.outcome_of(reader, kept.read_bytes()) == f"fault {next(iter(found.faults))}"
    assert len(kept.read_bytes()) < 50


def test_the_same_seed_and_number_give_the_same_file():
    reader = fuzz_readers.READERS["obj mesh"]
    seeds = fuzz_run.seeds_of(reader)
    first = [fuzz_run.damaged(reader, seeds, 5, number) for number in range(50)]
    assert first == [fuzz_run.damaged(reader, seeds, 5, number) for number in range(50)]
    assert len(set(first)) > 40 and first != [fuzz_run.damaged(reader, seeds, 6, number) for number in range(50)]
