# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""No extreme case fails: all tables of ``python -m tests.extremes``."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.gallery import ROOT


@pytest.mark.nightly
@pytest.mark.parametrize("kind", ["yarns", "swatches", "cloths"])
def test_every_extreme_is_valid_or_refused_in_one_line(kind):
    command = [sys.executable, "-m", "tests.extremes", kind, "--device", "cpu"]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr[-2000:]
