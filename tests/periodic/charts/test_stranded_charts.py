# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Random stranded charts: their numbers, their outcomes, and that all come to rest or have a float that is too long."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.fuzz import SEED
from tests.gallery import ROOT


@pytest.mark.nightly
def test_charts_of_a_night_come_to_rest_or_have_a_float_that_is_too_long():
    options = ["--device", "cpu", "--count", "60", "--seed", SEED]
    command = [sys.executable, "-m", "tests.periodic.charts.stranded_charts", *options]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr[-2000:]
