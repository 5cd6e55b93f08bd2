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


def test_a_command_runs_with_its_threads_and_gives_the_same_yarns(tmp_path) -> None:
    for count in (1, 3):
        assert cli.main([*SWATCH, "--threads", str(count), "-o", str(tmp_path / str(count))]) == 0
        assert threads.thread_count() == count
    one, three = (read_yarns(tmp_path / name / "cell.pyp") for name in ("1", "3"))
    assert np.array_equal(one.points, three.points)
    assert cli.main(["patterns"]) == 0
    assert threads.thread_count() == 1  # that of the environment variable of the tests


def test_a_number_below_one_gives_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    message = refused(capsys, *SWATCH, "--threads", "0", "-o", "nowhere")
    assert message == "ParameterError: threads: got 0; expected a whole number of at least 1\n"


def test_more_threads_than_cores_are_replaced_in_one_line(tmp_path, caplog: pytest.LogCaptureFixture) -> None:
    assert cli.main([*SWATCH, "--threads", "500", "-o", str(tmp_path)]) == 0
    said = [record.getMessage() for record in caplog.records if record.getMessage().startswith("threads")]
    assert said == ["threads: got 500, but this process may use 4 cores; 4 are taken"]
