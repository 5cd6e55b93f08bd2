# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Every reader on damaged files for a while, with another seed each day: ``make test-nightly``."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.fuzz import SEED
from tests.fuzz.readers import READERS
from tests.gallery import ROOT

SECONDS = "35"
"""Time for each reader [s], so that all of them take 20 minutes on two cores."""


@pytest.mark.nightly
@pytest.mark.parametrize("reader", READERS)
def test_damaged_files_cost_an_error_of_one_line(tmp_path, reader):
    bounds = ["--inputs", str(10**9), "--seconds", SECONDS, "--seed", SEED]
    command = [sys.executable, "-m", "tests.fuzz", reader, *bounds, "-o", str(tmp_path)]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr[-2000:]
