# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The last resort of the program: one line, a status of its own, and a private file with the traceback."""

from __future__ import annotations

import re
import stat
from pathlib import Path

import pytest

from stitchmesh.cli.commands.library import PatternsCommand
from stitchmesh.cli.main import main


@pytest.mark.parametrize("error", [ZeroDivisionError("by zero"), RecursionError("deep"), PermissionError(13, "denied")])
def test_a_fault_of_the_program_has_its_own_status_and_a_file_with_the_traceback(monkeypatch, capsys, tmp_path, error):
    def run(_command):
        raise error

    monkeypatch.setattr(PatternsCommand, "run", run)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert main(["patterns"]) == 70
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and said.startswith("ProgramFault: this is a fault of the program")
    written = Path(re.search(r"/\S+fault-\w+\.txt", said)[0])
    assert type(error).__name__ in written.read_text() and "Traceback" in written.read_text()
    assert stat.S_IMODE(written.stat().st_mode) == 0o600


@pytest.mark.parametrize(("error", "status"), [(MemoryError(), 2), (KeyboardInterrupt(), 130)])
def test_memory_that_is_short_and_an_interrupt_cost_one_line(monkeypatch, capsys, error, status):
    def run(_command):
        raise error

    monkeypatch.setattr(PatternsCommand, "run", run)
    assert main(["patterns"]) == status
    assert capsys.readouterr().err.count("\n") == 1
