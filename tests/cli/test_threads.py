# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The option ``--threads``: it sets the threads of one command, and a bad number gives one line."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.cli import main as cli
from stitchmesh.compute import threads
from stitchmesh.io import read_yarns
from tests.cli.calls import refused

SWATCH = ["swatch", "stockinette", "--quality", "draft", "--device", "cpu", "--no-picture", "--max-iterations", "5"]


@pytest.fixture(autouse=True)
def four_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threads, "_choice", threads._Choice())
    monkeypatch.setattr(threads, "core_count", lambda: 4)


def test_a_command_runs_with_its_threads_and_no_more_than_there_are_cores(tmp_path, caplog) -> None:
    for asked, taken in ((1, 1), (500, 4)):
        assert cli.main([*SWATCH, "--threads", str(asked), "-o", str(tmp_path / str(asked))]) == 0
        assert threads.thread_count() == taken
    said = [record.getMessage() for record in caplog.records if record.getMessage().startswith("threads")]
    assert said == ["threads: got 500, but this process may use 4 cores; 4 are taken"]
    one, four = (read_yarns(tmp_path / name / "cell.pyp") for name in ("1", "500"))
    assert np.array_equal(one.points, four.points)
    assert cli.main(["patterns"]) == 0
    assert threads.thread_count() == 1  # that of the environment variable of the tests


def test_a_number_below_one_gives_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    message = refused(capsys, *SWATCH, "--threads", "0", "-o", "nowhere")
    assert message == "ParameterError: threads: got 0; expected a whole number of at least 1\n"
